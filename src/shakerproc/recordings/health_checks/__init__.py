"""What looks for faults in a recording: each check sees every block once."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

from shakerproc.data import Recording
from shakerproc.recordings.health_checks.base import FAULTS, AbstractHealthCheck, Flag
from shakerproc.recordings.health_checks.connection import Connection
from shakerproc.recordings.health_checks.cross_channel import CrossChannel
from shakerproc.recordings.health_checks.drift import Drift
from shakerproc.recordings.health_checks.extremes import Extremes
from shakerproc.recordings.health_checks.flatlines import Flatlines
from shakerproc.recordings.health_checks.repeats import Repeats
from shakerproc.recordings.health_checks.short_tails import ShortTails
from shakerproc.recordings.health_checks.spikes import Spikes
from shakerproc.recordings.health_checks.transients import Transients

HEALTH_CHECKS: Mapping[str, Callable[[Recording], AbstractHealthCheck]] = MappingProxyType({
    "flatlines": Flatlines,
    "extremes": Extremes,
    "short_tails": ShortTails,
    "spikes": Spikes,
    "transients": Transients,
    "drift": Drift,
    "repeats": Repeats,
    "cross_channel": CrossChannel,
    "connection": Connection,
})
"""What looks at the samples, by what it looks for."""

__all__ = ["FAULTS", "HEALTH_CHECKS", "AbstractHealthCheck", "Flag"]
