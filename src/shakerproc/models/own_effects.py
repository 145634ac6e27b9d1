"""The mapping of all effects, and whether one that comes from outside can be used."""

import inspect
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from importlib.metadata import EntryPoint, entry_points
from threading import RLock
from typing import Any, Final, TypeAlias, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.errors import ModelError
from shakerproc.models.effects.base import AbstractEffect, AbstractMemorylessEffect, Parameter
from shakerproc.models.faults import FAULTS
from shakerproc.models.identification import JointScales
from shakerproc.numerals import numeral

Kinds: TypeAlias = Mapping[str, type[AbstractEffect]]

GROUP: Final = "shakerproc.effects"
"""Entry points of packages that bring effects: each names a class, or a module with some."""


@final
class EffectRegistry(Mapping[str, type[AbstractEffect]]):
    """Effects by kind.

    Those of installed packages are looked for when all are listed, or one is asked for that is
    not there. The user's own ones of this run are given by `use_own`.
    """

    def __init__(self, known: Kinds) -> None:
        self._known = dict(known)
        self._installed: dict[str, type[AbstractEffect]] | None = None
        self._from_user: dict[str, type[AbstractEffect]] = {}
        self._looking = RLock()

    def __getitem__(self, kind: str) -> "type[AbstractEffect]":
        effect = self._known.get(kind) or self._from_user.get(kind)
        return effect or self._all()[kind]

    def __iter__(self) -> Iterator[str]:
        return iter(self._all())

    def __len__(self) -> int:
        return len(self._all())

    @property
    def known(self) -> Kinds:
        """The effects of shakerproc itself."""
        return dict(self._known)

    @property
    def from_user(self) -> Kinds:
        """Effects that the user brought."""
        return dict(self._from_user)

    def use_own(self, effects: Kinds) -> None:
        """Let these be the user's own effects from now on, and no others."""
        self._from_user = dict(effects)

    def _all(self) -> dict[str, type[AbstractEffect]]:
        with self._looking:
            if self._installed is None:
                self._installed = {}  # what looks for them may list the others
                try:
                    self._installed = _installed(self._known)
                except BaseException:
                    self._installed = None  # the next call says so again
                    raise
            return {**self._known, **self._installed, **self._from_user}


def _installed(known: Kinds) -> dict[str, type[AbstractEffect]]:
    """Return the effects of installed packages.

    Raises
    ------
    ModelError
        If one cannot be used.
    """
    effects: dict[str, type[AbstractEffect]] = {}
    for entry in entry_points(group=GROUP):
        effects |= loaded(entry, {**known, **effects})
    return effects


def loaded(entry: EntryPoint, known: Kinds) -> dict[str, type[AbstractEffect]]:
    """Return the effects that an entry point names, each of which can be used.

    Raises
    ------
    ModelError
        If one cannot, or has the name of one that is known.
    """
    where = f"entry point {entry.name} ({entry.value})"
    with failing(where):
        module = entry.load()
    return checked(effects_in(module), where, known)


TYPICAL: Final = JointScales(1e-4, 0.05, 10.0, 1.2e5, 0.0286, 20.0, 5000.0)
"""A small bolted joint on a shaker, for which effects without an example get their numbers."""

FAR: Final = 1e-2
"""Displacement up to which a law is tried [m]."""

FAST: Final = 10.0
"""Velocity up to which a law is tried [m/s]."""

NEAR: Final = 1e-6
"""From which share of these on [-]."""

JUMP: Final = 1e-3
"""A change of force over no way at all that counts as a jump, as a share of the largest [-]."""


@contextmanager
def failing(where: str) -> Iterator[None]:
    """Turn whatever somebody else's code raises into one line that says where.

    Raises
    ------
    ModelError
        If it raises.
    """
    try:
        yield
    except ModelError:
        raise
    except Exception as error:
        line = _line_of(error)
        text = " ".join(str(error).split()) or type(error).__name__
        raise ModelError(
            f"{where}{line}: {type(error).__name__}: {text}. Correct it, or leave it out."
        ) from error


