"""A test of the log, opened: its recording with roles, names and units, and its conditions."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from shakerproc.data import ChannelUse, Recording
from shakerproc.models import Conditions
from shakerproc.numerals import numeral
from shakerproc.recordings import FilePart, Sampling, open_recording
from shakerproc.recordings.raw import RawGroup
from shakerproc.recordings.source_files import FileHash
from shakerproc.runs.flags import calibration_sentences
from shakerproc.runs.joining import in_sequence, side_by_side
from shakerproc.runs.roles import UnitOption, by_sheet, usual_uses, with_unit
from shakerproc.testlog import Expectation, Test, TestLog, check_expectation


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
    controls: Sequence[str] | None = None,
    unit: UnitOption | None = None,
    seen: Sequence[FileHash] = (),
) -> Recording:
    """Return a recording, open, its channels as a test wants them or with the usual roles.

    Parameters
    ----------
    path : Path
        The file.
    test : Test
        What the log says, if anything.
    controls : sequence of str, optional
        Names or numbers of the control channels, all others being responses; only where the
        test names no channels.
    unit : UnitOption, optional
        Unit of those channels of which neither the file nor the test says it.
    seen : sequence of Seen
        Hashes of its files that are known; a file that has another stamp now is hashed anew.

    Raises
    ------
    LogError
        If it is not what the log expects, has not these controls, or says another unit.
    RecordingError
        If the recording cannot be used so.
    """
    run = path.name if test.recording is None else f"test {test.id} ({path.name})"

    def decide(among: RawGroup, said: Sequence[ChannelUse] | None) -> Sequence[ChannelUse]:
        if said is None:
            return usual_uses(among, run, controls, unit)
        channel_uses = by_sheet(said, among)
        return channel_uses if unit is None else with_unit(channel_uses, among, unit, run)

    def opened(file: Path, named: str) -> Recording:
        return open_recording(
            file,
            uses=test.channels or None,
            decide=decide,
            sample_rate=sampling_of(test),
            bad_rows=test.processing.bad_rows,
            part=FilePart(test.processing.group, test.processing.measurement),
            run=named,
            hashed=seen,
        )

    recording = _with_others(opened(path, run), test, opened, seen)
    try:
        check_expectation(_without_length(test) if recording.incomplete else test, recording)
    except BaseException:
        recording.source.close()
        raise
    notes = (*recording.notes, *calibration_sentences(test))
    return replace(recording, driven=test.excitation is not None, notes=notes)


def sampling_of(test: Test) -> Sampling:
    """Return the log's entry on the times of a test."""
    said = test.processing
    return Sampling(
        said.sample_rate,
        said.override_rate,
        said.time_unit,
        said.resample,
        said.ignore_starts,
    )


def _with_others(
    recording: Recording,
    test: Test,
    opened: Callable[[Path, str], Recording],
    seen: Sequence[FileHash],
) -> Recording:
    """Return a recording with the files that follow it and those beside it."""
    run, there = recording.run, [recording]
    try:
        for name in test.continued:
            path = test.require_file(name)
            there.append(opened(path, f"test {test.id} ({path.name})"))
        joined = in_sequence(run, there) if test.continued else recording
        for one in test.beside:
            if all(use.role == "ignore" for use in one.channels):
                continue  # it says that nothing is taken from there
            path = (
                test.require_file(one.recording) if one.recording else test.require_recording()
            )
            there.append(
                open_recording(
                    path, uses=one.channels, decide=_by_sheet_alone,
                    sample_rate=replace(
                        sampling_of(test), rate=one.sample_rate, override=one.override_rate
                    ),
                    part=FilePart(one.group),
                    bad_rows=test.processing.bad_rows, run=f"test {test.id} ({path.name})",
                    hashed=seen,
                )
            )  # fmt: skip
            joined = side_by_side(
                joined, there[-1], one.common, stamped=not test.processing.ignore_starts
            )
    except BaseException:
        for part in there:
            part.source.close()
        raise
    return joined


def _by_sheet_alone(among: RawGroup, said: Sequence[ChannelUse] | None) -> Sequence[ChannelUse]:
    return by_sheet(said or (), among)


def _without_length(test: Test) -> Test:
    """Return a test that expects no duration: that a recording is cut short is flagged."""
    return replace(test, expect=replace(test.expect, duration=None))


def stated(test: Test) -> Conditions:
    """Return the conditions of a test that its log states."""
    return Conditions(test.conditions, f"test {test.id}")


def conditions_of(test: Test) -> tuple[Conditions, tuple[str, ...]]:
    """Return all conditions of a test, and how much those vary that a channel measures.

    Of a channel the mean over the recording counts; what the log states counts before it.

    Raises
    ------
    ShakerprocError
        If the recording cannot be used.
    """
    values, notes = dict(test.conditions), list[str]()
    for use in test.measured_conditions:
        name = use.name or str(use.key)
        if name not in values:
            mean, spread, unit = _mean(test, use)
            values[name] = f"{mean:.9g} {unit}"
            notes.append(
                f"{name} {numeral(mean)} {unit} in the mean, varying by {numeral(spread, 2)} "
                f"{unit} rms"
            )
    return Conditions(values, f"test {test.id}"), tuple(notes)


def _mean(test: Test, use: ChannelUse) -> tuple[float, float, str]:
    """Return mean and standard deviation of a channel over the recording, and their unit."""
    alone = replace(test, channels=(use,), beside=(), expect=Expectation())
    with open_path(test.require_recording(), alone) as recording:
        samples, unit = recording.samples()[0], recording.channels[0].unit
    return float(samples.mean()), float(samples.std()), unit
