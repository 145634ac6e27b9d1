"""Variables of an open HDF5 file: numbers that are read a slice at a time, and texts."""

import math
from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np

from shakerproc.errors import RecordingError
from shakerproc.recordings.guard import AGAIN, foreign, shown

DEEPEST: Final = 8
"""How far groups may stand in each other."""

_PACKED: Final = 1040
"""Times that packing makes numbers smaller at most: deflate reaches 1032."""

_LARGEST_CHUNK: Final = 1 << 28
"""Bytes that are unpacked at once at most."""


@final
@dataclass(frozen=True, slots=True)
class Stored:
    """A variable of an open HDF5 file; what cannot be read of it is an error that names it.

    Attributes
    ----------
    run : str
        Name of the run, for messages.
    name : str
        Where it stands.
    item : h5py.Dataset
        The variable.
    scale, offset : float
        What makes values of its numbers, by the conventions of netCDF.
    fill : float, optional
        Stands where nothing was written.
    """

    run: str
    name: str
    item: Any
    scale: float = 1.0
    offset: float = 0.0
    fill: float | None = None

    @property
    def shape(self) -> tuple[int, ...]:
        """Length along every axis."""
        return tuple(self.item.shape)

    @property
    def dtype(self) -> "np.dtype[Any]":
        """Type of a number."""
        plain = (self.scale, self.offset, self.fill) == (1.0, 0.0, None)
        kind: np.dtype[Any] = self.item.dtype if plain else np.dtype(np.float64)
        return kind

    def __getitem__(self, key: Any, /) -> Any:
        with foreign(self.run, f"reading variable {shown(self.name)}"):
            raw = self.item[key]
        if self.dtype == self.item.dtype and self.fill is None:
            return raw
        values = raw * self.scale + self.offset
        return values if self.fill is None else np.where(raw == self.fill, np.nan, values)


def is_readable(item: Any) -> bool:
    """Return whether a dataset lies in this file, in pieces that fit into memory."""
    if item.shape is None or item.is_virtual or item.external:
        return False
    chunk = math.prod(item.chunks) if item.chunks else 0
    width = int(item.dtype.itemsize)
    stored = int(item.id.get_storage_size())
    return chunk * width <= _LARGEST_CHUNK and math.prod(item.shape) * width <= _PACKED * stored


def check_kind(kind: Any, run: str, what: str) -> None:
    """Pass numbers of a type that processors have, which HDF5 need not convert.

    A damaged header says another exponent, say.

    Parameters
    ----------
    kind : h5py.h5d.DatasetID or h5py.h5a.AttrID
        What the numbers belong to.
    run : str
        Name of the run, for messages.
    what : str
        What it is, for messages.

    Raises
    ------
    RecordingError
        If they are of no such type.
    """
    import h5py

    if h5py.h5t.py_create(kind.dtype) != kind.get_type():
        raise RecordingError(
            f"{run}: {what} is stored as numbers of a kind that no program writes, which is "
            f"damage. {AGAIN}"
        )


def check_variable(item: Any, run: str, name: str) -> None:
    """Pass a data set whose numbers are what its header says.

    Raises
    ------
    RecordingError
        If they are of no type of a processor, or others are stored than it says.
    """
    check_kind(item.id, run, f"variable {shown(name)}")
    size, stored = item.size * item.dtype.itemsize, int(item.id.get_storage_size())
    if not item.chunks and size != stored:
        raise RecordingError(
            f"{run}: variable {shown(name)} says it holds {size} bytes, but {stored} are "
            f"stored. {AGAIN}"
        )
