"""A test of the log, opened: its recording with roles, names and units."""

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Final

from shakerproc.data import Channel, ChannelUse, Recording, Role
from shakerproc.errors import LogError
from shakerproc.recordings import open_recording
from shakerproc.testlog import Test, TestLog, check_expectation

USUAL: Final[tuple[Role, ...]] = ("control", "control", "response", "response", "response")
"""Roles of the first five channels where nobody says otherwise; MATLAB's columns 3 to 7."""

_CONTROL_WORDS: Final = ("control", "ctrl", "drive", "table", "base", "shaker")


def open_test(log: TestLog, test: Test) -> Recording:
    """Return the recording of a test, open, its channels as the log wants them.

    Parameters
    ----------
    log : TestLog
        The log.
    test : Test
        One of its tests.

    Returns
    -------
    Recording
        Open: close it, or use it in a ``with`` statement.

    Raises
    ------
    LogError
        If the test has no recording that may be read, or it is not what the log expects.
    RecordingError
        If the recording cannot be used as the log wants it.
    """
    del log  # the test knows its place in it
    return open_path(test.require_recording(), test)


def open_path(
    path: Path,
    test: Test,
    *,
    group: str | None = None,
    controls: Sequence[str] | None = None,
    unit: str | None = None,
) -> Recording:
    """Return a recording, open, its channels as a test wants them or with the usual roles.

    Parameters
    ----------
    path : Path
        The file.
    test : Test
        What the log says, if anything.
    group : str, optional
        Group of a file of several.
    controls : sequence of str, optional
        Names or numbers of the control channels, all others being responses; only where the
        test names no channels.
    unit : str, optional
        Unit of those channels of which neither the file nor the test says it.

    Raises
    ------
    LogError
        If it is not what the log expects, or has not these controls.
    RecordingError
        If the recording cannot be used so.
    """
    run = path.name if test.recording is None else f"test {test.id} ({path.name})"
    rate = test.processing.sample_rate
    bad_rows = test.processing.bad_rows
    uses = test.channels
    with ExitStack() as closing:
        if not uses or unit is not None:
            found = closing.enter_context(
                open_recording(path, sample_rate=rate, group=group, run=run, bad_rows=bad_rows)
            )
            uses = uses or _roles(run, found.channels, controls)
            uses = _with_unit(uses, found.channels, unit)
        recording = open_recording(
            path,
            uses=uses,
            sample_rate=rate,
            group=group,
            run=run,
            bad_rows=bad_rows,
            hashed=True,
        )
        try:
            closing.close()  # an error where the file changed since it was looked at
            expected = _without_length(test) if recording.incomplete else test
            check_expectation(expected, recording)
        except BaseException:
            recording.source.close()
            raise
    return recording


def _without_length(test: Test) -> Test:
    """Return a test that expects no duration: that a recording is cut short is flagged."""
    return replace(test, expect=replace(test.expect, duration=None))


def _roles(
    run: str, channels: Sequence[Channel], controls: Sequence[str] | None
) -> tuple[ChannelUse, ...]:
    """Return the usual roles, or these controls and all others as responses.

    Raises
    ------
    LogError
        If there is no such channel.
    """
    names = [channel.source_name for channel in channels]
    if controls is None:
        return usual_uses(names)
    for wanted in controls:
        if wanted not in names and not (wanted.isdigit() and 1 <= int(wanted) <= len(names)):
            there = ", ".join(names)
            raise LogError(f"{run}: no channel {wanted!r} to be a control. It has {there}.")
    return tuple(
        ChannelUse(i, "control" if {name, str(i)} & set(controls) else "response")
        for i, name in enumerate(names, 1)
    )


def _with_unit(
    uses: Sequence[ChannelUse], channels: Sequence[Channel], unit: str | None
) -> tuple[ChannelUse, ...]:
    """Return the uses with a unit where there is none."""
    silent = {c.source_name for c in channels if not c.source_unit}
    silent_numbers = {i for i, c in enumerate(channels, 1) if not c.source_unit}
    return tuple(
        replace(use, unit=unit)
        if unit and use.unit is None and (use.key in silent or use.key in silent_numbers)
        else use
        for use in uses
    )


def usual_uses(names: Sequence[str]) -> tuple[ChannelUse, ...]:
    """Return roles for channels of which the log says nothing.

    Channels whose name speaks of control are controls and all others responses; where none
    does, the first two of the first five are controls. Responses keep the numbers ch3, ch4,
    ... of the thesis where they are called nothing better. Of two channels the first is the
    control.
    """
    spoken = [any(word in name.lower() for word in _CONTROL_WORDS) for name in names]
    if any(spoken):
        return tuple(
            ChannelUse(i, "control" if is_control else "response")
            for i, is_control in enumerate(spoken, 1)
        )
    if len(names) < 2:
        return tuple(ChannelUse(i, "response") for i in range(1, len(names) + 1))
    roles = USUAL if len(names) > 2 else (USUAL[0], USUAL[-1])
    return tuple(
        ChannelUse(i, role, name=None if role == "control" else f"ch{i}")
        for i, (role, _) in enumerate(zip(roles, names, strict=False), 1)
    )
