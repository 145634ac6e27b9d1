"""The commands, one in each file, and the mapping of them all.

A command is loaded when it is asked for. That must stay light: heavy packages are imported
inside its function.
"""

from collections.abc import Callable, Iterator, Mapping
from functools import wraps
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, TypeAlias, final

from shakerproc.late import loaded

if TYPE_CHECKING:
    import typer

Command: TypeAlias = "Callable[..., None] | typer.Typer"

_NAMES: Final = (
    "demo", "init", "inspect", "process", "batch", "watch", "check", "compare", "diagnose",
    "add", "effects", "simulate", "response", "study", "plan", "forecast", "modal", "stiffness",
    "coupon", "nastran", "convert", "doctor",
)  # fmt: skip
"""In the order of the help; each is also the name of its file, and of its function there."""

FORMER: Final = MappingProxyType({"modes": "coupon"})
"""Former names that still work in this version, and what each is called now."""


@final
class _Commands(Mapping[str, Command]):
    """Every command by its name, loaded when it is asked for."""

    def __getitem__(self, name: str) -> Command:
        if name in FORMER:
            return _under_former_name(self[FORMER[name]], name)
        if name not in _NAMES:
            raise KeyError(name)
        command: Command = loaded(f"{__name__}.{name}:{name}")
        return command

    def __iter__(self) -> Iterator[str]:
        return iter(_NAMES)

    def __len__(self) -> int:
        return len(_NAMES)

    def __contains__(self, name: object) -> bool:
        return name in _NAMES or name in FORMER


def _under_former_name(command: Any, name: str) -> Command:
    """Return a command that says what it is called now."""

    @wraps(command)
    def renamed(*args: Any, **options: Any) -> None:
        from shakerproc.cli import output

        output.warning(
            f"`shakerproc {name}` is called `shakerproc {FORMER[name]}` now. The former name "
            "works in this version only."
        )
        command(*args, **options)

    return renamed


COMMANDS: Final = _Commands()
"""Every command by its name."""
