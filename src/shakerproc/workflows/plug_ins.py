"""Effects and readers of installed packages, and whether they can be used."""

from dataclasses import asdict, dataclass
from importlib.metadata import EntryPoint, entry_points
from typing import Any, final

from shakerproc.errors import ShakerprocError
from shakerproc.models import EFFECTS
from shakerproc.models import registry as effects
from shakerproc.recordings import READERS, readers


@final
@dataclass(frozen=True, slots=True)
class PlugIn:
    """One entry point of an installed package.

    Attributes
    ----------
    group, name, value : str
        As the package declares it.
    package : str
        Name and version of the package.
    brings : tuple of str
        Kinds of effects, or endings of files.
    problem : str
        Why it cannot be used, in a line; empty where it can.
    """

    group: str
    name: str
    value: str
    package: str
    brings: tuple[str, ...] = ()
    problem: str = ""

    def as_json(self) -> dict[str, Any]:
        """Return the part of a document."""
        return asdict(self)


def plug_ins() -> list[PlugIn]:
    """Return every effect and every reader of installed packages, broken ones included."""
    return [*_effects(), *_readers()]


def _effects() -> list[PlugIn]:
    found, known = [], dict(EFFECTS.known)
    for entry in entry_points(group=effects.GROUP):
        try:
            kinds = effects.loaded(entry, known)
        except ShakerprocError as error:
            found.append(_told(entry, problem=str(error)))
            continue
        known |= kinds
        found.append(_told(entry, tuple(kinds)))
    return found


def _readers() -> list[PlugIn]:
    found = []
    taken = dict.fromkeys(READERS.known, "shakerproc itself")
    for entry in entry_points(group=readers.GROUP):
        ending = f".{entry.name.lower()}"
        problem = f"{ending} is read by {taken[ending]}" if ending in taken else ""
        try:
            readers.of_entry(entry)
        except ShakerprocError as error:
            problem = problem or str(error)
        taken.setdefault(ending, f"the package {_package(entry)}")
        found.append(_told(entry, () if problem else (ending,), problem))
    return found


def _told(entry: EntryPoint, brings: tuple[str, ...] = (), problem: str = "") -> PlugIn:
    return PlugIn(entry.group, entry.name, entry.value, _package(entry), brings, problem)


def _package(entry: EntryPoint) -> str:
    return "" if entry.dist is None else f"{entry.dist.name} {entry.dist.version}"
