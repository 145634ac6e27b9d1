"""Specimens, the shaker, instruments."""

from dataclasses import dataclass
from typing import final

from shakerproc.data import told_days


@final
@dataclass(frozen=True, slots=True)
class Shaker:
    """Limits of the shaker, zero to peak; None is not known.

    Attributes
    ----------
    stroke : float, optional
        Travel of the table from end to end [m].
    velocity : float, optional
        [m/s].
    acceleration : float, optional
        [m/s²].
    force : float, optional
        [N].
    moving_mass : float, optional
        Armature, fixture and specimen, which the force has to move [kg].
    """

    stroke: float | None = None
    velocity: float | None = None
    acceleration: float | None = None
    force: float | None = None
    moving_mass: float | None = None


@final
@dataclass(frozen=True, slots=True)
class Specimen:
    """Measured dimensions of a coupon and the bushing it was tested with.

    Attributes
    ----------
    joint, name : str
        As the tests name it.
    nominal : float, optional
        Clearance on the drawing, hole less bushing [m].
    actual : float, optional
        Clearance as measured, hole less bushing [m]; play either way is half of it.
    actual_axial : float, optional
        Play out of plane as measured, bushing less coupon thickness [m].
    material, comment : str
        What else is known.
    """

    joint: str
    name: str
    nominal: float | None = None
    actual: float | None = None
    actual_axial: float | None = None
    material: str = ""
    comment: str = ""


@final
@dataclass(frozen=True, slots=True)
class Instrument:
    """An instrument and its calibration.

    Attributes
    ----------
    name : str
        What it is.
    serial : str
        Its serial number.
    calibrated, valid_until : str
        Days, as 2026-03-31; empty where the log says none.
    """

    name: str
    serial: str = ""
    calibrated: str = ""
    valid_until: str = ""

    @property
    def told(self) -> str:
        """A sentence part for people."""
        serial = f", serial number {self.serial}" if self.serial else ""
        return f"{self.name}{serial}{told_days(self.calibrated, self.valid_until)}"
