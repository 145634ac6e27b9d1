"""What looks for faults in a recording: each watcher sees every block once."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final

from shakerproc.data import Recording
from shakerproc.recordings.watchers.base import FAULTS, AbstractWatcher, Flag
from shakerproc.recordings.watchers.connection import Connection
from shakerproc.recordings.watchers.drift import Drift
from shakerproc.recordings.watchers.extremes import Extremes
from shakerproc.recordings.watchers.knocks import Knocks
from shakerproc.recordings.watchers.repeats import Repeats
from shakerproc.recordings.watchers.spikes import Spikes
from shakerproc.recordings.watchers.standstill import Standstill
from shakerproc.recordings.watchers.together import Together

WATCHERS: Mapping[str, Callable[[Recording], AbstractWatcher]] = MappingProxyType({
    "standstill": Standstill,
    "extremes": Extremes,
    "spikes": Spikes,
    "knocks": Knocks,
    "drift": Drift,
    "repeats": Repeats,
    "together": Together,
    "connection": Connection,
})
"""What looks at the samples, by what it looks for."""

MEASURING: Final = ("standstill", "extremes", "connection")
"""Those that tell whether a channel measured at all."""

__all__ = ["FAULTS", "MEASURING", "WATCHERS", "AbstractWatcher", "Flag"]
