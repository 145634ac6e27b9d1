"""The mapping of all effects: those of shakerproc, of installed packages and of the user."""

from collections.abc import Iterator, Mapping
from importlib.metadata import EntryPoint, entry_points
from threading import RLock
from typing import TYPE_CHECKING, Final, final

if TYPE_CHECKING:
    from shakerproc.models.effects.base import AbstractEffect

    Kinds = Mapping[str, type[AbstractEffect]]

GROUP: Final = "shakerproc.effects"
"""Entry points of packages that bring effects: each names a class, or a module with some."""


@final
class EffectRegistry(Mapping[str, "type[AbstractEffect]"]):
    """Effects by kind.

    Those of installed packages are looked for when all are listed, or one is asked for that is
    not there. The user's own ones of this run are given by `use_own`.
    """

    def __init__(self, known: "Kinds") -> None:
        self._known = dict(known)
        self._installed: dict[str, type[AbstractEffect]] | None = None
        self._own: dict[str, type[AbstractEffect]] = {}
        self._looking = RLock()

    def __getitem__(self, kind: str) -> "type[AbstractEffect]":
        found = self._known.get(kind) or self._own.get(kind)
        return found or self._all()[kind]

    def __iter__(self) -> Iterator[str]:
        return iter(self._all())

    def __len__(self) -> int:
        return len(self._all())

    @property
    def known(self) -> "Kinds":
        """The effects of shakerproc itself."""
        return dict(self._known)

    @property
    def own(self) -> "Kinds":
        """Effects that the user brought."""
        return dict(self._own)

    def use_own(self, own: "Kinds") -> None:
        """Let these be the user's own effects from now on, and no others."""
        self._own = dict(own)

    def _all(self) -> dict[str, "type[AbstractEffect]"]:
        with self._looking:
            if self._installed is None:
                self._installed = {}  # what looks for them may list the others
                try:
                    self._installed = _installed(self._known)
                except BaseException:
                    self._installed = None  # the next call says so again
                    raise
            return {**self._known, **self._installed, **self._own}


def _installed(known: "Kinds") -> "dict[str, type[AbstractEffect]]":
    """Return the effects of installed packages.

    Raises
    ------
    ModelError
        If one cannot be used.
    """
    found: dict[str, type[AbstractEffect]] = {}
    for entry in entry_points(group=GROUP):
        found |= loaded(entry, {**known, **found})
    return found


def loaded(entry: EntryPoint, known: "Kinds") -> "dict[str, type[AbstractEffect]]":
    """Return the effects that an entry point names, each of which can be used.

    Raises
    ------
    ModelError
        If one cannot, or has the name of one that is known.
    """
    from shakerproc.models.own_effects import checked, effects_in, failing

    where = f"entry point {entry.name} ({entry.value})"
    with failing(where):
        found = entry.load()
    return checked(effects_in(found), where, known)
