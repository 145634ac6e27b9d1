"""Whether a run can be done at all: a level, a band in order, a bounded number of samples."""

from shakerproc.simulation.inputs import MOST_SAMPLES
from shakerproc.studies.study import Measure, StudyRun


def check_run(run: StudyRun) -> None:
    """Pass a run that can be done.

    Parameters
    ----------
    run : StudyRun
        The run.

    Raises
    ------
    ValueError
        If it cannot, with what was found and what is wanted.
    """
    if run.excitation != "free" and run.level == 0.0:
        raise ValueError(f"a {run.excitation} needs a level other than 0")
    if run.excitation in {"sine sweep", "random"} and not run.to_hz > run.from_hz:
        raise ValueError(
            f"a {run.excitation} needs from and to, with to above from, not "
            f"{run.from_hz:g} Hz to {run.to_hz:g} Hz"
        )
    if run.octaves and run.from_hz <= 0.0:
        raise ValueError("a sweep in octaves cannot begin at 0 Hz")
    if run.excitation == "sine" and not run.frequency > 0.0:
        raise ValueError(f"a sine needs a frequency above 0 Hz, not {run.frequency:g} Hz")
    if not (run.duration > 0.0 < run.sample_rate):
        raise ValueError(
            f"duration and sample rate must be above 0, not {run.duration:g} s and "
            f"{run.sample_rate:g} Hz"
        )
    samples = run.duration * run.sample_rate
    if not 2.0 <= samples <= MOST_SAMPLES:
        raise ValueError(
            f"{run.duration:g} s at {run.sample_rate:g} Hz are {samples:.3g} samples; from 2 "
            f"to {MOST_SAMPLES:.0e} can be computed"
        )
    if not 0.0 <= run.settle < 1.0 or not 0.0 < run.tolerance < 1.0 or run.seed < 0:
        raise ValueError(
            f"settle must be from 0 to below 1, tolerance between 0 and 1, seed at least 0, "
            f"not {run.settle:g}, {run.tolerance:g} and {run.seed}"
        )


def samples_left(run: StudyRun) -> int:
    """Return how many samples of a run are looked at."""
    n_samples = round(run.duration * run.sample_rate) + 1
    return n_samples - int(run.settle * n_samples)


def check_measure(measure: Measure, run: StudyRun) -> None:
    """Pass what can be read of a run.

    Raises
    ------
    ValueError
        If its band or its segment does not fit the run.
    """
    if measure.to_hz and not measure.to_hz > measure.from_hz:
        raise ValueError(
            "measure: expected to above from, got "
            f"{measure.from_hz:g} Hz to {measure.to_hz:g} Hz"
        )
    if measure.estimator == "welch" and measure.segment > samples_left(run):
        raise ValueError(
            f"measure: a run of {samples_left(run)} samples holds no segment of "
            f"{measure.segment}"
        )
