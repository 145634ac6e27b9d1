"""Model files out: a model, an element, a number with its unit, and where a fit is from."""

import json
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, final

from shakerproc import files
from shakerproc.models.conditions import Scale
from shakerproc.models.effects import SPELLINGS
from shakerproc.models.effects.base import AbstractEffect, Parameter
from shakerproc.models.faults import AbstractFault
from shakerproc.models.model import Element, Model, Sensor
from shakerproc.models.motion import Motion, unit_in
from shakerproc.models.structure import Mode, Structure, StructureMode
from shakerproc.units import from_si, to_si

_SHOWN: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType({
    "m": ("m", "mm", "um", "nm"),
    "kg": ("kg", "g", "mg"),
    "s": ("s", "ms", "us"),
})
_SHAKEN: Final[Mapping[str, str]] = MappingProxyType({
    "base acceleration": "base: acceleration",
    "force": "force on: ",
    "imposed displacement": "displacement of: ",
    "free decay": "free: decay",
})
_PLAIN: Final = re.compile(r"[A-Za-z][A-Za-z0-9_ .()/-]*")
_WRITTEN: Final = {kind: written for (written, _), kind in SPELLINGS.items()}
_NOT_TEXT: Final = frozenset({"true", "false", "null", "yes", "no", "on", "off", "nan", "inf"})


def write_model(
    model: Model,
    path: Path,
    *,
    heading: str = "",
    structures: Mapping[str, str] = MappingProxyType({}),
) -> None:
    """Write a model file, whole or not at all.

    Parameters
    ----------
    model : Model
        The model.
    path : Path
        The file.
    heading : str
        Comment at the top, without ``#``.
    structures : mapping of str to str
        Names of the files, beside this one, that hold structures (see `structure_text`); the
        others are written into this one.
    """
    files.write_text(path, model_text(model, heading=heading, structures=structures))


def structure_text(structure: Structure, title: str) -> str:
    """Return the text of a file of its own for a structure."""
    lines = ["structure: 1", f"title: {text_of(title)}", *structure_lines(structure)]
    return "\n".join(lines) + "\n"


def model_text(
    model: Model,
    *,
    heading: str = "",
    structures: Mapping[str, str] = MappingProxyType({}),
) -> str:
    """Return the text of a model file; see `write_model`."""
    lines = [f"# {line}".rstrip() for line in heading.splitlines()]
    lines += ["model: 1", f"title: {text_of(model.title)}"]
    masses = ", ".join(
        f"{text_of(n)}: {number(m, model.unit_of('kg'))}" for n, m in model.masses.items()
    )
    lines += [f"masses: {{{masses}}}"] if model.masses else []
    if model.structures:
        lines += ["structures:"]
        for name, one in model.structures.items():
            inside = [f"    {line}" for line in structure_lines(one)]
            file = structures.get(name)
            lines += (
                [f"  {text_of(name)}:", *inside]
                if file is None
                else [f"  {text_of(name)}: {text_of(file)}"]
            )
    lines += ["elements:"]
    lines += [f"  - {element_text(element, model.motion)}" for element in model.elements]
    on = model.excitation.on
    shaken = _SHAKEN[model.excitation.kind] + ("" if on is None else text_of(on))
    lines += [f"excitation: {{{shaken}}}"]
    if model.modes:
        lines += ["modes:", *(f"  - {mode_text(mode, model.motion)}" for mode in model.modes)]
    if model.sensors:
        lines += ["sensors:"]
        lines += [
            f"  {text_of(n)}: {_sensor_text(s, model.motion)}" for n, s in model.sensors.items()
        ]
    return "\n".join(lines) + "\n"


def mode_text(mode: Mode, motion: Motion = "translation") -> str:
    """Return a further mode on one line, as it stands in a model file."""
    shares = ", ".join(f"{text_of(n)}: {_digits(s)}" for n, s in mode.participation.items())
    said = [
        f"frequency: {number(mode.frequency, 'Hz')}",
        f"damping_ratio: {number(mode.damping_ratio, '1')}",
        f"mass: {number(mode.mass, unit_in('kg', motion))}",
        f"participation: {{{shares}}}",
    ]
    return f"{{{', '.join(said)}}}"


