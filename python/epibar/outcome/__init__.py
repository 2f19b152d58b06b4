"""What came out of ``epibar calibrate``: what its calibration.json says, and the same read back.

A :class:`Run` is cameras and pairs with F, verdict and frontier points, from the folder of a run or from
results in memory. Evaluation and exports start from it.
"""

from .run import Pair, Run, RunCamera

__all__ = ["Pair", "Run", "RunCamera"]
