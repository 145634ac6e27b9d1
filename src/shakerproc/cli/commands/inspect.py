"""``shakerproc inspect``."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from shakerproc.cli import options, output

if TYPE_CHECKING:
    from shakerproc.data import Recording
    from shakerproc.recordings import Flag
    from shakerproc.recordings.raw import RawGroup

SCHEMA = "shakerproc-inspect/1"


@dataclass(frozen=True, slots=True)
class ChannelLevel:
    """Statistics of a channel's samples, in its SI unit."""

    minimum: float
    maximum: float
    rms: float


@options.grouped
def inspect(
    recording: options.RecordingArgument,
    reading: options.ReadingOptions,
    health: Annotated[bool, typer.Option(help="Look through the samples for faults.")] = True,
    json: output.JsonOption = None,
) -> None:
    """Show channels, units, rate, length and health of a recording.

    Also of a recording that cannot be used as it is: what it holds, and what to do (exit 1).
    Of spectra and response functions in a universal file, what they are (exit 0).
    """
    from shakerproc.errors import RecordingError, SpectraError
    from shakerproc.recordings.opening import read_whole, recording_in

    skip, part, said = reading.rows(), reading.part(), reading.sampling()
    try:
        whole = read_whole(recording, hashed=True)
    except SpectraError as error:
        document = {"schema": SCHEMA, "file": recording, "groups": [], "notes": []}
        output.write_json(document | {"holds": error.holds, "error": str(error)}, json)
        text = f"{recording.name}: no samples over time: {error.holds}"
        output.data(text)
        return
    groups, notes = whole.contents
    try:
        with recording_in(whole, part=part, sample_rate=said, bad_rows=skip) as opened:
            _show(opened, groups, json, health=health)
    except RecordingError as error:
        output.write_json(
            {"schema": SCHEMA, "file": recording, "groups": list(map(_listed, groups))}
            | {"notes": notes, "error": str(error)},
            json,
        )
        for group in (one for one in groups if one.channels):
            _show_group(group)
        raise


def _show(
    recording: "Recording", groups: "tuple[RawGroup, ...]", json: str | None, *, health: bool
) -> None:
    from shakerproc.recordings import health as find_flags
    from shakerproc.runs.summary import unused_lines

    path = recording.path or Path(recording.run)
    flags = find_flags(recording) if health else ()
    levels = _levels(recording) if health else []
    fingerprint = recording.sha256()
    output.write_json(
        {
            "schema": SCHEMA,
            "file": path,
            "bytes": path.stat().st_size,
            "sha256": fingerprint,
            "sample_rate_hz": recording.sample_rate,
            "samples": recording.n_samples,
            "expected_samples": recording.expected_samples,
            "incomplete": recording.incomplete,
            "duration_s": recording.duration,
            "start_time": recording.start_time,
            "channels": recording.channels,
            "unused": recording.unused,
            "levels": levels,
            "groups": list(map(_listed, groups)),
            "flags": flags if health else None,
            "notes": recording.notes,
            "error": None,
        },
        json,
    )
    _summary(recording, path, fingerprint)
    _channels(recording, levels)
    for group in groups:
        if len(groups) > 1:
            output.data(f"group {_described(group)}")
        _measurements(group)
    for note in (*recording.notes, *unused_lines(recording.unused)):
        output.data(f"note: {note}")
    _health(flags, looked=health)


def _summary(recording: "Recording", path: Path, fingerprint: str) -> None:
    length = f"{recording.duration:.6g} s"
    if recording.incomplete and recording.expected_samples is not None:
        expected = recording.expected_samples / recording.sample_rate
        length = f"INCOMPLETE: {length} of {expected:.6g} s"
    start = (
        f", from {recording.start_time:%Y-%m-%d %H:%M:%S} UTC" if recording.start_time else ""
    )
    output.data(
        f"{path.name}: {_count(recording.channels)}, {length}{start}, "
        f"{recording.n_samples} samples at {recording.sample_rate:.9g} Hz"
    )
    output.data(f"{path.stat().st_size} bytes, SHA-256 {fingerprint}")


