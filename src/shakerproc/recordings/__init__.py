"""Recording files in, Recordings out: lazily and in bounded memory.

What writes recordings is loaded when it is first asked for.
"""

from typing import TYPE_CHECKING, Any

from shakerproc.late import loaded
from shakerproc.recordings.choosing import ANOTHER_GROUP, ChannelNotFoundError, FilePart
from shakerproc.recordings.health import (
    MOST_CLIPPED,
    MOST_LOST,
    file_flags,
    health,
    unusable,
    within,
)
from shakerproc.recordings.health.base import FAULTS, Flag
from shakerproc.recordings.opening import READERS, contents, open_recording
from shakerproc.recordings.raw import Sampling
from shakerproc.recordings.si import UNKNOWN
from shakerproc.recordings.source_files import WatchedFile, fetch, read_hashed, sha256

if TYPE_CHECKING:
    from shakerproc.recordings.writers import (
        WRITERS,
        write_csv,
        write_mat,
        write_parquet,
        write_tdms,
        write_uff,
    )


def __getattr__(name: str) -> Any:
    if name != "WRITERS" and not name.startswith("write_"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return loaded(f"shakerproc.recordings.writers:{name}")
