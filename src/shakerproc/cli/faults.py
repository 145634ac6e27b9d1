"""Messages on the channels of a recording that is to shake a model."""

from typing import TYPE_CHECKING

from shakerproc.cli import output

if TYPE_CHECKING:
    from shakerproc.data import Recording


def tell(recording: "Recording", role: str | None, start: float, stop: float) -> None:
    """Say what the health checks find of channels of a role, from `start` to `stop` [s]."""
    from shakerproc.recordings import health, within

    driving = {"", *(c.name for c in recording.channels if c.role == role)}
    for flag in within(health(recording), start, stop):
        if flag.channel in driving:
            output.warning(flag.line)