def _channels(recording: "Recording", levels: list[ChannelLevel]) -> None:
    rows = []
    for number, channel in enumerate(recording.channels):
        row: list[object] = [
            number + 1,
            channel.name,
            channel.source_unit or "none",
            channel.unit,
        ]
        if levels:
            level = levels[number]
            row += [level.minimum, level.maximum, level.rms]
        rows.append(row)
    columns = ["number", "channel", "unit in the file", "converted to"]
    columns += ["minimum", "maximum", "rms"] if levels else []
    output.print_table(columns, rows)


def _health(flags: "tuple[Flag, ...]", *, looked: bool) -> None:
    if not looked:
        return
    if not flags:
        output.data("health: nothing found")
        return
    rows = [(f.kind, f.channel or "all", f.start, f.stop, f.message) for f in flags]
    output.print_table(("flag", "channel", "from s", "to s", "what to look at"), rows)


def _levels(recording: "Recording") -> list[ChannelLevel]:
    """Return the extremes and rms of every channel; NaN is left out."""
    import numpy as np

    low = np.full(len(recording.channels), np.inf)
    high, squares, count = -low, np.zeros_like(low), np.zeros_like(low)
    for block in recording.blocks(size=2**17):
        good = np.isfinite(block)
        finite = np.where(good, block, 0.0)
        low = np.minimum(low, np.where(good, block, np.inf).min(axis=1))
        high = np.maximum(high, np.where(good, block, -np.inf).max(axis=1))
        squares += np.einsum("ij,ij->i", finite, finite)
        count += good.sum(axis=1)
    rms = np.sqrt(squares / np.maximum(count, 1))
    return [
        ChannelLevel(float(a), float(b), float(c))
        for a, b, c in zip(low, high, rms, strict=True)
    ]


def _described(group: "RawGroup") -> str:
    rates = sorted({c.sample_rate for c in group.channels if c.sample_rate})
    lengths = sorted({c.n_samples for c in group.channels})
    at = f" at {', '.join(f'{rate:.6g}' for rate in rates)} Hz" if rates else ""
    copies = ", decimated copies" if group.reduced else ""
    return (
        f"{group.name or 'of all channels'}: {_count(group.channels)}, "
        f"{' or '.join(map(str, lengths))} samples{at}{copies}"
    )


def _listed(group: "RawGroup") -> dict[str, Any]:
    """Return a group as JSON holds it: its channels, without the times themselves."""
    return {
        "name": group.name,
        "channels": [
            {
                "name": one.name,
                "alias": one.alias,
                "n_samples": one.n_samples,
                "promised": one.promised,
                "unit": one.unit,
                "sample_rate": one.sample_rate,
                "rate_doubt": one.time.doubt,
                "rate_problem": one.time.problem,
                "start_time": one.start_time,
                "problem": one.problem,
            }
            for one in group.channels
        ],
        "reduced": group.reduced,
        "measurements": list(map(_listed, group.measurements)),
        "differs": group.differs,
        "more": group.more,
    }


def _measurements(group: "RawGroup") -> None:
    """Tell the measurements that follow each other in a group, where there are several."""
    from shakerproc.recordings.choosing import measurement_text

    for number, part in enumerate(group.measurements, 1):
        difference = f", another {group.differs[number - 2]}" if number > 1 else ""
        output.data(f"measurement {number}: {measurement_text(part)}{difference}")
    if group.more:
        output.data(f"and {group.more} more measurements")


def _show_group(group: "RawGroup") -> None:
    output.data(f"group {_described(group)}")
    _measurements(group)
    rows = [
        (n, c.name, c.unit or "none", c.n_samples, c.sample_rate, c.problem)
        for n, c in enumerate(group.channels, 1)
    ]
    columns = ("number", "channel", "unit in the file", "samples", "rate Hz", "problem")
    output.print_table(columns, rows)


def _count(channels: Sequence[object]) -> str:
    return f"{len(channels)} channel{'s' * (len(channels) != 1)}"
