"""What becomes of a mutant when it is opened as a batch opens it: with its log."""

import signal
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from tests.fuzz.mutants import Mutant
from tests.fuzz.seeds import RATE, Seed

from shakerproc.data import Recording
from shakerproc.errors import ShakerprocError
from shakerproc.recordings import health, source_files
from shakerproc.runs import open_path
from shakerproc.testlog import Test, read_testlog

LIMIT = 5.0

OUTCOMES = (
    "refused in one line",
    "read as it was",
    "prefix, marked",
    "numbers differ, noted",
    "numbers differ",
    "rows gone at an end of a file without a count",
    "channels left out, noted",
    "times as the damaged file states them",
    "lost silently",
    "rows displaced",
    "name or unit wrong",
    "times changed silently",
    "refusal not one line",
    "hang",
    "out of memory",
    "traceback",
)
GOOD = OUTCOMES[:8]


source_files._TICK = 0


class TooLongError(BaseException):
    """The time limit has passed; no library may catch it."""


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    def stop(*_: object) -> None:
        raise TooLongError

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)  # of its own time, on a busy machine too
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


class Judge:
    """Writes mutants into a folder and reads them with the log of their seed."""

    def __init__(self, folder: Path, seeds: list[Seed]) -> None:
        self.folder = folder
        self.tests = {seed.name: self._tests(seed) for seed in seeds}
        self.usual = {seed.name: self._said(seed) for seed in seeds}

    def _tests(self, seed: Seed) -> tuple[Test, ...]:
        (self.folder / seed.name).write_bytes(seed.content)
        log = self.folder / "testlog.yaml"
        log.write_text(seed.log())
        return read_testlog(log).tests

    def _said(self, seed: Seed) -> set[tuple[str, str]]:
        """Return what is said of the good file."""
        (self.folder / seed.name).write_bytes(seed.content)
        with open_path(self.folder / seed.name, self.tests[seed.name][0]) as recording:
            assert compared(recording, recording.samples(), Mutant("", seed, b""))[0] == GOOD[1]
            return said(recording)

    def outcome(self, mutant: Mutant) -> tuple[str, str]:
        """Return what became of a mutant, and the message where there was one."""
        path = self.folder / mutant.seed.name
        index = path.with_name(path.name + "_index")
        path.write_bytes(mutant.content)
        if mutant.index is not None:
            index.write_bytes(mutant.index)
        try:
            with time_limit(LIMIT), warnings.catch_warnings():
                warnings.simplefilter("error")
                return self._read(path, mutant)
        except TooLongError:
            return "hang", ""
        except MemoryError:
            return "out of memory", ""
        except ShakerprocError as error:
            message = str(error)
            names = path.name in message or "testlog.yaml:" in message
            good = message.isprintable() and names and len(message) < 1500
            return "refused in one line" if good else "refusal not one line", message
        except Exception as error:  # noqa: BLE001  what is looked for
            return "traceback", repr(error)
        finally:
            index.unlink(missing_ok=True)

    def _read(self, path: Path, mutant: Mutant) -> tuple[str, str]:
        with open_path(path, self.tests[mutant.seed.name][mutant.skip]) as recording:
            if mutant.while_open is not None:
                path.write_bytes(mutant.while_open)
            samples = recording.samples()
            told = bool(said(recording) - self.usual[mutant.seed.name])
            if wrong_description(recording, mutant.seed):
                noted = told and lacks_channels(recording, mutant.seed)
                return ("channels left out, noted" if noted else "name or unit wrong"), ""
            moved = times_moved(recording, samples, mutant.seed)
            if moved and states_otherwise(mutant):
                return "times as the damaged file states them", ""
            if moved and not told:
                return "times changed silently", moved
            outcome = compared(recording, samples, mutant)
            if outcome[0] == "lost silently" and states_otherwise(mutant):
                return "times as the damaged file states them", ""
            if outcome[0] == "numbers differ" and told:
                return "numbers differ, noted", ""
            return outcome


def said(recording: Recording) -> set[tuple[str, str]]:
    """Return the notes and flags of a recording."""
    flags = {(flag.kind, flag.channel) for flag in health(recording)}
    return flags | {("note", note) for note in recording.notes}


