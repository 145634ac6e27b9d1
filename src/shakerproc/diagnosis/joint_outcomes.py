"""Findings beside effects: locked joints, a free law, further modes."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

from shakerproc.diagnosis.data import PreparedTest
from shakerproc.diagnosis.estimation.linear_response import DrivenMode
from shakerproc.models import Element, Mode
from shakerproc.models.effects import Table
from shakerproc.models.motion import Motion
from shakerproc.numerals import numeral


@final
@dataclass(frozen=True, slots=True)
class Locked:
    """A joint that never slipped.

    Attributes
    ----------
    between : (str, str)
        The joint.
    holds : float
        The largest force that it carried without slipping [unit].
    unit : str
        SI unit of that: N, or N m of a rotation.
    """

    between: tuple[str, str]
    holds: float
    unit: str = "N"

    def as_json(self) -> dict[str, Any]:
        """Return the part of the document."""
        return {
            "between": list(self.between),
            "holds_at_least": {"value": self.holds, "unit": self.unit},
        }


@final
@dataclass(frozen=True, slots=True)
class Outside:
    """The force that no effect of the library has, as a curve.

    Attributes
    ----------
    between : (str, str)
        The joint.
    displacement, velocity : tuple of float
        Nodes [m], [m/s].
    force, band : tuple of tuple of float
        Missing force and its standard error at each displacement and velocity [N].
    motion : Motion
        Of a rotation these are angles [rad], their velocities and torques [N m].
    """

    between: tuple[str, str]
    displacement: tuple[float, ...]
    velocity: tuple[float, ...]
    force: tuple[tuple[float, ...], ...]
    band: tuple[tuple[float, ...], ...]
    motion: Motion = "translation"

    def element(self) -> Element:
        """Return the curve as an element of a model."""
        return Element(
            Table(self.displacement, self.velocity, self.force, self.band), self.between
        )

    def as_json(self) -> dict[str, Any]:
        """Return the part of the document."""
        return {
            "between": list(self.between),
            "displacement_m": list(self.displacement),
            "velocity_m_per_s": list(self.velocity),
            "force_n": [list(row) for row in self.force],
            "band_n": [list(row) for row in self.band],
        }


@final
@dataclass(frozen=True, slots=True)
class FurtherMode:
    """A linear mode beyond those of the model's masses and joints (see `Mode`).

    Attributes
    ----------
    frequency : float
        Natural frequency [Hz].
    damping_ratio : float
        [-].
    mass : float
        Effective mass [kg].
    participation : mapping of str to float
        Of the masses of the model [-].
    """

    frequency: float
    damping_ratio: float
    mass: float
    participation: Mapping[str, float]

    @classmethod
    def of(cls, mode: Mode) -> "FurtherMode":
        """Return a mode of a model."""
        return cls(mode.frequency, mode.damping_ratio, mode.mass, dict(mode.participation))

    def as_json(self) -> dict[str, Any]:
        """Return the part of the document."""
        return {
            "frequency_hz": self.frequency,
            "damping_ratio": self.damping_ratio,
            "mass_kg": self.mass,
            "participation": dict(self.participation),
        }


def mode_notes(
    modes: Sequence[FurtherMode], driven: Sequence[DrivenMode], tests: Sequence[PreparedTest]
) -> list[str]:
    """Return which further modes of tests were fitted, and which taken away, if any."""
    fitted = f"Fitted as linear: {_modes_at(modes)}."
    driven_to = max(test.arrays.band[1] for test in tests)
    away = (
        f"Taken out of the responses: {_modes_at(driven, driven_to)}, which the drive alone "
        "excites. Errors of `compare` contain what that adds."
    )
    return [*[fitted] * bool(modes), *[away] * bool(driven)]


def _modes_at(modes: Sequence[FurtherMode | DrivenMode], highest: float = math.inf) -> str:
    """Return where modes lie; of those above the highest [Hz] their skirt alone tells."""
    said = " and ".join(
        f"at {numeral(f, 4)} Hz" if f <= highest else f"above {numeral(highest)} Hz"
        for f in sorted(mode.frequency for mode in modes)
    )
    return f"{'a further mode' if len(modes) == 1 else 'further modes'} {said}"
