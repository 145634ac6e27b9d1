"""A study: a model, its run, the quantity measured, and the parameters that vary by place."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Final, Literal, TypeAlias, final

from shakerproc.finite_elements.coupon import ThermalFit, clearances_at
from shakerproc.models import Element, Model
from shakerproc.models.effects import Gap, OffsetGap
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


TEMPERATURE: Final = "joint.temperature"
"""The place that sets the clearance of every gap by thermal expansion."""

RUN_UNITS: Final[Mapping[str, str]] = {
    "from": "Hz",
    "to": "Hz",
    "frequency": "Hz",
    "phase": "rad",
    "duration": "s",
    "sample rate": "Hz",
    "initial displacement": "m",
    "initial velocity": "m/s",
    "settle": "1",
    "seed": "1",
    "tolerance": "1",
}
"""Places of a run and their units; ``level`` takes that of the model's excitation."""

RUN_FIELDS: Final[Mapping[str, str]] = {"from": "from_hz", "to": "to_hz"}


def unit_of_place(model: Model, place: str, warmth: Warmth | None = None) -> str:
    """Return the SI unit of a place; ``1`` for a plain number.

    Raises
    ------
    ValueError
        If there is no such place, with what there is.
    """
    if place == TEMPERATURE:
        _check_temperature(model, warmth)
        return "K"
    head, *rest = place.split(".")
    if head == "masses" and len(rest) == 1:
        _one_of("mass", rest[0], list(model.masses))
        return model.unit_of("kg")
    if head == "run" and len(rest) == 1:
        if rest[0] == "level":
            return model.drive_unit
        _one_of("key of the run", rest[0], [*RUN_UNITS, "level"])
        return RUN_UNITS[rest[0]]
    if head == "elements" and len(rest) == 2:
        effect = model.elements[_index(model, rest[0])].effect
        _one_of(f"parameter of {effect.kind}", rest[1], list(effect.parameters))
        return model.unit_of(effect.parameters[rest[1]].unit)
    raise ValueError(
        f"expected a place such as elements.gap.clearance, "
        f"masses.{next(iter(model.masses), 'coupon')}, run.level or {TEMPERATURE}, "
        f"got {place!r}"
    )


def placed(
    model: Model,
    run: StudyRun | None,
    places: Sequence[str],
    value: float,
    warmth: Warmth | None = None,
) -> tuple[Model, StudyRun | None]:
    """Return model and run with a value [SI] set at every place."""
    for place in places:
        head, *rest = place.split(".")
        if place == TEMPERATURE and warmth is not None:
            model = at_temperature(model, warmth, value)
        elif head == "masses":
            model = replace(model, masses={**model.masses, rest[0]: value})
        elif head == "elements":
            model = _with_parameter(model, _index(model, rest[0]), rest[1], value)
        elif run is not None:
            run = _with_field(run, rest[0], value)
    return model, run


def at_temperature(model: Model, warmth: Warmth, temperature: float) -> Model:
    """Return the model with the clearances that its gaps have at a temperature [K].

    A joint that is squeezed has no clearance; that it then grips is not modelled.
    """
    change = temperature - warmth.reference
    elements = []
    for element in model.elements:
        effect = element.effect
        if isinstance(effect, Gap | OffsetGap):
            wider = 0.5 * (_play_at(effect, warmth, change) - _play_of(effect))
            effect = _widened(effect, wider)
        elements.append(Element(effect, element.between))
    return replace(model, elements=tuple(elements))


def clearance_of(model: Model) -> float | None:
    """Return half the play of the first gap of a model [m]; None where it has none."""
    gaps = (e.effect for e in model.elements if isinstance(e.effect, Gap | OffsetGap))
    return next((0.5 * _play_of(gap) for gap in gaps), None)


def _play_of(gap: Gap | OffsetGap) -> float:
    if isinstance(gap, Gap):
        return 2.0 * gap.clearance
    return gap.clearance_positive + gap.clearance_negative


def _play_at(gap: Gap | OffsetGap, warmth: Warmth, change: float) -> float:
    fit = replace(warmth.fit, opening=warmth.fit.insert + _play_of(gap))
    return max(0.0, clearances_at(fit, change).play)


def _widened(gap: Gap | OffsetGap, wider: float) -> Gap | OffsetGap:
    if isinstance(gap, Gap):
        return replace(gap, clearance=max(0.0, gap.clearance + wider))
    return replace(
        gap,
        clearance_positive=max(0.0, gap.clearance_positive + wider),
        clearance_negative=max(0.0, gap.clearance_negative + wider),
    )


def _check_temperature(model: Model, warmth: Warmth | None) -> None:
    """Pass a model whose gap knows how it expands.

    Raises
    ------
    ValueError
        If it has no gap, or the study names no coupon with a joint.
    """
    if warmth is None:
        raise ValueError(
            f"{TEMPERATURE} needs the key coupon: a coupon file with the size and material of "
            f"its joint"
        )
    if clearance_of(model) is None:
        raise ValueError(f"{TEMPERATURE} needs a gap or an offset_gap in the model")


def _with_parameter(model: Model, index: int, name: str, value: float) -> Model:
    elements = list(model.elements)
    effect = replace(elements[index].effect, **{name: value})  # type: ignore[type-var]
    elements[index] = Element(effect, elements[index].between)
    return replace(model, elements=tuple(elements))


def _with_field(run: StudyRun, name: str, value: float) -> StudyRun:
    field = RUN_FIELDS.get(name, name.replace(" ", "_"))
    kinds = {f.name: f.type for f in fields(run)}
    number = int(value) if kinds[field] in {int, "int"} else value
    return replace(run, **{field: number})  # type: ignore[arg-type]


def _index(model: Model, name: str) -> int:
    """Return which element is meant, by its number from 0 or by its kind.

    Raises
    ------
    ValueError
        If it is not clear which.
    """
    if name.isdigit() and int(name) < len(model.elements):
        return int(name)
    places = [i for i, element in enumerate(model.elements) if element.effect.kind == name]
    if len(places) == 1:
        return places[0]
    kinds = ", ".join(f"{i} ({e.effect.kind})" for i, e in enumerate(model.elements))
    several = "several elements" if places else "no element"
    raise ValueError(f"{several} {name!r}; the model has {kinds}")


def _one_of(what: str, name: str, known: Sequence[str]) -> None:
    """Pass a known name.

    Raises
    ------
    ValueError
        If it is not known.
    """
    if name not in known:
        raise ValueError(f"no {what} {name!r}; there are {', '.join(known)}")
