"""The commands, one in each file, and the mapping of them all.

A command is loaded when it is asked for. That must stay light: heavy packages are imported
inside its function.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Final, TypeAlias, final

from shakerproc.late import loaded

if TYPE_CHECKING:
    import typer

Command: TypeAlias = "Callable[..., None] | typer.Typer"

_NAMES: Final = (
    "demo", "init", "inspect", "process", "batch", "watch", "check", "compare", "diagnose",
    "add", "effects", "simulate", "response", "study", "plan", "forecast", "modal", "stiffness",
    "modes", "nastran", "convert", "doctor",
)  # fmt: skip
"""In the order of the help; each is also the name of its file, and of its function there."""


@final
class _Commands(Mapping[str, Command]):
    """Every command by its name, loaded when it is asked for."""

    def __getitem__(self, name: str) -> Command:
        if name not in _NAMES:
            raise KeyError(name)
        command: Command = loaded(f"{__name__}.{name}:{name}")
        return command

    def __iter__(self) -> Iterator[str]:
        return iter(_NAMES)

    def __len__(self) -> int:
        return len(_NAMES)

    def __contains__(self, name: object) -> bool:
        return name in _NAMES


COMMANDS: Final = _Commands()
"""Every command by its name."""
