"""Cameras in one world as the files of other programs, each written from one table of cameras.

The table is a list of :class:`~epibar.Intrinsics` with rotations and translations; :mod:`.formats` lists the
formats.
"""
