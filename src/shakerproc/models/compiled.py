"""Compiled functions whose disk cache follows every source they are made of."""

import hashlib
import re
from collections.abc import Callable, Iterable, Mapping
from functools import cache, partial
from pathlib import Path
from typing import Any, Final, TypeVar, cast, final

from llvmlite import binding
from numba import njit
from numba.core import config, typed_passes, untyped_passes
from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
from numba.core.compiler import Compiler, CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import PassManager
from numba.core.types import Type, unliteral

Function = TypeVar("Function", bound=Callable[..., object])


class _NoEnvironment:
    """The globals of machine code, for a function that has no machine code of its own."""

    @staticmethod
    def set_env(env_name: str, env: object) -> None:
        """Set nothing."""


@final
class _LibraryPart(JITCodeLibrary):
    """A function as part of others, neither optimised as a whole nor made machine code.

    Numba does both with each function and all that it calls, and again in each that calls it:
    six times with a law in a stepper, which was half of the time of compiling.
    """

    codegen = _NoEnvironment()

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0: there is no machine code."""
        self._ensure_finalized()  # type: ignore[no-untyped-call]
        return 0

    def _optimize_final_module(self) -> None:
        """Leave it to the function that this is a part of."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()  # type: ignore[no-untyped-call]
        self._verify_declare_only_symbols()  # type: ignore[no-untyped-call]
        self._finalized = True


_PASSES: Final[tuple[Any, ...]] = tuple(
    getattr(untyped_passes, name, None) or getattr(typed_passes, name, None)
    for name in (
        "TranslateByteCode", "FixupArgs", "IRProcessing", "GenericRewrites", "ReconstructSSA",
        "NopythonTypeInference", "PreLowerStripPhis", "IRLegalization", "NativeLowering",
        "NoPythonBackend",
    )
)  # fmt: skip
"""What numba does with a part. Left out is what finds nothing to do in loops over numbers
(closures, array expressions, overloads, branches that types decide): an eighth of the time."""


@final
class _PartCompiler(CompilerBase):
    """Numba's compiler, for parts."""

    def define_pipelines(self) -> list[object]:
        """Return the steps of numba that parts need; they fill the library that they find."""
        state = self.state
        library: Any = _LibraryPart
        manager: Any = PassManager
        state.library = library(state.targetctx.codegen(), state.func_id.func_qualname)
        steps = manager("part")
        for step in _PASSES:
            steps.add_pass(step, step.__name__)
        steps.finalize()
        return [steps]


@final
class _Kernel(JITCodeLibrary):
    """A kernel with all its parts, whose loops are left as loops.

    They are short (motions, orders of a series) and their lengths are not known: copies of
    them made three times the code, which took three times as long to make and was no quicker.
    """

    def _optimize_final_module(self) -> None:
        """Let numba optimise, with its own passes but those that copy loops."""
        codegen: Any = self._codegen
        codegen._pass_builder = partial(_builder, codegen._tm)
        try:
            super()._optimize_final_module()  # type: ignore[no-untyped-call]
        finally:
            del codegen._pass_builder


def _builder(machine: object, **options: Any) -> object:
    """Return what builds LLVM's passes, without unrolling of loops."""
    wishes, usual = binding.create_pipeline_tuning_options(), cast("Any", config)
    wishes.speed_level = options.get("opt", usual.OPT)
    wishes.loop_unrolling = False
    wishes.loop_vectorization = False
    wishes.slp_vectorization = options.get("slp_vectorize", usual.SLP_VECTORIZE)
    return binding.create_pass_builder(machine, wishes)


@final
class _KernelCompiler(CompilerBase):
    """Numba's compiler, for kernels."""

    def define_pipelines(self) -> list[object]:
        """Return the steps of numba; they fill the library that they find."""
        state = self.state
        library: Any = _Kernel
        steps: Any = DefaultPassBuilder
        state.library = library(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return [steps.define_nopython_pipeline(state)]


_STEPS = (
    "_ensure_finalized",
    "_finalize_dynamic_globals",
    "_finalize_final_module",
    "_optimize_final_module",
    "_verify_declare_only_symbols",
)
_KNOWN = all(_PASSES) and all(hasattr(JITCodeLibrary, step) for step in _STEPS)
_TUNED = hasattr(JITCPUCodegen, "_pass_builder")
_PART: Callable[..., Callable[..., object]] = partial(
    njit,
    pipeline_class=_PartCompiler if _KNOWN else Compiler,
    error_model="numpy",
    nogil=True,
    no_cpython_wrapper=True,
    no_cfunc_wrapper=True,
    _nrt=False,
)
_PACKAGE = Path(__file__).parent.parent
_MODULE = re.compile(r"shakerproc\.(\w+)\.(kernels|laws)(?:\.| import )(\w+)")


@cache
def _sources(path: Path) -> frozenset[Path]:
    """Return a kernel file and all kernel files that it imports, however far down."""
    paths = {path}
    for room, kind, module in _MODULE.findall(path.read_text(encoding="utf-8")):
        folder = _PACKAGE / room / kind
        alone = folder.with_suffix(".py")  # kernels of a room that has few
        paths |= _sources(alone if alone.exists() else folder / f"{module}.py")
    return frozenset(paths)


@cache
def _fingerprint(path: Path) -> str:
    """Return a short hash of all that a kernel file is made of."""
    digest = hashlib.blake2b(digest_size=4)
    for source in sorted(_sources(path)):
        digest.update(source.read_bytes())
    return digest.hexdigest()


def compiled(function: Function) -> Function:
    """Return the function compiled by numba, cached on disk; its loops stay loops.

    Numba looks only at the file a function stands in when it decides whether a cached
    compilation is still good, not at the files of the functions it calls; so the name under
    which it is cached carries a hash of all those files. Kernels call kernels only.
    """
    return _kernel(function, _KernelCompiler if _TUNED else Compiler)


def vectorised(function: Function) -> Function:
    """Return the function compiled as by `compiled`, with loops made for long ones.

    Several numbers are taken at once, eight times over: in matrices of twelve masses half of
    the time, in a motion of one mass more than without.
    """
    return _kernel(function, Compiler)


def _kernel(function: Function, compiler: type[CompilerBase]) -> Function:
    path = Path(function.__code__.co_filename)
    function.__qualname__ = f"{function.__qualname__}_{_fingerprint(path)}"
    wrap = njit(cache=True, error_model="numpy", nogil=True, pipeline_class=compiler)
    return cast("Function", wrap(function))


def inner(function: Function) -> Function:
    """Return the function compiled for the use of other kernels only.

    It is compiled into each of them, and cached with them. Python cannot call it, which saves
    compiling the conversion of its arguments; and it cannot make arrays, which saves counting
    the references to those it is given (a factor of three in speed).
    """
    return cast("Function", _PART(function))


def inlined(function: Function) -> Function:
    """Return the function compiled into the very place it is called from.

    A call hands over each array as seven numbers and more; that takes longer than what a
    small function does with them. It is typed once for all numbers, where numba would do so for
    each number that stands in the source of a call, too: laws once for order 0 and once for all
    others. The optimiser knows the number all the same, as it sees the place of the call.
    """
    part: Any = _PART(forceinline=True)(function)
    of_types, of_any = part.get_call_template, cast("Callable[[Type], Type]", unliteral)

    def of_numbers(args: Iterable[Type], kws: Mapping[str, Type]) -> object:
        general = {name: of_any(one) for name, one in kws.items()}
        return of_types(tuple(map(of_any, args)), general)

    part.get_call_template = of_numbers
    return cast("Function", part)
