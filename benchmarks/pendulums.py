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
from tests.diagnosis.pendulums import diagnosed

from shakerproc.diagnosis.result import Diagnosis


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

    def drag(self, velocity: float) -> float:
        """Return the angular deceleration at an angular velocity [rad/s^2]."""
        smooth = (self.viscous + self.quadratic * abs(velocity)) * velocity
        return float(smooth + self.dry * np.tanh(velocity / 0.003))

    def diagnosed(self, folder: Path, seed: int) -> Diagnosis:
        """Return what is said of its recording, with noise of a seed."""
        found: Diagnosis = diagnosed(
            folder, self.swing, self.drag, rate=self.rate, noise=self.noise,
            seconds=self.seconds, held=self.held, offset=self.offset, seed=seed,
        )  # fmt: skip
        return found


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
    parser.add_argument("--seed", type=int, default=1, help="of the noise")
    options = parser.parse_args()
    unknown = [name for name in options.cases if name not in CASES]
    if unknown:
        parser.error(f"no case '{unknown[0]}'; choose from {', '.join(CASES)}")
    for name in options.cases or CASES:
        pendulum, hidden = CASES[name]
        begun = time.process_time()
        with tempfile.TemporaryDirectory() as place:
            found = pendulum.diagnosed(Path(place), options.seed)
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
