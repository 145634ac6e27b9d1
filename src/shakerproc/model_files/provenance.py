"""Where a fitted effect comes from, as a model file says it."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final

from shakerproc.model_files.writing import number, text_of
from shakerproc.models.model import Element
from shakerproc.models.motion import Motion, unit_in


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
