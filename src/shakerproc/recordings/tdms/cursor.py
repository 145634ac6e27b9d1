"""Read numbers and text out of a block of metadata without ever leaving it."""

import struct

from shakerproc.recordings.guard import shown
from shakerproc.recordings.tdms.types import StructureError


class Cursor:
    """A place in a block of metadata that only moves forward.

    Parameters
    ----------
    block : bytes
        The metadata of one segment.
    place : int
        Byte of the file at which the block starts, for messages.
    endian : str
        ``<`` or ``>``.
    """

    def __init__(self, block: bytes, place: int, endian: str) -> None:
        self._block = block
        self._start = place
        self._position = 0
        self._endian = endian

    @property
    def endian(self) -> str:
        """Byte order of the block."""
        return self._endian

    @property
    def place(self) -> int:
        """Byte of the file that comes next."""
        return self._start + self._position

    def skip(self, size: int, what: str) -> bytes:
        """Return the next bytes.

        Raises
        ------
        StructureError
            If the block ends before them.
        """
        end = self._position + size
        if end > len(self._block):
            left = len(self._block) - self._position
            raise StructureError(
                self.place, f"{what} takes {size} bytes but {left} are left in the metadata"
            )
        part = self._block[self._position : end]
        self._position = end
        return part

    def u32(self, what: str) -> int:
        """Return the next unsigned 32-bit number."""
        number: int = struct.unpack(self._endian + "I", self.skip(4, what))[0]
        return number

    def u64(self, what: str) -> int:
        """Return the next unsigned 64-bit number."""
        number: int = struct.unpack(self._endian + "Q", self.skip(8, what))[0]
        return number

    def raw_text(self, what: str) -> bytes:
        """Return the next text as bytes."""
        return self.skip(self.u32(f"the length of {what}"), what)

    def text(self, what: str) -> str:
        """Return the next text.

        Raises
        ------
        StructureError
            If it is not UTF-8.
        """
        place = self.place
        content = self.raw_text(what)
        try:
            return content.decode("utf-8")
        except UnicodeDecodeError as error:
            raise StructureError(place, f"{what} is not text: {shown(content, 40)}") from error

    def finish(self) -> None:
        """Pass zeros up to the end of the block.

        Raises
        ------
        StructureError
            If something else stands there.
        """
        rest = self._block[self._position :]
        if rest.strip(b"\0"):
            raise StructureError(
                self.place,
                f"{len(rest)} bytes of metadata are left over that belong to nothing",
            )
