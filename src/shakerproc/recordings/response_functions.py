"""Measured response functions: of an analyser's file, brought into one matrix in SI.

A file holds functions one by one: response functions, coherences, and auto and cross spectra,
of which response functions are made where it holds no others. All that go into the matrix have
the same lines.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Final, Literal, TypeAlias, final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import RecordingError
from shakerproc.geometry import Place, Wireframe
from shakerproc.late import loaded
from shakerproc.recordings.guard import shown
from shakerproc.recordings.si import parse_unit
from shakerproc.recordings.source_files import sha256

Kind: TypeAlias = Literal[
    "response function",
    "coherence",
    "multiple coherence",
    "cross spectrum",
    "auto spectrum",
    "spectrum",
]

SAME_LINE: Final = 0.01
"""How far lines of two functions may lie apart that are one, in steps [-]: the format prints
their step to six digits."""

_TABLES: Final = (".csv", ".txt", ".xlsx", ".parquet", ".feather")
READERS: Final[Mapping[str, str]] = MappingProxyType(
    dict.fromkeys((".uff", ".unv", ".uf58"), "uff:read_uff_functions")
    | dict.fromkeys(_TABLES, "function_tables:read_table_functions")
    | {".mat": "function_tables:read_mat_functions"}
)
"""What reads functions, by the ending of the file, below `shakerproc.recordings`."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Function:
    """One function as a file holds it.

    Attributes
    ----------
    where : str
        Where it stands, for messages: ``record 3``.
    kind : str
        What it is.
    response, input : str
        Names of the channels or places; alike of an auto spectrum.
    response_unit, input_unit : str
        As the file says them; empty where it does not.
    frequency : (n_lines,) array
        Of the lines [Hz].
    values : (n_lines,) complex array
        In the units of the file; a coherence [-].
    """

    where: str
    kind: Kind
    response: str
    input: str
    response_unit: str
    input_unit: str
    frequency: FloatArray
    values: ComplexArray


@final
@dataclass(frozen=True, slots=True, eq=False)
class FunctionFile:
    """The functions of a file, and its further statements.

    Attributes
    ----------
    functions : tuple of Function
        In the order of the file.
    places : mapping
        Position [m] and direction [-] of channels, by name, where the file says them.
    notes : tuple of str
        What the reader had to decide or left out.
    wireframe : Wireframe, optional
        Nodes with lines or surfaces; None where the file holds none.
    """

    functions: tuple[Function, ...]
    places: Mapping[str, tuple[Place, Place]]
    notes: tuple[str, ...] = ()
    wireframe: Wireframe | None = None


@final
@dataclass(frozen=True, slots=True, eq=False)
class ResponseFunctions:
    """Measured response functions between inputs and responses, in SI.

    Attributes
    ----------
    name : str
        Of the file, without its ending.
    responses, inputs : tuple of str
        Names of the channels or places.
    response_units, input_units : tuple of str
        SI units of each.
    frequency : (n_lines,) array
        Rising [Hz].
    values : (n_responses, n_inputs, n_lines) complex array
        Response functions [response unit/input unit].
    coherence : (n_responses, n_inputs, n_lines) array, optional
        Ordinary coherence [-]; None where the file does not hold that of each.
    positions, directions : tuple
        Of the responses [m], [-]; None where the file does not say them.
    input_places : tuple
        Position and direction of each input, likewise.
    notes : tuple of str
        What was decided or left out, a sentence each.
    sha256 : str
        Of the file.
    wireframe : Wireframe, optional
        Nodes with lines or surfaces; None where the file holds none.
    """

    name: str
    responses: tuple[str, ...]
    inputs: tuple[str, ...]
    response_units: tuple[str, ...]
    input_units: tuple[str, ...]
    frequency: FloatArray
    values: ComplexArray
    coherence: FloatArray | None
    positions: tuple[Place | None, ...]
    directions: tuple[Place | None, ...]
    input_places: tuple[tuple[Place | None, Place | None], ...]
    notes: tuple[str, ...]
    sha256: str
    wireframe: Wireframe | None = None

    @property
    def turned(self) -> "ResponseFunctions":
        """The functions with input and response exchanged.

        A structure that is linear and passive answers alike either way (reciprocity): a roving
        hammer and one sensor tell the same shapes as one hammer and many sensors.
        """
        places = zip(self.positions, self.directions, strict=True)
        return replace(
            self,
            responses=self.inputs,
            inputs=self.responses,
            response_units=self.response_units * len(self.inputs),
            input_units=self.input_units[:1],
            values=self.values.swapaxes(0, 1),
            coherence=None if self.coherence is None else self.coherence.swapaxes(0, 1),
            positions=tuple(position for position, _ in self.input_places),
            directions=tuple(direction for _, direction in self.input_places),
            input_places=tuple(places),
        )


def holds_functions(path: Path) -> bool:
    """Return whether a file is one of response functions by its ending, and not a test log."""
    return path.suffix.lower() in READERS


