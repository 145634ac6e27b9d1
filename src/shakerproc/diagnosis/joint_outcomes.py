"""What a diagnosis says of a joint without a law: it never slipped, or has a free law."""

from dataclasses import dataclass
from typing import Any, final


@final
@dataclass(frozen=True, slots=True)
class Locked:
    """A joint that never slipped.

    Attributes
    ----------
    between : (str, str)
        The joint.
    holds : float
        The largest force that it carried without slipping [N].
    """

    between: tuple[str, str]
    holds: float

    def as_json(self) -> dict[str, Any]:
        """Return the part of the document."""
        return {
            "between": list(self.between),
            "holds_at_least": {"value": self.holds, "unit": "N"},
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
    """

    between: tuple[str, str]
    displacement: tuple[float, ...]
    velocity: tuple[float, ...]
    force: tuple[tuple[float, ...], ...]
    band: tuple[tuple[float, ...], ...]

    def as_json(self) -> dict[str, Any]:
        """Return the part of the document."""
        return {
            "between": list(self.between),
            "displacement_m": list(self.displacement),
            "velocity_m_per_s": list(self.velocity),
            "force_n": [list(row) for row in self.force],
            "band_n": [list(row) for row in self.band],
        }
