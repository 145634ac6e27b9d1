"""A task on a machine of the cluster, in a child process, as on one machine."""

import threading
from collections.abc import Mapping
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from typing import Any, Final

from shakerproc import __version__
from shakerproc.executors.base import TaskOutcome
from shakerproc.executors.processes import Child, Limits, wait

_DECIDING: Final = ("numpy", "scipy", "numba", "pandas", "pyarrow", "matplotlib", "nptdms")
"""Packages on whose version the last digit, or the bytes of a file, may depend."""


def versions() -> dict[str, str]:
    """Return the version of everything that may decide the last digit of a result."""
    found = {"shakerproc": __version__}
    for name in _DECIDING:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "none"
    return found


class _Kept(threading.local):
    """The child process of this thread of the worker, and what it was told to do."""

    child: Child | None = None
    orders: bytes = b""
    limits: Limits | None = None


_KEPT: Final = _Kept()


def attempt(
    name: str, orders: bytes, argument: bytes, limits: Limits, wanted: Mapping[str, str]
) -> dict[str, Any]:
    """Return the outcome of a task as plain data, whatever happens in it.

    The child process stays for the next task of this thread. Where it was killed from outside,
    the task is tried once more in another one.

    Parameters
    ----------
    name : str
        Name of the task.
    orders, argument : bytes
        What is to be done with what, as the child process takes it.
    limits : Limits
        What the task may take.
    wanted : mapping of str to str
        The versions of the machine that asks.
    """
    other = [
        f"{n} {v} here, {wanted[n]} there" for n, v in versions().items() if wanted[n] != v
    ]
    if other:
        error = (
            f"the worker has other versions than the machine that asks: {', '.join(other)}; "
            "the results would not be the same to the last digit. Install the same on both."
        )
        return asdict(TaskOutcome(name, cause="error", error=error))
    outcome = _done(name, orders, argument, limits)
    if outcome.cause == "killed":
        outcome = _done(name, orders, argument, limits)
    return asdict(outcome)


def _done(name: str, orders: bytes, argument: bytes, limits: Limits) -> TaskOutcome:
    child = _child(orders, limits)
    child.give(name, argument)
    while True:
        wait([child])
        outcome = child.look()
        if outcome is not None:
            return outcome


def _child(orders: bytes, limits: Limits) -> Child:
    """Return the process of this thread, told what to do; a new one where there is none."""
    kept = _KEPT.child
    usable = kept is not None and not kept.ended and kept.alive
    if kept is None or not usable or _KEPT.limits != limits:
        if kept is not None and not kept.ended:
            kept.kill()
        _KEPT.child, _KEPT.orders, _KEPT.limits = Child(limits, orders), orders, limits
        return _KEPT.child
    if _KEPT.orders != orders:
        kept.order(orders)
        _KEPT.orders = orders
    return kept
