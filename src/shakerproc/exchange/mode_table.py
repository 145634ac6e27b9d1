"""Modes of a body at many places, as other programs write and read them."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final, Literal, TypeAlias, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.geometry import Place
from shakerproc.units import quoted

COMPONENTS: Final = ("x", "y", "z", "about x", "about y", "about z")
"""Three translations and three rotations of a node."""

FREQUENCY: Final = "frequency_hz"
DAMPING: Final = "damping_ratio"
PARTICIPATION: Final = "participation"
"""Columns of a table that are no places."""

Stated: TypeAlias = Literal["SI", "nothing", "no units"]


@final
@dataclass(frozen=True, eq=False)
class ModeTable:
    """Modes of a file.

    Attributes
    ----------
    places : tuple of str
        Columns of the table, or nodes with their directions, such as ``12/z``.
    frequencies : (n_modes,) array
        0 of rigid-body modes [Hz].
    shapes : (n_places, n_modes) array
        Normalised for a unit mass of the file.
    damping_ratios : (n_modes,) array, optional
        None where the file has none [-].
    participations : mapping of str to (n_modes,) array
        In an acceleration of the base along ``x``, ``y`` or ``z``, or, of the empty string,
        along the one direction there is [root of its unit of mass].
    positions : mapping of str to (x, y, z)
        Of places, where the file holds nodes with coordinates [m, or its unit of length].
    units : {"SI", "nothing", "no units"}
        ``SI`` where the file states its units, from which these are converted; ``nothing``
        where it could and does not, and kg and m are meant; ``no units`` where its format
        has no room for them.
    """

    places: tuple[str, ...]
    frequencies: FloatArray
    shapes: FloatArray
    damping_ratios: FloatArray | None = None
    participations: Mapping[str, FloatArray] = field(default_factory=dict)
    positions: Mapping[str, Place] = field(default_factory=dict)
    units: Stated = "nothing"

    @property
    def axes(self) -> set[str]:
        """Directions in which places are seen; empty of a place that has none."""
        return {split_place(place)[1] for place in self.places}

    @cached_property
    def row_of(self) -> dict[str, int]:
        """Row of each place."""
        return {place: row for row, place in enumerate(self.places)}

    def no_place(self, place: str) -> str:
        """Return the end of a sentence on a place that is none of these."""
        some = ", ".join(self.places[:6]) + (" ..." if len(self.places) > 6 else "")
        return f"has no place {quoted(place)}; it has {some}"

    def in_si(self, mass: float, length: float | None) -> "ModeTable":
        """Return the modes for a unit mass of a kilogram, at positions in metres.

        Parameters
        ----------
        mass, length : float
            Units in which the file is [kg] and [m]; without a length it has no positions.
        """
        root = np.sqrt(mass)
        scaled = {
            place: (length * x, length * y, length * z)
            for place, (x, y, z) in self.positions.items()
            if length is not None
        }
        return replace(
            self,
            shapes=self.shapes / root,
            participations={axis: v * root for axis, v in self.participations.items()},
            positions=scaled,
            units="SI",
        )


def split_place(place: str) -> tuple[str, str]:
    """Return node and direction of a place, such as -z; empty where it has none."""
    node, _, axis = place.rpartition("/")
    return (node, axis) if node and axis.removeprefix("-") in COMPONENTS else (place, "")