def _line_of(error: BaseException) -> str:
    """Return the line of the last frame that is not shakerproc's own, such as ``, line 12``."""
    if isinstance(error, SyntaxError):
        return f", line {error.lineno}"
    frame, line = error.__traceback__, ""
    while frame is not None:
        name = frame.tb_frame.f_globals.get("__name__", "")
        if not name.startswith(("shakerproc.", "numpy", "importlib", "contextlib")):
            line = f", line {frame.tb_lineno}"
        frame = frame.tb_next
    return line


def effects_in(loaded: Any) -> list[type[AbstractEffect]]:
    """Return the effects that a module defines, or a class that is one."""
    if inspect.isclass(loaded):
        return [loaded] if issubclass(loaded, AbstractEffect) else []
    return [
        one
        for one in vars(loaded).values()
        if inspect.isclass(one)
        and issubclass(one, AbstractEffect)
        and not inspect.isabstract(one)
        and one.__module__ == loaded.__name__
    ]


def checked(
    classes: list[type[AbstractEffect]], where: str, known: Mapping[str, type[AbstractEffect]]
) -> dict[str, type[AbstractEffect]]:
    """Return effects by kind, each of which can be used.

    Parameters
    ----------
    where : str
        Where they come from, for messages.
    known : mapping
        The effects that there are already.

    Raises
    ------
    ModelError
        If there is none, a kind is taken, or a law raises, is not finite, or jumps where its
        `switches` do not say so.
    """
    if not classes:
        raise ModelError(
            f"{where}: no effect in it. Write a class that derives from "
            f"shakerproc.models.AbstractSampledEffect, with kind, parameters, formula, "
            f"signature and force_at."
        )
    kinds: dict[str, type[AbstractEffect]] = {}
    for made in classes:
        place = f"{where}, class {made.__name__}"
        _check_frame(made, place)
        if made.kind in known or made.kind in kinds or made.kind in FAULTS:
            raise ModelError(f"{place}: kind {made.kind!r} exists already. Give it another.")
        with failing(place):
            for effect in tried(made):
                _check_law(effect, place)
        kinds[made.kind] = made
    return kinds


def _check_frame(made: Any, place: str) -> None:
    for name, kind in (("kind", str), ("formula", str), ("signature", str)):
        if not isinstance(getattr(made, name, None), kind):
            raise ModelError(f"{place}: {name} is missing. Give it as a text of the class.")
    if not made.kind.isidentifier():
        raise ModelError(f"{place}: kind {made.kind!r} must be one word of letters, digits, _.")
    known = getattr(made, "parameters", None)
    named = [field.name for field in fields(made)] if is_dataclass(made) else None
    if not isinstance(known, Mapping) or named is None or list(known) != named:
        raise ModelError(
            f"{place}: parameters must hold a Parameter for each field of the dataclass, in "
            f"order ({', '.join(named or ())})."
        )
    if not all(isinstance(parameter, Parameter) for parameter in known.values()):
        raise ModelError(f"{place}: parameters must hold a Parameter for each field.")


def tried(made: type[AbstractEffect]) -> list[AbstractEffect]:
    """Return effects of a class with realistic numbers: its example, and where it is sought.

    Raises
    ------
    ValueError
        If it gives neither.
    """
    effects = [made.example()] if made.example() is not None else []
    sought = made.identification(TYPICAL)
    if sought is not None:
        starts = (sought.starts[0], sought.starts[-1])
        effects += [made.of_numbers(sought.numbers(start)) for start in starts]
    if not effects:
        raise ValueError("neither example() nor identification() gives numbers to try it with")
    return effects  # type: ignore[return-value]


def _check_law(effect: AbstractEffect, place: str) -> None:
    """Pass an effect whose law is finite, and jumps only where it says so.

    Raises
    ------
    ModelError
        If it is not, or does.
    """
    time = np.arange(2000) / 2e4
    z, v = 1e-4 * np.sin(300.0 * time), 0.03 * np.cos(300.0 * time)
    with np.errstate(all="ignore"):
        along = np.asarray(effect.force_along(z, v, 2e4))
    if along.shape != z.shape or not np.all(np.isfinite(along)):
        raise ModelError(
            f"{place}: the force along a sine of 0.1 mm is not {z.size} finite numbers. Return "
            f"an array of the shape of displacement, without NaN."
        )
    if isinstance(effect, AbstractMemorylessEffect):
        _check_values(effect, place)
        _check_jumps(effect, place)
    effect.rows()