def read_functions(path: Path) -> ResponseFunctions:
    """Return the response functions that a file holds.

    Raises
    ------
    RecordingError
        If it holds none, they do not fit together, or it cannot be read.
    """
    run = path.name
    place = READERS.get(path.suffix.lower())
    if place is None:
        raise RecordingError(
            f"{run}: no reader of response functions for {path.suffix or 'no ending'}. "
            f"Shakerproc reads {', '.join(READERS)}."
        )
    read: Callable[[Path, str], FunctionFile] = loaded(f"shakerproc.recordings.{place}")
    digest = sha256(path)
    with np.errstate(all="ignore"):  # values that are no numbers are told
        return matrix_of(read(path, run), path.stem, run, digest)


def matrix_of(file: FunctionFile, name: str, run: str, digest: str) -> ResponseFunctions:
    """Return functions as one matrix: all responses to each input that has them all.

    Raises
    ------
    RecordingError
        If there are none, or they have different lines or units.
    """
    notes = list(file.notes)
    by_pair = _distinct([f for f in file.functions if f.kind == "response function"], run)
    if not by_pair:
        by_pair, told = _of_spectra(file.functions, run)
        notes += told
    if not by_pair:
        by_pair, told = _of_one_record(file.functions, run)
        notes += told
    if not by_pair:
        kinds = sorted({f.kind for f in file.functions})
        raise RecordingError(
            f"{run}: no response functions in it{': ' * bool(kinds)}{', '.join(kinds)}. Export "
            "the functions between responses and inputs, or the samples over time."
        )
    _check_units(by_pair, run)
    chosen, told = _complete(by_pair)
    notes += told
    lines = _common_lines(list(chosen.values()), run)
    responses = tuple(dict.fromkeys(response for response, _ in chosen))
    inputs = tuple(dict.fromkeys(driven for _, driven in chosen))
    values = np.array([[_in_si(chosen[r, i], run) for i in inputs] for r in responses])
    if not np.all(np.isfinite(values)):
        raise RecordingError(f"{run}: values that are no numbers. Export the functions again.")
    coherence, told = _coherence(file.functions, responses, inputs, lines.size)
    notes += told
    first = {name: chosen[name, inputs[0]] for name in responses}
    none: tuple[Place | None, Place | None] = (None, None)
    seats = [file.places.get(name, none) for name in responses]
    return ResponseFunctions(
        name=name,
        responses=responses,
        inputs=inputs,
        response_units=tuple(_si(first[r].response_unit, run)[0] for r in responses),
        input_units=tuple(_si(chosen[responses[0], i].input_unit, run)[0] for i in inputs),
        frequency=lines,
        values=values,
        coherence=coherence,
        positions=tuple(position for position, _ in seats),
        directions=tuple(direction for _, direction in seats),
        input_places=tuple(file.places.get(driven, none) for driven in inputs),
        notes=tuple(notes),
        sha256=digest,
        wireframe=file.wireframe,
    )


def _distinct(functions: Sequence[Function], run: str) -> dict[tuple[str, str], Function]:
    """Return functions by response and input.

    Raises
    ------
    RecordingError
        If two are between the same and differ.
    """
    by_pair: dict[tuple[str, str], Function] = {}
    for one in functions:
        other = by_pair.setdefault((one.response, one.input), one)
        if other is not one and not np.array_equal(other.values, one.values):
            raise RecordingError(
                f"{run}: {other.where} and {one.where} are both of {one.response} to "
                f"{one.input}. Export each function once, with its node and direction."
            )
    return by_pair


def _of_spectra(
    functions: Sequence[Function], run: str
) -> tuple[dict[tuple[str, str], Function], list[str]]:
    r"""Return H1 of cross and auto spectra, :math:`G_{xy} / G_{xx}`, of each response.

    Raises
    ------
    RecordingError
        If two have different lines.
    """
    autos = [f for f in functions if f.kind == "auto spectrum"]
    by_pair = {}
    for cross in (f for f in functions if f.kind == "cross spectrum"):
        # force and acceleration of a driving point have one name: their units tell them apart
        there = [auto for auto in autos if auto.response == cross.input]
        auto = next(
            (a for a in there if _of_one_quantity(a.response_unit, cross.input_unit)),
            there[0] if len(there) == 1 and not cross.input_unit else None,
        )
        if auto is None:
            continue
        _common_lines([cross, auto], run)
        values = cross.values / auto.values
        if cross.input_unit:
            values *= _si(cross.input_unit, run)[1] / _si(auto.response_unit, run)[1]
        one = replace(
            cross, kind="response function", values=values, input_unit=auto.response_unit
        )
        by_pair[cross.response, cross.input] = one
    sentences = [f"{len(by_pair)} response functions are made of cross and auto spectra (H1)."]
    return by_pair, sentences * bool(by_pair)


