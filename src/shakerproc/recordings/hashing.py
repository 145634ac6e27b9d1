"""The fingerprint of a file."""

import hashlib
from pathlib import Path

from shakerproc.errors import RecordingError


def sha256(path: Path) -> str:
    """Return the SHA-256 of a file as 64 hexadecimal digits.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise RecordingError(f"{path.name}: cannot be read: {error.strerror}.") from error
