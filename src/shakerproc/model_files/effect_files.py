"""Effects of the user's own, from a Python file that is named on the command line.

The file is run, so it is never taken from a test log or a model. What is loaded travels with
every effect that is pickled: a worker runs the same text before it makes the effect.
"""

import copyreg
import hashlib
import sys
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from types import ModuleType
from typing import Any, Final, final

from shakerproc.errors import ModelError
from shakerproc.models import EFFECTS, AbstractEffect
from shakerproc.models.own_effects import checked, effects_in, failing

LARGEST: Final = 2**20
"""Bytes that a file of effects may have."""


@final
@dataclass(frozen=True, slots=True)
class EffectSource:
    """A file of effects, as it was read.

    Attributes
    ----------
    name : str
        Name of the file, for messages.
    text : str
        What stands in it.
    """

    name: str
    text: str

    @property
    def sha256(self) -> str:
        """Hash of the text."""
        return hashlib.sha256(self.text.encode()).hexdigest()

    def use(self) -> Mapping[str, type[AbstractEffect]]:
        """Make its effects known in this process, instead of those of another file.

        Returns
        -------
        mapping of str to type
            Its effects, by kind.

        Raises
        ------
        ModelError
            If one of them cannot be used.
        """
        module = _module(self)
        EFFECTS.use_own({})
        kinds = checked(effects_in(module), self.name, EFFECTS)
        for made in kinds.values():
            copyreg.pickle(made, _Reduced(self))
        EFFECTS.use_own(kinds)
        _USED[:] = [self]
        return kinds


_USED: list[EffectSource] = []
_MODULES: Final[dict[str, ModuleType]] = {}


def load_effects(path: Path) -> Mapping[str, type[AbstractEffect]]:
    """Return the effects of a Python file, by kind, and make them known in this process.

    Raises
    ------
    ModelError
        If the file cannot be read or run, or holds no effect that can be used: one line with
        the file, the line in it and what to do.
    """
    return source_of(path).use()


def source_of(path: Path) -> EffectSource:
    """Return a file of effects.

    Raises
    ------
    ModelError
        If it cannot be read.
    """
    try:
        data = path.read_bytes()[: LARGEST + 1]
        text = data.decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise ModelError(
            f"{path.name}: cannot be read ({error}). Name a Python file of effects."
        ) from error
    if len(data) > LARGEST:
        raise ModelError(f"{path.name}: more than 1 MB. Name a Python file of effects.")
    return EffectSource(path.name, text)


def used_effects() -> EffectSource | None:
    """Return the file whose effects are known in this process, to be sent to workers."""
    return _USED[-1] if _USED else None


def forget_effects() -> None:
    """Know the effects of no file any more."""
    EFFECTS.use_own({})
    _USED.clear()


def effect_hashes() -> dict[str, str]:
    """Return the SHA-256 of the file of effects in use, if any, by its name."""
    return {source.name: source.sha256 for source in _USED}


def _module(source: EffectSource) -> ModuleType:
    """Return the module that the text makes, run once in a process."""
    if source.sha256 in _MODULES:
        return _MODULES[source.sha256]
    module = ModuleType(f"effects_{source.sha256[:16]}")
    module.__file__ = source.name
    sys.modules[module.__name__] = module  # dataclasses look there
    with failing(source.name):
        exec(compile(source.text, source.name, "exec"), module.__dict__)  # noqa: S102 - the user named it
    _MODULES[source.sha256] = module
    return module


@final
@dataclass(frozen=True, slots=True)
class _Reduced:
    """How an effect of a file is pickled: the text of the file, its kind and its numbers."""

    source: EffectSource

    def __call__(self, effect: AbstractEffect) -> tuple[Any, ...]:
        values = {field.name: getattr(effect, field.name) for field in fields(effect)}  # type: ignore[arg-type]
        return _made, (self.source, effect.kind, values)


def _made(source: EffectSource, kind: str, values: Mapping[str, Any]) -> AbstractEffect:
    """Return an effect of a file, in whatever process."""
    known = EFFECTS.from_user if source in _USED else source.use()
    return known[kind](**values)
