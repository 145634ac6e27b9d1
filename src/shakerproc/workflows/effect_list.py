"""Effects and faults of a model: the list of `shakerproc effects`."""

import inspect
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias, final

from shakerproc.models import FAULTS
from shakerproc.workflows.arguments import choice_of
from shakerproc.workflows.shown import Shown, frame_of_rows, html

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

    from shakerproc.models import AbstractEffect
    from shakerproc.models.faults import AbstractFault


Kind: TypeAlias = "type[AbstractEffect] | type[AbstractFault]"


def known_kinds() -> "Mapping[str, Kind]":
    """Return every effect and every fault by name."""
    from shakerproc.models import EFFECTS, FAULTS

    return {**EFFECTS, **FAULTS}


def document_of(one: "Kind") -> dict[str, object]:
    """Return formula, parameters, signature and references of a kind, for JSON and pages."""
    doc = inspect.getdoc(one) or ""
    description, _, references = doc.partition("References\n----------\n")
    return {
        "formula": one.formula,
        "about": _plain(" ".join(description.split("\n\n")[0].split())),
        "signature": one.signature,
        "parameters": {
            name: {
                "symbol": parameter.symbol,
                "unit": parameter.unit,
                "meaning": parameter.meaning,
                "linear": parameter.linear,
                "sign": parameter.sign,
                "optional": parameter.optional,
                "choices": parameter.choices,
                "holds": parameter.holds,
            }
            for name, parameter in one.parameters.items()
        },
        "references": [
            _plain(" ".join(text.split()))
            for text in re.split(r"^\.\. \[\d+\] ", references, flags=re.MULTILINE)
            if text.strip()
        ],
    }


def _plain(text: str) -> str:
    """Return text without the marks of the manual's formulas."""
    return re.sub(r":math:`([^`]*)`", r"\1", text).replace("\\pm ", "±").replace("``", "")


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Effects(Shown, Mapping[str, Mapping[str, Any]]):
    """Effects and faults by name: formula, parameters with units, signature, references.

    Attributes
    ----------
    documents : mapping of str to mapping
        As ``shakerproc effects --json`` writes them.
    """

    documents: Mapping[str, Mapping[str, Any]]

    def __getitem__(self, kind: str) -> Mapping[str, Any]:
        return self.documents[kind]

    def __iter__(self) -> Iterator[str]:
        return iter(self.documents)

    def __len__(self) -> int:
        return len(self.documents)

    def to_pandas(self) -> "DataFrame":
        """Return a row for each effect and each fault of the measurement."""
        rows = [
            (
                name,
                "fault" if name in FAULTS else "effect",
                one["formula"],
                ", ".join(
                    f"{key} [{p['unit']}]" if p["unit"] else key
                    for key, p in one["parameters"].items()
                ),
                one["signature"],
            )
            for name, one in self.documents.items()
        ]
        return frame_of_rows(("name", "is", "formula", "parameters", "signature"), rows)

    def plot(self, kind: str) -> "Figure":
        """Return the picture of an effect: its loop and its equivalent stiffness.

        Raises
        ------
        ArgumentError
            If there is no such effect.
        """
        from shakerproc.report.figures import style
        from shakerproc.report.models.effects import picture

        with style.look():
            return picture(choice_of("kind", kind, self.documents, "an effect", usual=False))

    def _repr_html_(self) -> str:
        table = self.to_pandas()
        tables = [table[table["is"] == word].drop(columns="is") for word in ("effect", "fault")]
        return "\n".join(
            html(heading, [], part)
            for heading, part in zip(("Effects", "Faults"), tables, strict=True)
        )


def effects() -> Effects:
    """Return the elements of a model: laws of force, and faults of the measurement.

    Those of installed packages are among them.

    Returns
    -------
    Effects
        A mapping from the name to formula, parameters with units, signature and references.

    Raises
    ------
    ModelError
        If an effect of an installed package cannot be used.
    """
    return Effects({name: document_of(kind) for name, kind in known_kinds().items()})
