"""All pairs of many cameras, on this machine or on others: what is kept, what runs where, what is written.

:func:`calibrate_all` is the job; :func:`dask_executor` lets it run on Dask; a :class:`Watch` follows it.
"""

from .all_pairs import AllPairs, calibrate_all
from .dask import dask_executor
from .pace import JobProgress, Row
from .watch import Watch

__all__ = ["AllPairs", "JobProgress", "Row", "Watch", "calibrate_all", "dask_executor"]