def _of_one_record(
    functions: Sequence[Function], run: str
) -> tuple[dict[tuple[str, str], Function], list[str]]:
    """Return the ratios of complex spectra to that of the one force among them, and a note.

    Raises
    ------
    RecordingError
        If two have different lines.
    """
    spectra = [f for f in functions if f.kind == "spectrum" and np.any(f.values.imag)]
    forces = [f for f in spectra if _of_one_quantity(f.response_unit, "N")]
    if len(forces) != 1:
        return {}, []
    force, by_pair = forces[0], {}
    for one in (f for f in spectra if f is not force):
        _common_lines([one, force], run)
        by_pair[one.response, force.response] = replace(
            one, kind="response function", values=one.values / force.values,
            input=force.response, input_unit=force.response_unit,
        )  # fmt: skip
    text = (
        f"{len(by_pair)} response functions are ratios of spectra of one record to that of "
        f"{force.response}: without averages, noise of the force makes them smaller."
    )
    return by_pair, [text] * bool(by_pair)


def _of_one_quantity(first: str, second: str) -> bool:
    """Return whether two units are of one quantity."""
    one, other = parse_unit(first), parse_unit(second)
    return one is not None and other is not None and one[0] == other[0]


def _check_units(functions: Mapping[tuple[str, str], Function], run: str) -> None:
    """Pass functions whose units are known.

    Raises
    ------
    RecordingError
        If one is not.
    """
    for one in functions.values():
        _si(one.response_unit, f"{run}: {one.where}")
        _si(one.input_unit, f"{run}: {one.where}")


def _si(unit: str, where: str) -> tuple[str, float]:
    """Return SI unit and factor of a unit.

    Raises
    ------
    RecordingError
        If it is none.
    """
    known = parse_unit(unit)
    if known is None:
        said = f"the unit {shown(unit, 30)} is unknown" if unit else "the unit is not said"
        raise RecordingError(
            f"{where}: {said}. Export the functions with units such as m/s^2/N."
        )
    return known


def _in_si(one: Function, run: str) -> ComplexArray:
    up, down = (_si(unit, run)[1] for unit in (one.response_unit, one.input_unit))
    return np.asarray(one.values * (up / down))


def _complete(
    functions: Mapping[tuple[str, str], Function],
) -> tuple[dict[tuple[str, str], Function], list[str]]:
    """Return the functions of the inputs to which most responses are there, and a note."""
    inputs = list(dict.fromkeys(driven for _, driven in functions))
    rows = {i: [r for r, driven in functions if driven == i] for i in inputs}
    most = max(rows.values(), key=len)
    kept = [i for i in inputs if set(rows[i]) == set(most)]
    chosen = {(r, i): functions[r, i] for r in most for i in kept}
    unused = [f"{r} to {i}" for r, i in functions if i not in kept]
    more = f" and {len(unused) - 12} more" if len(unused) > 12 else ""
    text = f"Not used, other inputs have more responses: {', '.join(unused[:12])}{more}."
    return chosen, [text] * bool(unused)


def _common_lines(functions: Sequence[Function], run: str) -> FloatArray:
    """Return the lines of functions [Hz].

    Raises
    ------
    RecordingError
        If one has others, or they do not rise.
    """
    first = functions[0]
    step = float(np.min(np.diff(first.frequency), initial=np.inf))
    if first.frequency.size < 2 or not step > 0.0 or not np.all(np.isfinite(first.frequency)):
        raise RecordingError(f"{run}: {first.where}: its frequencies do not rise.")
    for one in functions[1:]:
        if (
            one.frequency.size != first.frequency.size
            or np.max(np.abs(one.frequency - first.frequency)) > SAME_LINE * step
        ):
            raise RecordingError(
                f"{run}: {one.where} has other frequencies ({_range(one)}) than {first.where} "
                f"({_range(first)}). Export all functions with the same lines."
            )
    return first.frequency


def _range(one: Function) -> str:
    low, high = float(one.frequency[0]), float(one.frequency[-1])
    return f"{one.frequency.size} lines from {low:g} to {high:g} Hz"


def _coherence(
    functions: Sequence[Function], responses: Sequence[str], inputs: Sequence[str], n: int
) -> tuple[FloatArray | None, list[str]]:
    """Return the coherence of each function, None where one lacks it, and a note.

    Where a response has no coherence to an input, its multiple coherence to all inputs counts.
    """
    coherences = {
        (f.response, f.input): f.values.real for f in functions if f.kind == "coherence"
    }
    every = {f.response: f.values.real for f in functions if f.kind == "multiple coherence"}
    if not coherences and not every:
        return None, []
    none = np.empty(0)
    rows = [[coherences.get((r, i), every.get(r, none)) for i in inputs] for r in responses]
    if any(one.size != n for row in rows for one in row):
        return None, ["The coherences do not belong to all functions and are not used."]
    return np.clip(np.array(rows), 0.0, 1.0), []
