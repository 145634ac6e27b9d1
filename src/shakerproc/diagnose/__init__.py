"""Which effect would explain the departure, how surely, and which test would settle it."""

from shakerproc.diagnose.diagnosing import diagnose_arrays
from shakerproc.diagnose.from_files import diagnose
from shakerproc.diagnosis.data import TestArrays
from shakerproc.diagnosis.result import Diagnosis, Estimate, Finding

__all__ = ["Diagnosis", "Estimate", "Finding", "TestArrays", "diagnose", "diagnose_arrays"]
