"""Whether a run can be done at all: a level, a band in order, a bounded number of samples."""

from shakerproc.simulation.inputs import MOST_SAMPLES
from shakerproc.studies.study import Run


def check_run(run: Run, *, in_time: bool = True) -> None:
    """Pass a run that can be done.

    Parameters
    ----------
    run : Run
        The run.
    in_time : bool
        Whether it is stepped through; else its level alone counts.

    Raises
    ------
    ValueError
        If it cannot, with what was found and what is wanted.
    """
    if run.excitation != "free" and run.level == 0.0:
        raise ValueError(f"a {run.excitation} needs a level other than 0")
    if not in_time:
        return
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
