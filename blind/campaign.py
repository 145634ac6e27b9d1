"""A hidden campaign: what a diagnosis gets, and the truth it does not get."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from blind.excitations import SAMPLE_RATE, Drive
from blind.structures import Structure


@dataclass(frozen=True)
class TestRun:
    """One test: the drive, and what each channel records [SI]."""

    __test__ = False
    number: int
    drive: Drive
    hold_out: bool
    control: np.ndarray
    response: np.ndarray
    clean: np.ndarray


@dataclass(frozen=True)
class Campaign:
    """Everything a diagnosis gets, and the truth it does not get."""

    seed: int
    kind: str
    structure: Structure
    nominal: Structure
    tests: tuple[TestRun, ...]
    truth: dict[str, Any]
    noise_floor: float
    details: dict[str, Any] = field(default_factory=dict)
    rate: float = SAMPLE_RATE