def wrong_description(recording: Recording, seed: Seed) -> bool:
    names = tuple(channel.source_name for channel in recording.channels)
    units = {channel.source_unit for channel in recording.channels}
    return names != seed.channels or units != {"g"}


def lacks_channels(recording: Recording, seed: Seed) -> bool:
    """Return whether channels are as in the original, but for some that are not there."""
    names = [channel.source_name for channel in recording.channels]
    kept = [name for name in seed.channels if name in names]
    return names == kept and {channel.source_unit for channel in recording.channels} == {"g"}


def times_moved(recording: Recording, samples: np.ndarray, seed: Seed) -> str:
    """Return how rate or start differ from those of the original; empty where they do not.

    The start is that of the row which is now the first: one before it may be gone.
    """
    if abs(recording.sample_rate / RATE - 1.0) > 1e-4:
        return f"{recording.sample_rate:.9g} Hz"
    if seed.start is None:
        return ""
    if recording.start_time is None:
        return "no start"
    ahead = (recording.start_time - seed.start).total_seconds() * RATE
    whole, n = seed.values.shape[1], samples.shape[1]
    differ = [
        int((~alike(samples, seed.values[:, at : at + n])).sum())
        for at in range(max(whole - n, 0) + 1)
        if at + n <= whole
    ]
    first = int(np.argmin(differ)) if differ else 0
    return f"starts {ahead:.6g} samples late" if abs(ahead - first) > 0.5 else ""


def states_otherwise(mutant: Mutant) -> bool:
    """Return whether damage reaches what only one place of the file says of the times."""
    before, after = mutant.seed.content, mutant.content
    short = min(len(before), len(after))
    one = np.frombuffer(before, np.uint8)
    other = np.frombuffer(after, np.uint8)
    ahead = np.flatnonzero(one[:short] != other[:short])
    first = int(ahead[0]) if ahead.size else short
    behind = np.flatnonzero(one[::-1][:short] != other[::-1][:short])
    last = len(before) - (int(behind[0]) if behind.size else short)
    return any(
        part.start < max(last, first + 1) and part.stop > first for part in mutant.seed.stated
    )


def compared(recording: Recording, samples: np.ndarray, mutant: Mutant) -> tuple[str, str]:
    """Return how what was read stands to the original, row by row.

    Rows that are missing have to be counted: as skipped, or by "incomplete". A file that does
    not say how many rows it has may lack whole rows at an end. No more rows may differ than
    were changed or skipped.
    """
    values = mutant.seed.values
    n, whole = samples.shape[1], values.shape[1]
    skipped = 0 if recording.skipped is None else recording.skipped.count
    if n > whole or (n < whole and not recording.incomplete and skipped < whole - n):
        if says_no_length(mutant) and n < whole and fewest_changes(samples, values, whole) <= 1:
            return "rows gone at an end of a file without a count", ""
        return "lost silently", f"{n} of {whole} samples"
    either_end = whole - n if mutant.seed.table is not None else 0  # its first row may be gone
    differ = fewest_changes(samples, values, max(skipped, either_end))
    if not differ:
        return ("read as it was" if n == whole else "prefix, marked"), ""
    if mutant.rows >= 0 and differ > mutant.rows + skipped:
        return "rows displaced", f"{differ} rows differ, {mutant.rows} were changed"
    return "numbers differ", ""


def says_no_length(mutant: Mutant) -> bool:
    """Return whether nothing in a file says how many rows it had."""
    size = len(mutant.content)
    cut = mutant.content == mutant.seed.content[:size] and size in mutant.seed.complete
    return cut or not mutant.seed.counted


def fewest_changes(samples: np.ndarray, values: np.ndarray, most: int) -> int:
    """Return how many rows differ from a stretch of the original, begun at most so late."""
    n = samples.shape[1]
    return min(
        int((~alike(samples, values[:, at : at + n])).sum())
        for at in range(min(most, values.shape[1] - n) + 1)
    )


def alike(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return for each row whether it is the same."""
    return np.isclose(one, other, rtol=1e-14, atol=0.0).all(axis=0)
