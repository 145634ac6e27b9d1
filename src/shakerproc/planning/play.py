"""The play of the joint in a test, along the axis that is shaken, at a temperature."""

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, final

from shakerproc.finite_elements.thermal import ThermalFit, clearances_at
from shakerproc.testlog import Test

Which: TypeAlias = Literal["actual", "nominal"]


@final
@dataclass(frozen=True, slots=True)
class Play:
    """Total way of the part from one stop to the other.

    Attributes
    ----------
    total : float
        Hole less bushing, or length of the bushing less thickness; not below 0 [m].
    says : str
        Where it comes from.
    """

    total: float
    says: str

    @property
    def half(self) -> float:
        """Free play to each side of the middle, the `clearance` of a gap [m]."""
        return 0.5 * self.total


@final
@dataclass(frozen=True, slots=True)
class Warming:
    """How the coupon's joint expands.

    Attributes
    ----------
    fit : ThermalFit
        Hole and insert with their materials, in plane.
    thickness : float
        Of the coupon, for the play out of plane [m].
    change : float
        Temperature less that of the measured sizes [K].
    """

    fit: ThermalFit
    thickness: float
    change: float


def play_of_test(
    test: Test, which: Which = "actual", warming: Warming | None = None
) -> Play | None:
    """Return the play along the shaken axis, None where the log does not say it.

    As measured where it was measured: in plane that of hole and bushing, out of plane that of
    the bushing's length and the coupon's thickness. Else the nominal clearance.
    """
    axial = test.orientation.lower().replace("-", " ").startswith("out of plane")
    play = _play_as_measured(test, axial=axial) if which == "actual" else None
    if play is None:
        if test.clearance is None:
            return None
        play, axial = Play(test.clearance, "nominal"), False
    return play if warming is None else _warmed(play, warming, axial=axial)


def _play_as_measured(test: Test, *, axial: bool) -> Play | None:
    if axial and test.actual_axial_clearance is not None:
        return Play(test.actual_axial_clearance, "measured out of plane")
    if test.actual_clearance is not None:
        return Play(test.actual_clearance, "measured")
    return None


def _warmed(play: Play, warming: Warming, *, axial: bool) -> Play:
    """Return the play at another temperature.

    Out of plane the bushing is the opening and the coupon the insert.
    """
    fit = warming.fit
    if axial:
        size = warming.thickness
        fit = ThermalFit(size + play.total, size, fit.insert_expansion, fit.opening_expansion)
    else:
        fit = replace(fit, opening=fit.insert + play.total)
    total = clearances_at(fit, warming.change).play
    return Play(max(0.0, total), f"{play.says}, {warming.change:+.4g} K")
