"""The models whose evidence is drawn, beside each other, and which tests are shown."""

import contextlib
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shakerproc.comparison import Comparison, JointMotion, TestComparison
from shakerproc.data import FloatArray
from shakerproc.numerals import numeral

MEASURED, BEFORE, AFTER, NOISE = 7, 1, 0, 6
"""Styles: a broad grey line, a dashed one, a thin one, and the noise floor."""

SHOWN: Final = 4
"""Tests whose response functions are drawn, the levels spread out."""

_PARTS: Final = 60
"""Parts of a range, from each of which as many samples are drawn."""


@dataclass(frozen=True, slots=True, eq=False)
class Models:
    """A model compared with a campaign, and if there is one, its successor.

    Attributes
    ----------
    before : Comparison
        With the model as it was.
    after : Comparison, optional
        With the new one, against the same tests.
    old, new : str
        What the two are called.
    """

    before: Comparison
    after: Comparison | None = None
    old: str = "model as it was"
    new: str = "new model"

    @property
    def each(self) -> list[tuple[str, int, Comparison]]:
        """Name, style and comparison of each model."""
        both = [(self.old, BEFORE, self.before)]
        return both if self.after is None else [*both, (self.new, AFTER, self.after)]

    @property
    def noise(self) -> list[float]:
        """Noise of every test, through the better model: what a contact makes of it counts."""
        return [test.noise for test in (self.after or self.before).tests]


def label(test: TestComparison) -> str:
    """Return number and level of a test, and whether it was held out."""
    level = level_of(test)
    kept = ", held out" if test.measured.test.hold_out else ""
    return f"test {test.measured.name}{f', {level}' if level else ''}{kept}"


def level_of(test: TestComparison) -> str:
    """Return the level of a test as the log has it, in four digits at most."""
    number, _, unit = test.measured.test.level_text.partition(" ")
    with contextlib.suppress(ValueError):
        number = numeral(float(number), 4)
    return f"{number} {unit}".strip().replace("^2", "²")


def same_joint(test: TestComparison, between: tuple[str, str]) -> JointMotion | None:
    """Return force and motion of the joint between two places, in this direction."""
    for joint in test.joints:
        if joint.between == between:
            return joint
        if joint.between == between[::-1]:
            return replace(
                joint,
                between=between,
                displacement=-joint.displacement,
                velocity=-joint.velocity,
                force=-joint.force,
                force_model=-joint.force_model,
            )
    return None


def capitalised(text: str) -> str:
    """Return text as the start of a sentence."""
    return f"{text[0].upper()}{text[1:]}"


def by_input(comparison: Comparison) -> list[int]:
    """Return the tests from the smallest input to the largest."""
    return sorted(range(len(comparison.tests)), key=lambda i: input_rms(comparison, i))


def input_rms(comparison: Comparison, index: int) -> float:
    """Return the rms of the input of a test [m/s^2 or N]."""
    return float(np.sqrt(np.mean(comparison.tests[index].prediction.input ** 2)))


def spread_out(comparison: Comparison) -> list[int]:
    """Return a few tests from the quietest to the loudest, one held out among them."""
    rising = by_input(comparison)
    if len(rising) <= SHOWN:
        return rising
    chosen = [rising[round(i)] for i in np.linspace(0, len(rising) - 1, SHOWN)]
    kept = [i for i in rising if comparison.tests[i].measured.test.hold_out]
    if kept and not set(kept) & set(chosen):
        chosen[2] = kept[len(kept) // 2]
    return chosen


def unit_of_sensor(comparison: Comparison, sensor: str) -> str:
    """Return the unit of a response function of a sensor, over that of the drive."""
    unit = comparison.model.sensor_unit(comparison.model.sensors[sensor])
    drive = comparison.model.drive_unit
    over = "/".join(f"({one})" if "/" in one or " " in one else one for one in (unit, drive))
    return "-" if unit == drive else over.replace("^2", "²")


def deciding(comparison: Comparison) -> int:
    """Return the loudest test that was held out, or the loudest of all."""
    rising = by_input(comparison)
    kept = [i for i in rising if comparison.tests[i].measured.test.hold_out]
    return (kept or rising)[-1]


def loudest(comparison: Comparison) -> int:
    """Return the test with the largest input."""
    return by_input(comparison)[-1]


def evenly(values: FloatArray, count: int) -> NDArray[np.int_]:
    """Return indices of about so many samples, as many from each part of the range."""
    limits = np.linspace(values.min(), values.max(), _PARTS + 1)
    which = np.clip(np.searchsorted(limits, values) - 1, 0, _PARTS - 1)
    chosen = []
    for part in range(_PARTS):
        inside = np.flatnonzero(which == part)
        chosen.append(inside[:: max(1, inside.size * _PARTS // count)])
    return np.concatenate(chosen)
