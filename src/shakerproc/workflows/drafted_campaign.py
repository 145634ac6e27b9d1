"""A test log and a model begun from a folder of recordings: what the files say, and guesses."""

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Final

from shakerproc import files
from shakerproc.errors import LogError
from shakerproc.recordings.raw import Sampling
from shakerproc.workflows.draft_channels import (
    FORCE,
    controls_of_seen,
    ignored,
    is_struck,
    measures,
    quoted,
)
from shakerproc.workflows.draft_log import log_text
from shakerproc.workflows.recordings_seen import SeenRecording, recordings_below, seen_of

MODEL: Final = """\
# What is thought to be on the shaker: one mass on a spring and a damper. Weigh what moves with
# the sensor; k = m (2 pi f)^2 and c = 2 pi f m / Q, with f and Q of the lowest level, from
# `shakerproc batch`. Both are fitted; the mass is not.

model: 1
title: one mass on a linear joint
masses: {{coupon: 1 kg}}           # ??? weigh it
elements:
  - {{kind: spring, between: [base, coupon], stiffness: 4e5 N/m}}     # ??? 100 Hz for 1 kg
  - {{kind: damper, between: [base, coupon], damping: 25 N s/m}}      # ??? Q of 25 for 1 kg
excitation: {{{excitation}}}
sensors:
{sensors}"""

_SENSOR: Final = "{at: coupon, measures: acceleration}"


def begin(
    folder: Path,
    recordings: Path,
    said: Sampling,
    advance: Callable[[str], None],
    warn: Callable[[str], None],
) -> tuple[Path, Path]:
    """Write a log and a model for the recordings in a folder; return their paths.

    Parameters
    ----------
    folder, recordings : Path
        Where the files go, and the folder in it that holds the recordings.
    said : Sampling
        What is said of the times of the recordings.
    advance, warn : callable
        Called after each recording, and with what may be wrong.

    Raises
    ------
    LogError
        If a log or a model is there already, or the recordings lie elsewhere, or none of them
        can be read.
    """
    log, model = folder / "testlog.yaml", folder / "model.yaml"
    for path in (log, model):
        if path.exists():
            raise LogError(f"{path}: it is there already; nothing was written")
    if not recordings.resolve().is_relative_to(folder.resolve()):
        raise LogError(
            f"{recordings}: not below {folder}. A log reads nothing outside its own folder: "
            f"name a folder that holds the recordings, or move them."
        )
    paths = recordings_below(recordings)
    seen = [one for path in paths for one in seen_of(path, said, warn, advance)]
    if not seen:
        raise LogError(f"{recordings}: none of the recordings can be read; nothing was written")
    # what can be used speaks first, and of that what a shaker drives
    seen.sort(key=lambda one: (not one.rms, is_struck(one)))
    files.write_text(log, log_text(folder, recordings, seen, said, warn))
    files.write_text(model, _model_text(seen[0]))
    return log, model


def _model_text(seen: SeenRecording) -> str:
    """Return a model whose sensors are the responses of a recording."""
    counts, controls = Counter(seen.names), controls_of_seen(seen)
    channels = zip(seen.names, seen.units, seen.lengths, strict=True)
    responses = [
        name if counts[name] == 1 else f"{name} {number}"
        for number, (name, unit, n) in enumerate(channels, 1)
        if name not in controls
        and not ignored(name, unit, n, seen)
        and measures(name, unit) != FORCE
    ]
    sensors = "".join(f"  {quoted(n)}: {_SENSOR}\n" for n in responses)
    excitation = "base: acceleration" if controls else "force on: coupon"
    return MODEL.format(sensors=sensors, excitation=excitation)
