"""Compiled functions whose disk cache follows every source they are made of."""

import hashlib
import re
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import TypeVar, cast

from numba import njit

Function = TypeVar("Function", bound=Callable[..., object])

_INNER: Callable[..., Callable[..., object]] = partial(
    njit,
    error_model="numpy",
    nogil=True,
    no_cpython_wrapper=True,
    no_cfunc_wrapper=True,
    _nrt=False,
)
_PACKAGE = Path(__file__).parent.parent
_KERNEL = re.compile(r"shakerproc\.(\w+)\.kernels(?:\.| import )(\w+)")


@cache
def _sources(path: Path) -> frozenset[Path]:
    """Return a kernel file and all kernel files that it imports, however far down."""
    found = {path}
    for room, module in _KERNEL.findall(path.read_text(encoding="utf-8")):
        folder = _PACKAGE / room / "kernels"
        alone = folder.with_suffix(".py")  # kernels of a room that has few
        found |= _sources(alone if alone.exists() else folder / f"{module}.py")
    return frozenset(found)


@cache
def _fingerprint(path: Path) -> str:
    """Return a short hash of all that a kernel file is made of."""
    digest = hashlib.blake2b(digest_size=4)
    for source in sorted(_sources(path)):
        digest.update(source.read_bytes())
    return digest.hexdigest()


def compiled(function: Function) -> Function:
    """Return the function compiled by numba, cached on disk.

    Numba looks only at the file a function stands in when it decides whether a cached
    compilation is still good, not at the files of the functions it calls; so the name under
    which it is cached carries a hash of all those files. Kernels call kernels only.
    """
    path = Path(function.__code__.co_filename)
    function.__qualname__ = f"{function.__qualname__}_{_fingerprint(path)}"
    return cast("Function", njit(cache=True, error_model="numpy", nogil=True)(function))


def inner(function: Function) -> Function:
    """Return the function compiled for the use of other kernels only.

    It is compiled into each of them, and cached with them. Python cannot call it, which saves
    compiling the conversion of its arguments; and it cannot make arrays, which saves counting
    the references to those it is given (a factor of three in speed).
    """
    return cast("Function", _INNER(function))


def inlined(function: Function) -> Function:
    """Return the function compiled into the very place it is called from.

    A call hands over each array as seven numbers and more; that takes longer than what a
    small function does with them.
    """
    return cast("Function", _INNER(forceinline=True)(function))
