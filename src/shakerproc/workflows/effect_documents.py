"""Description of an effect or a fault, for `shakerproc effects` and the manual."""

import inspect
import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from shakerproc.models import AbstractEffect
    from shakerproc.models.faults import AbstractFault

    Kind = type[AbstractEffect] | type[AbstractFault]


def known_kinds() -> "Mapping[str, Kind]":
    """Return every effect and every fault by name."""
    from shakerproc.models import EFFECTS, FAULTS

    return {**EFFECTS, **FAULTS}


def document_of(one: "Kind") -> dict[str, object]:
    """Return formula, parameters, signature and references of a kind, for JSON and pages."""
    doc = inspect.getdoc(one) or ""
    told, _, references = doc.partition("References\n----------\n")
    return {
        "formula": one.formula,
        "about": _plain(" ".join(told.split("\n\n")[0].split())),
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
