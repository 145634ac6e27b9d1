"""Which effect would explain the departure, how surely, and which test would settle it."""

from shakerproc.diagnose.diagnosing import diagnose_arrays
from shakerproc.diagnose.from_files import diagnose
from shakerproc.diagnose.prepare import TestArrays
from shakerproc.diagnose.result import Diagnosis, Estimate, Finding

__all__ = ["Diagnosis", "Estimate", "Finding", "TestArrays", "diagnose", "diagnose_arrays"]