def structure_lines(structure: Structure) -> list[str]:
    """Return a structure on lines, as it stands in a model file or in one of its own."""
    lines = [f"points: [{', '.join(text_of(point) for point in structure.points)}]"]
    if structure.direction is not None:
        lines.append(f"direction: {text_of(structure.direction)}")
    if structure.residual:
        each = (f"{text_of(p)}: {_digits(r)} m/N" for p, r in structure.residual.items())
        lines.append(f"residual: {{{', '.join(each)}}}")
    if structure.positions:
        each = (
            f"{text_of(p)}: [{', '.join(f'{_digits(v)} m' for v in place)}]"
            for p, place in structure.positions.items()
        )
        lines.append(f"positions: {{{', '.join(each)}}}")
    return [*lines, "modes:", *(f"  - {_structure_mode_text(one)}" for one in structure.modes)]


def structure_in_brackets(structure: Structure, of: str = "") -> str:
    """Return a structure as it stands in a model file, instead of the file `of` its modes."""
    *before, _ = [line for line in structure_lines(structure) if not line.startswith("  - ")]
    modes = (_structure_mode_text(one) for one in structure.modes)
    comment = f"  # of {of}, as fitted" if of else ""
    lines = [*(f"{line}," for line in before), "modes: ["]
    inside = "".join(f"\n    {line}" for line in lines)
    return f"{{{comment}{inside}" + "".join(f"\n      {mode}," for mode in modes) + "\n    ]}"


def _structure_mode_text(mode: StructureMode) -> str:
    said = [
        f"frequency: {number(mode.frequency, 'Hz')}",
        f"damping_ratio: {number(mode.damping_ratio, '1')}",
        f"shape: [{', '.join(map(_digits, mode.shape))}]",
    ]
    if mode.participation is not None:
        said.append(f"participation: {_digits(mode.participation)} sqrt(kg)")
    return f"{{{', '.join(said)}}}"


def element_text(element: Element, motion: Motion = "translation") -> str:
    """Return an element on one line, as it stands in a model file."""
    between = ", ".join(text_of(place) for place in element.between)
    start = [f"kind: {written_kind(element.effect)}", f"between: [{between}]"]
    scaled = (
        [] if element.scaled_by is None else [f"scaled_by: {_scale_text(element.scaled_by)}"]
    )
    return f"{{{', '.join(start + _parameters(element.effect, motion) + scaled)}}}"


def _scale_text(scale: Scale) -> str:
    return f"{{{text_of(scale.condition)}: {scale.at}}}"


def written_kind(effect: AbstractEffect) -> str:
    """Return the kind that a model file names an effect by."""
    return _WRITTEN.get(effect.kind, effect.kind)


def number(value: float, unit: str) -> str:
    """Return a number with its unit that reads back as exactly the same value.

    Lengths, masses and times are shown in the larger of the usual units that leaves at least
    one digit before the point.
    """
    if unit == "1":
        return _digits(value)
    for shown in _SHOWN.get(unit, (unit,)):
        in_unit = from_si(value, unit, shown) if shown != unit else value
        if abs(in_unit) >= 1.0 or value == 0.0:
            for digits in range(1, 18):
                text = f"{_digits(float(f'{in_unit:.{digits}g}'))} {shown}"
                if to_si(text, unit) == value:
                    return text
    return f"{_digits(value)} {unit}"


def within(value: float, unit: str, low: float | None, high: float | None) -> float:
    """Return a value near, with as few digits as its interval bears out.

    It moves by a thousandth of the way to the nearer end of the interval at most: numbers
    that were fitted together are correlated, and a tenth of it may double the error.

    Parameters
    ----------
    value : float
        A fitted number [SI].
    unit : str
        Its unit, in which, or in a smaller one, it is written (see `number`).
    low, high : float, optional
        Its interval [SI]; without one, six digits are kept.

    Returns
    -------
    float
        What the shorter text reads back as.
    """
    ends = [abs(value - end) for end in (low, high) if end is not None and math.isfinite(end)]
    room = 1e-3 * min(ends, default=0.0) or 1e-6 * abs(value)
    in_units = [(one, from_si(value, unit, one)) for one in _SHOWN.get(unit, ())]
    shown, there = next((one for one in in_units if abs(one[1]) >= 1.0), (unit, value))
    for digits in range(2, 17):
        text = f"{there:.{digits}g}" if unit == "1" else f"{there:.{digits}g} {shown}"
        si_value = to_si(text, unit)
        if abs(si_value - value) <= room:
            return si_value
    return value


def text_of(text: str) -> str:
    """Return text as YAML: plain where that is safe, in quotes elsewhere."""
    if _PLAIN.fullmatch(text) and text.lower() not in _NOT_TEXT and text == text.strip():
        return text
    return json.dumps(text, ensure_ascii=False)