def _check_values(effect: AbstractMemorylessEffect, place: str) -> None:
    z, v = np.meshgrid(_both_ways(FAR), _both_ways(FAST), indexing="ij")
    with np.errstate(all="ignore"):
        force = np.asarray(effect.force_at(z, v), float)
    if force.shape != z.shape:
        raise ModelError(
            f"{place}: force_at returns shape {force.shape} for {z.shape}. Use numpy functions."
        )
    if not np.all(np.isfinite(force)):
        i, j = np.argwhere(~np.isfinite(force))[0]
        raise ModelError(
            f"{place}: force_at returns {force[i, j]} at displacement {numeral(z[i, j])} m and "
            f"velocity {numeral(v[i, j])} m/s. Let it be finite up to {FAR:g} m and {FAST:g} "
            "m/s."
        )


def _both_ways(largest: float) -> FloatArray:
    """Return values of both signs and 0, in equal ratios, (241,) array."""
    up = np.geomspace(NEAR * largest, largest, 120)
    return np.concatenate((-up[::-1], [0.0], up))


def _check_jumps(effect: AbstractMemorylessEffect, place: str) -> None:
    for variable, largest, unit in (("displacement", FAR, "m"), ("velocity", FAST, "m/s")):
        known = [switch.at for switch in effect.switches() if switch.variable == variable]
        for other in (0.3 * _other(variable), -0.2 * _other(variable)):
            for at in jumps(_along(effect, variable, other), largest):
                if np.any(np.isclose(at, known, rtol=1e-6, atol=1e-9 * largest)):
                    continue
                if variable == "velocity" and abs(at) < 1e-9 * largest:
                    raise ModelError(
                        f"{place}: the force jumps where velocity changes sign, so that the "
                        f"joint sticks there. Write rows() with Law.FRICTION, or smooth it."
                    )
                raise ModelError(
                    f"{place}: the force jumps at {variable} {at:.6g} {unit}, and switches() "
                    f'does not say so. Return Switch("{variable}", {at:.6g}) there, or smooth '
                    f"it."
                )


def _other(variable: str) -> float:
    """Return a usual size of the variable that is held [m/s] or [m]."""
    return TYPICAL.velocity if variable == "displacement" else TYPICAL.displacement


def _along(
    effect: AbstractMemorylessEffect, variable: str, other: float
) -> Callable[[FloatArray], FloatArray]:
    def law(at: FloatArray) -> FloatArray:
        held = np.full_like(at, other)
        with np.errstate(all="ignore"):
            if variable == "displacement":
                return np.asarray(effect.force_at(at, held), float)
            return np.asarray(effect.force_at(held, at), float)

    return law


def jumps(law: Callable[[FloatArray], FloatArray], largest: float) -> FloatArray:
    """Return where a law of one variable jumps, between its values of both signs, (n,) array.

    Each stretch is halved again and again towards the half that changes more. A law without a
    jump changes by nothing in the end.

    `largest` is in the unit of the variable.
    """
    ends = _both_ways(largest)
    low, high = ends[:-1].copy(), ends[1:].copy()
    at_low, at_high = law(low), law(high)
    scale = np.max(np.abs(law(ends)))
    for _ in range(60):
        middle = 0.5 * (low + high)
        at_middle = law(middle)
        is_below = np.abs(at_middle - at_low) >= np.abs(at_high - at_middle)
        low, at_low = np.where(is_below, low, middle), np.where(is_below, at_low, at_middle)
        high, at_high = np.where(is_below, middle, high), np.where(is_below, at_middle, at_high)
    values: FloatArray = np.unique(high[np.abs(at_high - at_low) > JUMP * max(scale, 1e-300)])
    return values
