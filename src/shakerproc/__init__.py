"""From shaker recordings to the physical effect that the model left out.

>>> import shakerproc as sp
>>> log, model = sp.read_log("testlog.yaml"), sp.read_model("model.yaml")
>>> sp.diagnose(model, log)

Each function is loaded when it is first used: this import alone takes no time. A function is
what the command of its name calls. What is wrong with the input raises a `ShakerprocError`
whose message is the line that the command prints; nothing is printed, and nothing is written
unless a place for it is given.
"""

from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from shakerproc.errors import ArgumentError, ShakerprocError

if TYPE_CHECKING:
    from shakerproc.workflows.arguments import read_log, read_model
    from shakerproc.workflows.campaign import batch
    from shakerproc.workflows.comparison import compare
    from shakerproc.workflows.diagnosis import diagnose
    from shakerproc.workflows.effect_list import effects
    from shakerproc.workflows.forecast import forecast
    from shakerproc.workflows.modes import modes
    from shakerproc.workflows.run import open_recording, process
    from shakerproc.workflows.simulation import simulate
    from shakerproc.workflows.updated_model import add

__version__ = "0.1.0"

__all__ = [
    "ArgumentError",
    "ShakerprocError",
    "add",
    "batch",
    "compare",
    "diagnose",
    "effects",
    "forecast",
    "modes",
    "open_recording",
    "process",
    "read_log",
    "read_model",
    "simulate",
]

API: Final = MappingProxyType({
    "open_recording": "run",
    "read_log": "arguments",
    "read_model": "arguments",
    "process": "run",
    "batch": "campaign",
    "modes": "modes",
    "compare": "comparison",
    "diagnose": "diagnosis",
    "add": "updated_model",
    "simulate": "simulation",
    "effects": "effect_list",
    "forecast": "forecast",
})
"""Where in `shakerproc.workflows` each function is."""


def __getattr__(name: str) -> Any:
    if name not in API:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    function = getattr(import_module(f"{__name__}.workflows.{API[name]}"), name)
    globals()[name] = function
    return function


def __dir__() -> list[str]:
    return sorted({*globals(), *API})
