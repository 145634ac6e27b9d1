"""Response of a model to an input in memory, and a campaign simulated as its log says."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

import numpy as np

from shakerproc import files
from shakerproc.data import FloatArray
from shakerproc.errors import ArgumentError, LogError
from shakerproc.models import Model
from shakerproc.numerals import numeral
from shakerproc.runs.opening import stated
from shakerproc.runs.result import shown_unit
from shakerproc.runs.tables import spelled
from shakerproc.simulation import SimulatedResponse as Simulated
from shakerproc.simulation import simulate as simulated
from shakerproc.workflows.arguments import argument_text, model_of, positive_of, switch_of
from shakerproc.workflows.shown import Shown, frame, frame_of_rows, html

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

    from shakerproc.data import Recording
    from shakerproc.planning import Staging
    from shakerproc.testlog import Test, TestLog


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Simulation(Shown):
    """The response of a model, and how far it can be trusted.

    Attributes
    ----------
    model : Model
        What was shaken.
    found : shakerproc.simulation.Simulation
        Motion of every mass, outputs of every sensor, error and growth, in SI units.
    """

    model: Model
    found: Simulated

    def to_pandas(self) -> "DataFrame":
        """Return time, input and the output of every sensor, with their units in the names."""
        columns: dict[str, FloatArray] = {"time_s": self.found.time}
        for name, (unit, samples) in self._signals().items():
            shown, factor = shown_unit(unit)
            columns[f"{name}{spelled(shown)}"] = samples * factor
        return frame(columns)

    def plot(self) -> "Figure":
        """Return input and outputs against time."""
        from shakerproc.report.runs.drawing import signals

        shown = []
        for name, (unit, samples) in self._signals().items():
            said, factor = shown_unit(unit)
            shown.append((name, said, samples * factor))
        return signals(self.model.title, self.found.time, shown)

    def _signals(self) -> dict[str, tuple[str, FloatArray]]:
        """Return the SI unit and the samples of the input and of every sensor."""
        signals = {"input": (self.model.drive_unit, self.found.excitation)}
        for name, sensor in self.model.sensors.items():
            signals[name] = (self.model.sensor_unit(sensor), self.found.outputs[name])
        return signals

    def _repr_html_(self) -> str:
        run = self.found
        sentence = (
            f"{run.time.size} samples at {run.sample_rate:.6g} Hz by {run.solver}, "
            f"{run.switchings} switchings, estimated error {numeral(run.error, 2)} of the "
            "largest displacement"
        )
        chaotic = "chaotic motion: any model agrees with it in statistics only"
        rows = [
            (name, unit, float(np.sqrt(np.mean(samples**2))), float(np.max(np.abs(samples))))
            for name, (unit, samples) in self._signals().items()
        ]
        table = frame_of_rows(("signal", "unit", "rms", "largest"), rows)
        remarks = [*run.notes, chaotic if run.chaotic else ""]
        return html(self.model.title, [sentence, *remarks], table)


def simulate(
    model: Any,
    excitation: FloatArray | Sequence[float] | Callable[[FloatArray], FloatArray],
    sample_rate: float,
    *,
    duration: float | None = None,
    growth: bool = True,
) -> Simulation:
    """Return the response of a model to an input.

    Parameters
    ----------
    model : ModelFile or Model
        What `read_model` returned, or a model made in Python.
    excitation : (n,) array, or function of time
        The input in SI units: acceleration of the base [m/s^2], force [N] or imposed
        displacement [m], as the model says; a function takes times [s].
    sample_rate : float
        Samples per second, of the input and of the response [Hz].
    duration : float, optional
        How long a function is followed [s].
    growth : bool
        Whether to run twice, to tell how a disturbance grows.

    Raises
    ------
    ArgumentError
        If an argument is of another kind, not finite, or does not fit the others.
    SimulationError
        If the motion runs away, or cannot be followed.
    """
    shaken = model_of(model).model
    given = excitation if callable(excitation) else _samples(excitation)
    rate = positive_of("sample_rate", sample_rate)
    if callable(excitation) != (duration is not None):
        raise ArgumentError("duration", "goes with a function of time, and only with one")
    length = None if duration is None else positive_of("duration", duration)
    again = switch_of("growth", growth)
    try:
        run = simulated(shaken, given, rate, duration=length, growth=again)
    except ValueError as error:
        raise ArgumentError("excitation", str(error)) from error
    return Simulation(shaken, run)


def _samples(given: Any) -> FloatArray:
    wanted = "expected an array of samples, or a function of time"
    try:
        samples = np.asarray(given, dtype=float)
    except (TypeError, ValueError, OverflowError) as error:
        raise ArgumentError("excitation", f"{wanted}, got {argument_text(given)}") from error
    if samples.ndim != 1 or samples.size == 0:
        raise ArgumentError("excitation", f"{wanted}, got one of shape {samples.shape}")
    if not np.all(np.isfinite(samples)):
        first = int(np.flatnonzero(~np.isfinite(samples))[0])
        raise ArgumentError("excitation", f"sample {first} is {samples[first]}; fill the gap")
    return samples


def rehearse_campaign(
    model: "Model",
    log: "TestLog",
    staging: "Staging",
    *,
    folder: Path | None = None,
    wanted: Sequence[str] = (),
    overwrite: bool = False,
    advance: Callable[[str], None] = lambda _text: None,
    warn: Callable[[str], None] = lambda _text: None,
) -> list[dict[str, object]]:
    """Write the recording of each test that has one; return the numbers of each.

    Parameters
    ----------
    model : Model
        What is shaken, in each test under the conditions that the log states.
    folder : Path, optional
        Where a copy of the log goes, and the recordings below it; by default they are written
        beside the log itself.
    wanted : sequence of str
        Ids of tests; by default all that are not discarded and whose log says what shakes them.
    overwrite : bool
        Whether recordings that are there are replaced.
    advance, warn : callable
        Called after each test, and with what may be wrong.

    Raises
    ------
    LogError
        If there is nothing to write, or a recording is there already.
    """
    from shakerproc.planning import rehearse
    from shakerproc.planning.drive import not_playable

    root = log.path.absolute().parent
    target = root if folder is None else folder.absolute()
    tests = [log.find(one) for one in wanted] if wanted else list(log.active)
    for test in tests:
        if test.recording is None:
            warn(f"test {test.id} has no recording in the log and is left out")
            advance(f"test {test.id}")
    named = [test for test in tests if test.recording is not None]
    played = [test for test in named if wanted or not not_playable(test)]
    for test in named if played else ():
        if test not in played:
            warn(f"test {test.id} is left out: {not_playable(test)}")
            advance(f"test {test.id}")
    named = played or named
    if not named:
        raise LogError(f"{log.path}: no test has a recording to write; add the key")
    of_tests = [model.under(stated(test)) for test in named]
    paths = [_path(test, root, target) for test in named]
    _check_free(log, paths, overwrite=overwrite)
    copies = {} if target == root else _copies_of_log(log, target, overwrite=overwrite)
    rows = []
    for shaken, test, path in zip(of_tests, named, paths, strict=True):
        made = rehearse(shaken, test, staging)
        while copies:  # a model that cannot be shaken so is refused before anything is written
            files.write_bytes(*copies.popitem())
        write_recording(path, made.recording)
        rows.append({**made.facts, "recording": path.relative_to(target).as_posix()})
        advance(f"test {test.id}")
    return rows


def write_recording(path: Path, recording: "Recording") -> None:
    """Write a recording in the format of its ending, whole or not at all.

    Raises
    ------
    LogError
        If there is no such format.
    """
    from shakerproc.recordings import WRITERS

    writer = WRITERS.get(path.suffix.lower())
    if writer is None:
        raise LogError(
            f"{path.name}: no format {path.suffix or 'without ending'}; shakerproc writes "
            f"{', '.join(WRITERS)}. Correct recording in the log."
        )
    writer(path, recording)


def _path(test: "Test", root: Path, target: Path) -> Path:
    assert test.recording is not None  # noqa: S101 - narrows the type; the caller has checked
    return target / test.recording.relative_to(root)


def _check_free(log: "TestLog", paths: Sequence[Path], *, overwrite: bool) -> None:
    """Pass paths at which nothing stands.

    Raises
    ------
    LogError
        If a recording is there and must not be replaced.
    """
    there = [path for path in paths if path.exists()]
    if there and not overwrite:
        more = f" and {len(there) - 1} more are" if len(there) > 1 else " is"
        raise LogError(
            f"{log.path}: {there[0]}{more} there already. Give --out FOLDER for a copy of the "
            f"campaign, or --overwrite to replace what was recorded."
        )


def _copies_of_log(log: "TestLog", target: Path, *, overwrite: bool) -> dict[Path, bytes]:
    """Return the log and the specimens that it names, by where they go in another folder.

    Raises
    ------
    LogError
        If another file stands there.
    """
    named = log.document.value.specimens
    sources = [log.path, *([log.path.parent / named] if isinstance(named, str) else [])]
    copies = {}
    for source in sources:
        copy, content = target / source.relative_to(log.path.parent), source.read_bytes()
        if copy.exists() and copy.read_bytes() != content and not overwrite:
            raise LogError(f"{copy} is another file already; choose another --out")
        copies[copy] = content
    return copies
