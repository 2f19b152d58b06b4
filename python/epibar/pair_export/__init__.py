"""Pairs of a run as files of other programs: ``formats.py`` lists them, each in a module of its own.

``placed.py`` writes the cameras of a run without a network, as its pairs place them: ``placing.py``.
"""
