"""A study: a model, its run, the varied parameters, the measured quantity."""

from dataclasses import dataclass
from typing import Literal, TypeAlias, final

from shakerproc.finite_elements.thermal import ThermalFit
from shakerproc.models import Model
from shakerproc.simulation.inputs import MOST_SAMPLES
from shakerproc.studies.results import Check

Excitation: TypeAlias = Literal["free", "sine", "sine sweep", "random"]
Quantity: TypeAlias = Literal["acceleration", "velocity", "displacement"]
Method: TypeAlias = Literal["exact", "Newmark", "RK45", "BDF"]


@final
@dataclass(frozen=True, slots=True)
class StudyRun:
    """One simulated run.

    Attributes
    ----------
    excitation : str
        ``free`` (from an initial state), ``sine``, ``sine sweep`` or ``random``.
    level : float
        Amplitude [m/s²] or [N]; of random excitation its rms.
    from_hz, to_hz : float
        Band of a sweep or of random excitation [Hz].
    frequency : float
        Frequency of a sine [Hz].
    duration : float
        Length [s].
    sample_rate : float
        Samples per second of the results [Hz].
    down : bool
        Whether a sweep runs downwards.
    octaves : bool
        Whether a sweep takes as long for every octave, not for every hertz.
    phase : float
        Phase of a sine at the start: 0 begins as a sine, pi / 2 as a cosine [rad].
    initial_displacement, initial_velocity : float
        State of the first mass at the start, relative to the base [m] and [m/s].
    settle : float
        Share of the run left out of what is measured [-].
    seed : int
        Seed of random excitation.
    method : str
        ``exact``, or a method of the thesis' kind to compare with: ``Newmark`` (a step a
        sample), ``RK45`` (as MATLAB's ode45) or ``BDF`` (close to its ode15s).
    tolerance : float
        Relative tolerance of RK45 and BDF; MATLAB's default is 1e-3 [-].
    """

    excitation: Excitation
    level: float = 0.0
    from_hz: float = 0.0
    to_hz: float = 0.0
    frequency: float = 0.0
    duration: float = 30.0
    sample_rate: float = 500.0
    down: bool = False
    octaves: bool = False
    phase: float = 0.0
    initial_displacement: float = 0.0
    initial_velocity: float = 0.0
    settle: float = 0.0
    seed: int = 0
    method: Method = "exact"
    tolerance: float = 1e-3


@final
@dataclass(frozen=True, slots=True)
class Measure:
    """Reading taken from a run.

    Attributes
    ----------
    of : str
        Which motion of the first mass.
    estimator : str
        ``periodogram`` of the whole run, or ``welch`` in segments.
    segment : int
        Samples of a Welch segment.
    take : str
        ``tallest`` peak, or ``first`` by frequency (of at least a thousandth of the tallest).
    from_hz, to_hz : float
        Band in which the peak is sought [Hz]; 0 for the whole.
    ensemble : int
        How many neighbouring runs give the spread where the motion is chaotic.
    """

    of: Quantity = "acceleration"
    estimator: Literal["periodogram", "welch"] = "periodogram"
    segment: int = 2048
    take: Literal["tallest", "first"] = "tallest"
    from_hz: float = 0.0
    to_hz: float = 0.0
    ensemble: int = 16


@final
@dataclass(frozen=True, slots=True)
class Variation:
    """One parameter that takes several values.

    Attributes
    ----------
    name : str
        Its letter or word in tables.
    unit : str
        SI unit of the values.
    places : tuple of str
        What is set: ``elements.gap.clearance``, ``masses.coupon``, ``run.level``, ...
    values : tuple of float
        Values [SI].
    texts : tuple of str
        The values as the study writes them.
    """

    name: str
    unit: str
    places: tuple[str, ...]
    values: tuple[float, ...]
    texts: tuple[str, ...]


@final
@dataclass(frozen=True, slots=True)
class Warmth:
    """How the play of a joint changes with its temperature.

    Attributes
    ----------
    fit : ThermalFit
        Sizes and materials of opening and insert; the play itself is the model's.
    reference : float
        Temperature at which the joint has the model's clearance [K].
    """

    fit: ThermalFit
    reference: float


@final
@dataclass(frozen=True, slots=True)
class Claim:
    """A published statement, and how it is put to the test.

    Attributes
    ----------
    statement : str
        The statement.
    checks : tuple of Check
        What must come true for it to hold; without any it is not checked.
    comment : str
        A caption.
    notes : tuple of str
        What to say of how it is written: quantities by former names.
    """

    statement: str
    checks: tuple[Check, ...] = ()
    comment: str = ""
    notes: tuple[str, ...] = ()


@final
@dataclass(frozen=True, slots=True)
class Study:
    """A study, ready to run.

    Attributes
    ----------
    title : str
        Headline.
    kind : str
        Key in `KINDS`.
    figure : str
        Figure of the thesis that it draws; empty for none.
    model : Model or None
        What is shaken; a formula needs none.
    run : StudyRun or None
        How; curves need none.
    measure : Measure
        What is read.
    vary : tuple of Variation
        Parameters and their values.
    claim : Claim or None
        The statement that it puts to the test.
    options : mapping of str to float
        Numbers that only some kinds know.
    formula : str
        Which closed form.
    warmth : Warmth or None
        How the joint expands, where its temperature is varied.
    """

    title: str
    kind: str
    figure: str
    model: Model | None
    run: StudyRun | None
    measure: Measure
    vary: tuple[Variation, ...]
    claim: Claim | None
    options: tuple[tuple[str, float], ...]
    formula: str = ""
    warmth: Warmth | None = None

    def option(self, name: str, default: float) -> float:
        """Return one of the options. `default` is in the unit of the option."""
        return dict(self.options).get(name, default)


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
    """Check that a run holds the quantity to be read.

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
