"""How well each effect can pass for another: python docs/make_mimics.py, some minutes.

A joint is moved at random. The force of one effect (its example) is fitted by a spring, a
damper and another effect with free numbers, once at one level and once at three levels
together. What is left, as a share of what spring and damper alone leave, is written to
effect_mimics.json, from which the pages of the effects take their tables. Nothing of the
diagnosis is used.
"""

import json
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from shakerproc.data import FloatArray
from shakerproc.models.effects import EXAMPLES
from shakerproc.models.effects.base import AbstractEffect

FILE = Path(__file__).with_name("effect_mimics.json")
LEFT_OUT = {
    "spring", "damper", "attached_mode", "stiffness_drift", "constant_force", "series", "table",
    "power_iwan", "general_bouc_wen",
}  # fmt: skip
LEVELS = {"one level": (1.0,), "three levels": (0.25, 0.5, 1.0)}
RATE, SECONDS, LARGEST, BAND = 4000.0, 0.4, 1.5e-4, (30.0, 90.0)
FACTORS = (1.0, 0.4, 2.5)
"""Where fits start, as multiples of the numbers of the example."""


def motion() -> tuple[FloatArray, FloatArray]:
    """Return displacement [m] and velocity [m/s] of a joint that is shaken at random."""
    rng = np.random.default_rng(5)
    n = round(SECONDS * RATE)
    frequency = np.fft.rfftfreq(n, 1.0 / RATE)
    spectrum = rng.standard_normal(frequency.size) + 1j * rng.standard_normal(frequency.size)
    spectrum[(frequency < BAND[0]) | (frequency > BAND[1])] = 0.0
    displacement = np.fft.irfft(spectrum, n)
    velocity = np.fft.irfft(2j * np.pi * frequency * spectrum, n)
    largest = np.max(np.abs(displacement)) / LARGEST
    return displacement / largest, velocity / largest


def force(effect: AbstractEffect, levels: tuple[float, ...]) -> FloatArray:
    """Return the force along the motion at each level, each level of unit weight."""
    z, v = motion()
    return np.concatenate([effect.force_along(a * z, a * v, RATE) / a for a in levels])


def left(target: FloatArray, columns: list[FloatArray]) -> FloatArray:
    """Return what the best combination of columns leaves of a target."""
    matrix = np.column_stack(columns) / [np.max(np.abs(c)) or 1.0 for c in columns]
    weights = np.linalg.lstsq(matrix, target, rcond=None)[0]
    return np.asarray(target - matrix @ weights)


def linear(levels: tuple[float, ...]) -> list[FloatArray]:
    """Return the columns of spring and damper."""
    z, v = motion()
    return [np.tile(z, len(levels)), np.tile(v, len(levels))]


def mimicked(truth: AbstractEffect, other: AbstractEffect, levels: tuple[float, ...]) -> float:
    """Return the share that the other effect leaves, with its best numbers."""
    target = force(truth, levels)
    known = linear(levels)
    alone = float(np.linalg.norm(left(target, known)))
    free = [n for n, p in other.parameters.items() if isinstance(getattr(other, n), float)]
    free = [n for n in free if n != "exponent"] + [n for n in free if n == "exponent"]

    def made(logs: FloatArray) -> AbstractEffect:
        values = {
            n: float(getattr(other, n) * np.exp(x)) for n, x in zip(free, logs, strict=True)
        }
        if "exponent" in values:
            values["exponent"] = max(values["exponent"], 1.0)
        if "breakaway_force" in values:
            values["breakaway_force"] = max(values["breakaway_force"], values["sliding_force"])
        return replace(other, **values)  # type: ignore[type-var]

    def rest(logs: FloatArray) -> FloatArray:
        try:
            column = force(made(logs), levels)
        except (ValueError, FloatingPointError):
            return target
        if not np.all(np.isfinite(column)):
            return target
        return left(target, [*known, column]) / alone

    best = 1.0
    for factor in FACTORS:
        start = np.array([0.0 if n == "exponent" else np.log(factor) for n in free])
        found = least_squares(rest, start, bounds=(-6.0, 6.0), diff_step=1e-3, max_nfev=40)
        best = min(best, float(np.linalg.norm(found.fun)))
    return best


def table(tell: Callable[[str], None]) -> dict[str, Any]:
    """Return what each effect leaves of each other."""
    kinds = [kind for kind in EXAMPLES if kind not in LEFT_OUT]
    found: dict[str, Any] = {}
    for truth in kinds:
        tell(truth)
        found[truth] = {
            other: {
                name: round(mimicked(EXAMPLES[truth], EXAMPLES[other], levels), 4)
                for name, levels in LEVELS.items()
            }
            for other in kinds
            if other != truth
        }
    return found


def main() -> None:
    """Write the table."""
    found = table(lambda kind: print(kind, file=sys.stderr))  # noqa: T201
    FILE.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
