"""Which effect would explain the departure, how surely, and which test would settle it."""

from shakerproc.diagnosis.api import diagnose, diagnose_arrays, diagnose_tests
from shakerproc.diagnosis.data import TestArrays
from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.result import Diagnosis, Finding

__all__ = [
    "Diagnosis",
    "Estimate",
    "Finding",
    "TestArrays",
    "diagnose",
    "diagnose_arrays",
    "diagnose_tests",
]
