"""The commands, one in each file, and the mapping of them all.

Importing a command must stay light: heavy packages are imported inside the function.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import typer

from shakerproc.cli.commands.add import add
from shakerproc.cli.commands.batch import batch
from shakerproc.cli.commands.check import check
from shakerproc.cli.commands.compare import compare
from shakerproc.cli.commands.convert import convert
from shakerproc.cli.commands.demo import demo
from shakerproc.cli.commands.diagnose import diagnose
from shakerproc.cli.commands.doctor import doctor
from shakerproc.cli.commands.effects import effects
from shakerproc.cli.commands.init import init
from shakerproc.cli.commands.inspect import inspect
from shakerproc.cli.commands.modal import modal
from shakerproc.cli.commands.modes import modes
from shakerproc.cli.commands.nastran import nastran
from shakerproc.cli.commands.plan import plan
from shakerproc.cli.commands.process import process
from shakerproc.cli.commands.response import response
from shakerproc.cli.commands.simulate import simulate
from shakerproc.cli.commands.stiffness import stiffness
from shakerproc.cli.commands.study import study
from shakerproc.cli.commands.watch import watch

COMMANDS: Mapping[str, Callable[..., None] | typer.Typer] = MappingProxyType({
    "demo": demo,
    "init": init,
    "inspect": inspect,
    "process": process,
    "batch": batch,
    "watch": watch,
    "check": check,
    "compare": compare,
    "diagnose": diagnose,
    "add": add,
    "effects": effects,
    "simulate": simulate,
    "response": response,
    "study": study,
    "plan": plan,
    "modal": modal,
    "stiffness": stiffness,
    "modes": modes,
    "nastran": nastran,
    "convert": convert,
    "doctor": doctor,
})