def parameter_text(value: Any, parameter: Parameter, motion: Motion = "translation") -> str:
    """Return the value of a parameter as it stands in a model file."""
    if isinstance(value, str):
        return value
    if parameter.holds == "effects":
        return _effects(value, motion)
    return _TEXTS[parameter.holds](value, unit_in(parameter.unit, motion))


def _numbers(values: Sequence[float], unit: str) -> str:
    return f"{' '.join(_digits(value) for value in values)} {unit}"


def _rows(rows: Sequence[Sequence[float]], unit: str) -> str:
    return f"[{', '.join(_numbers(row, unit) for row in rows)}]"


def _effects(effects: Sequence[AbstractEffect], motion: Motion) -> str:
    texts = (", ".join([f"kind: {written_kind(e)}", *_parameters(e, motion)]) for e in effects)
    return f"[{', '.join(f'{{{text}}}' for text in texts)}]"


def _parameters(kind: AbstractEffect | AbstractFault, motion: Motion) -> list[str]:
    written = []
    for one in fields(kind):  # type: ignore[arg-type]
        value = getattr(kind, one.name)
        if value is not None:
            text = parameter_text(value, kind.parameters[one.name], motion)
            written.append(f"{one.name}: {text}")
    return written


def _sensor_text(sensor: Sensor, motion: Motion) -> str:
    said = [f"at: {text_of(sensor.at)}", f"measures: {sensor.measures}"]
    if sensor.faults:
        faults = [
            "{" + ", ".join([f"kind: {f.kind}", *_parameters(f, motion)]) + "}"
            for f in sensor.faults
        ]
        said.append(f"faults: [{', '.join(faults)}]")
    return f"{{{', '.join(said)}}}"


def _digits(value: float) -> str:
    """Return the shortest digits that read back as the same number.

    Raises
    ------
    ValueError
        If it is not finite.
    """
    if not math.isfinite(value):
        raise ValueError(f"a model file cannot hold {value}")
    text = repr(float(value))
    return text.removesuffix(".0").replace("e+", "e")


_TEXTS: Final[Mapping[str, Callable[[Any, str], str]]] = MappingProxyType({
    "number": number,
    "numbers": _numbers,
    "rows": _rows,
})


@final
@dataclass(frozen=True, slots=True)
class Provenance:
    """Where a fitted effect comes from; it is written into the model file.

    Attributes
    ----------
    tests : tuple of str or int
        Tests of the log that it was fitted to.
    hashes : mapping of str to str
        SHA-256 of each file that went in, by its name.
    intervals : mapping of str to (float, float)
        Confidence interval of each fitted parameter of the effect [SI].
    program : str
        Name and version of the program.
    date : str
        ISO date.
    """

    tests: tuple[str | int, ...] = ()
    hashes: Mapping[str, str] = field(default_factory=dict)
    intervals: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    program: str = ""
    date: str = ""


def record_lines(
    source: str, element: Element, provenance: Provenance, motion: Motion = "translation"
) -> list[str]:
    """Return the lines of a list item that say where an element comes from.

    Parameters
    ----------
    source : str
        Name of the model file that it was added to.
    element : Element
        The element.
    provenance : Provenance
        Where its numbers come from.
    motion : Motion
        Of the masses of the model: says the units.
    """
    parameters = element.effect.estimated()
    between = ", ".join(text_of(place) for place in element.between)
    lines = [f"- added: {element.effect.kind}", f"  between: [{between}]"]
    lines.append(f"  from model: {text_of(source)}")
    if provenance.tests:
        tests = ", ".join(
            t if isinstance(t, str) and t.isalpha() else _key(t) for t in provenance.tests
        )
        lines.append(f"  tests: [{tests}]")
    if provenance.hashes:
        lines.append("  sha256:")
        lines += [
            f"    {_key(name)}: {_key(digest)}" for name, digest in provenance.hashes.items()
        ]
    if provenance.intervals:
        lines.append("  intervals:")
        for name, (low, high) in provenance.intervals.items():
            unit = unit_in(parameters[name].unit, motion)
            limits = ", ".join(_key(number(value, unit)) for value in (low, high))
            lines.append(f"    {name}: [{limits}]")
    if provenance.program:
        lines.append(f"  program: {_key(provenance.program)}")
    if provenance.date:
        lines.append(f"  date: {_key(provenance.date)}")
    return lines


def _key(value: str | int) -> str:
    """Return a whole number plain and text in quotes, so that a hash stays text."""
    return str(value) if isinstance(value, int) else json.dumps(value, ensure_ascii=False)
