"""Contradictions within a section of the log, and at which of its keys."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from shakerproc.documents import Key


class MisfitError(Exception):
    """Something does not fit, at a key below the section that is looked at.

    Attributes
    ----------
    place : tuple of str and int
        Keys from the section to what does not fit.
    """

    def __init__(self, message: str, *place: "Key") -> None:
        self.place = place
        super().__init__(message)
