"""Excitation of the runs of a study, for people."""

from math import cos, degrees, isclose, sin

from shakerproc.studies.study import Study, StudyRun


def driven(study: Study) -> str:
    """Return the excitation of the runs, for people."""
    run = study.run
    if run is None:
        return ""
    varied = [v.name for v in study.vary if any(p.startswith("run.") for p in v.places)]
    method = {"exact": "", "Newmark": ", by Newmark's method"}.get(
        run.method, f", by {run.method} at a relative tolerance of {run.tolerance:g}"
    )
    return _in_general(run) + method + (f", {' and '.join(varied)} varied" if varied else "")


def _in_general(run: StudyRun) -> str:
    start = ""
    if run.initial_displacement or run.initial_velocity:
        start = f", from {run.initial_displacement:.4g} m and {run.initial_velocity:.4g} m/s"
    if run.excitation == "free":
        return f"free motion of {run.duration:g} s{start}"
    if run.excitation == "sine":
        return (
            f"sine of {run.frequency:.4g} Hz for {run.duration:g} s, begun "
            f"{begun(run.phase)}{start}"
        )
    if run.excitation == "random":
        return f"random {run.from_hz:g} to {run.to_hz:g} Hz, seed {run.seed}{start}"
    ends = (run.to_hz, run.from_hz) if run.down else (run.from_hz, run.to_hz)
    way, per = ("down" if run.down else "up"), ("octave" if run.octaves else "hertz")
    return (
        f"sweep {way} from {ends[0]:g} to {ends[1]:g} Hz in {run.duration:g} s, as long for "
        f"every {per}{start}"
    )


def begun(phase: float) -> str:
    """Return how a sine begins, for people.

    Parameters
    ----------
    phase : float
        Phase at the start [rad].
    """
    if isclose(cos(phase), 1.0, abs_tol=1e-9):
        return "at 0 and rising"
    if isclose(sin(phase), 1.0, abs_tol=1e-9):
        return "at its largest value (a cosine)"
    return f"at a phase of {degrees(phase):.4g} deg"
