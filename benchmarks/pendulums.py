"""Pendulums before a camera, by scipy, and what `diagnose` says of them.

``python -m benchmarks.pendulums [CASE ...]``

Truth and program share no code. A swing softens by its sine, drag is viscous or as the square
of the velocity, and the pivot may have dry friction; each is weak in some cases. Printed are
what is hidden, what is named with its probability, the held-out error before and after, and the
processor time.
"""

import argparse
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from scipy.integrate import solve_ivp

from shakerproc.diagnosis.api import diagnose
from shakerproc.model_files import read_model
from shakerproc.testlog import read_testlog

LENGTH, MASS, GRAVITY = 0.35, 0.2, 9.81
"""Of all pendulums [m], [kg], [m/s^2]."""

MODEL: Final = """model: 1
title: small swings
masses: {bob: 0.2 kg}
elements:
  - {kind: spring, between: [base, bob], stiffness: 5.606 N/m}
  - {kind: damper, between: [base, bob], damping: 0.01 N s/m}
excitation: {free: decay}
sensors: {x: {at: bob, measures: displacement}}
"""
LOG: Final = """testlog: 1
title: a pendulum
recordings: .
channels: {x: {role: displacement, at: bob, unit: m}}
processing: {crop: none}
tests: [{id: 1, recording: d.npz, excitation: free decay}]
"""


@dataclass(frozen=True, slots=True)
class Pendulum:
    """A swing, what slows it, and how it is recorded.

    Attributes
    ----------
    swing : float
        Angle from which it is let go [rad].
    viscous, quadratic, dry : float
        Angular deceleration over angular velocity [1/s], over its square [-], and of friction
        [rad/s^2].
    rate, noise, seconds : float
        Pictures per second [Hz], noise [m], length of the recording [s].
    held, offset : float
        Time for which it is held before [s], and the place of the camera's zero [m].
    """

    swing: float
    viscous: float
    quadratic: float
    dry: float
    rate: float
    noise: float
    seconds: float
    held: float = 0.0
    offset: float = 0.0

    def recorded(self, seed: int) -> np.ndarray:
        """Return what the camera sees, (n,) array [m]."""

        def falls(_t: float, y: np.ndarray) -> list[float]:
            drag = self.viscous * y[1] + self.quadratic * abs(y[1]) * y[1]
            friction = self.dry * np.tanh(y[1] / 0.003)
            return [y[1], -GRAVITY / LENGTH * np.sin(y[0]) - drag - friction]

        times = np.arange(round(self.seconds * self.rate)) / self.rate
        swung = solve_ivp(
            falls, (0.0, self.seconds), [self.swing, 0.0], t_eval=times, rtol=1e-9, atol=1e-11,
            max_step=0.005,
        ).y[0]  # fmt: skip
        before = np.full(round(self.held * self.rate), self.swing)
        seen = LENGTH * np.concatenate([before, swung]) + self.offset
        return seen + self.noise * np.random.default_rng(seed).standard_normal(seen.size)


SOFTER, DRY, DRAG = "cubic_stiffness", "coulomb_friction", "quadratic_damping"
CASES: Final = {
    "weak softening": (Pendulum(0.1, 0.06, 0.0, 0.0, 60.0, 2e-4, 30.0), {SOFTER}),
    "softening": (Pendulum(0.6, 0.06, 0.0, 0.0, 30.0, 5e-4, 40.0), {SOFTER}),
    "softening beyond its cube": (Pendulum(1.4, 0.08, 0.0, 0.0, 60.0, 5e-4, 30.0), {SOFTER}),
    "softening in noise": (Pendulum(0.4, 0.05, 0.0, 0.0, 30.0, 2e-3, 60.0), {SOFTER}),
    "weak dry friction": (Pendulum(0.12, 0.02, 0.0, 0.03, 100.0, 2e-4, 20.0), {DRY, SOFTER}),
    "both": (Pendulum(0.7, 0.02, 0.0, 0.12, 60.0, 5e-4, 30.0), {DRY, SOFTER}),
    "both, stronger": (Pendulum(1.0, 0.03, 0.0, 0.2, 100.0, 3e-4, 20.0), {DRY, SOFTER}),
    "weak drag of air": (Pendulum(0.15, 0.01, 0.3, 0.0, 60.0, 2e-4, 60.0), {DRAG, SOFTER}),
    "drag of air": (Pendulum(0.8, 0.01, 0.15, 0.0, 60.0, 3e-4, 60.0), {DRAG, SOFTER}),
    "held, with an offset": (
        Pendulum(0.8, 0.05, 0.0, 0.0, 60.0, 5e-4, 30.0, 2.0, 0.03), {SOFTER},
    ),
    "dry friction, held": (
        Pendulum(0.15, 0.01, 0.0, 0.05, 240.0, 1e-4, 15.0, 1.0), {DRY, SOFTER},
    ),
}  # fmt: skip


def main() -> None:
    """Diagnose all cases, or those that are named."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.pendulums", description=__doc__)
    parser.add_argument("cases", nargs="*", help=", ".join(CASES))
    parser.add_argument("--seed", type=int, default=0, help="of the noise")
    options = parser.parse_args()
    for name in options.cases or CASES:
        pendulum, hidden = CASES[name]
        begun = time.process_time()
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            seen = pendulum.recorded(options.seed)
            np.savez(folder / "d.npz", fs=np.array([pendulum.rate]), x=seen)
            (folder / "model.yaml").write_text(MODEL)
            (folder / "testlog.yaml").write_text(LOG)
            found = diagnose(
                read_model(folder / "model.yaml"), read_testlog(folder / "testlog.yaml")
            )
        named, error = {one.kind for one in found.effects}, found.errors.held_out
        said = f"{found.verdict} {'+'.join(sorted(named))}, {found.confidence}"
        print(
            f"{'ok  ' if named == hidden else 'MISS'} {name}: hidden "
            f"{'+'.join(sorted(hidden))}; {said}, {error.before:.3g} -> {error.after:.3g}, "
            f"{time.process_time() - begun:.0f} s",
            flush=True,
        )


if __name__ == "__main__":
    main()
