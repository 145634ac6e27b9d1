"""Which kind of file a YAML file is: the key that each kind has at its top."""

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Final

KINDS: Final[Mapping[str, str]] = MappingProxyType({
    "testlog": "a test log",
    "study": "a study",
    "coupon": "a coupon",
    "model": "a model",
    "structure": "a structure",
    "materials": "a file of materials",
    "specimens": "a file of specimens",
})
"""What a file is by its key; the first that it has counts, for some have further ones."""

_LOOKED_AT: Final = 65_536
_KEY: Final = re.compile(r"^([a-z]+)[ \t]*:", re.MULTILINE)


def kind_of(keys: Iterable[object]) -> str:
    """Return the kind of a file with these keys, such as ``a model``; empty if unknown."""
    found = set(keys)
    return next((name for key, name in KINDS.items() if key in found), "")


def kind_of_file(path: Path) -> str:
    """Return the apparent kind of a file by the keys at the start of its lines."""
    try:
        with path.open("rb") as file:
            text = file.read(_LOOKED_AT).decode("utf-8", errors="replace")
    except OSError:
        return ""
    return kind_of(_KEY.findall(text))
