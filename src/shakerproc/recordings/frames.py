"""Numbers that stand in a file as they are, one frame after the other: read when asked for."""

import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, BinaryIO, Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.errors import RecordingError

WHOLE: Final = slice(None)


@final
@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """An array of one or two axes in an open file, sliced like one in memory.

    Attributes
    ----------
    run : str
        Name of the run, for messages.
    file : BinaryIO
        The open file.
    first : int
        Byte of the first number.
    shape : tuple of int
        Length along every axis; the last one advances from number to number.
    stored : numpy.dtype
        Type of a number in the file.
    decoded : callable, optional
        From numbers of the file to values [as the format says].
    kind : numpy.dtype, optional
        Type of a value, where it is another than that of a number in the file.
    """

    run: str
    file: BinaryIO
    first: int
    shape: tuple[int, ...]
    stored: "np.dtype[Any]"
    decoded: Callable[[NDArray[Any]], NDArray[Any]] | None = None
    kind: "np.dtype[Any] | None" = None

    @property
    def dtype(self) -> "np.dtype[Any]":
        """Type of a value."""
        return self.stored if self.kind is None else self.kind

    @property
    def size(self) -> int:
        """How many values there are."""
        return math.prod(self.shape)

    def __getitem__(self, key: Any, /) -> NDArray[Any]:
        keys = key if isinstance(key, tuple) else (key,)
        rows, columns = (*(WHOLE if k is Ellipsis else k for k in keys), WHOLE)[:2]
        if isinstance(rows, int):
            return self._piece(rows, columns)
        start, stop, _ = rows.indices(self.shape[0])
        width = self.shape[1] if len(self.shape) == 2 else 1
        numbers = self._numbers(start * width, max(0, stop - start) * width)
        frames = numbers.reshape(-1, *self.shape[1:])
        return frames if columns == WHOLE else frames[:, columns]

    def _piece(self, row: int, columns: slice) -> NDArray[Any]:
        """Return a slice of one row of an array that is written row by row."""
        start, stop, _ = columns.indices(self.shape[1])
        return self._numbers(row * self.shape[1] + start, max(0, stop - start))

    def _numbers(self, first: int, count: int) -> NDArray[Any]:
        """Return numbers one after the other.

        Raises
        ------
        RecordingError
            If the file has become shorter.
        """
        if self.file.closed:
            raise RecordingError(f"{self.run}: the recording is closed. Open it again.")
        raw = np.empty(count, self.stored)
        self.file.seek(self.first + first * self.stored.itemsize)
        if self.file.readinto(raw.view(np.uint8)) != raw.nbytes:  # type: ignore[attr-defined]
            size = os.fstat(self.file.fileno()).st_size
            raise RecordingError(
                f"{self.run}: the file has become shorter, {size} bytes, while it was read. "
                "Wait until nothing changes it any more, then call again."
            )
        return raw if self.decoded is None else self.decoded(raw)
