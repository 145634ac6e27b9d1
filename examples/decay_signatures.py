"""What friction, a gap, quadratic damping and a cubic spring look like in a free decay.

Each model is let go from 1 mm by the simulator, and its decay is read as a measured one is.
``python examples/decay_signatures.py PICTURE.png`` draws the page of the manual.
"""

import sys
from collections.abc import Mapping
from typing import Final

import numpy as np

from shakerproc.models import Element, Excitation, Model, Sensor
from shakerproc.models.effects import (
    CoulombFriction,
    CubicStiffness,
    Damper,
    Gap,
    Jenkins,
    QuadraticDamping,
    Spring,
)
from shakerproc.models.effects.base import AbstractEffect
from shakerproc.simulation import simulate
from shakerproc.spectra.decays import DecayCurve, decay_curve, decay_lines, trend_of

MASS, STIFFNESS, DAMPING, START = 1.0, 1e5, 1.9, 1e-3  # 50.3 Hz, 0.3 %, from 1 mm
RATE, SECONDS = 4096.0, 6.0
NOISE = 1e-8  # rms [m]

LAWS: Final[Mapping[str, tuple[AbstractEffect, ...]]] = {
    "linear": (),
    "dry friction": (CoulombFriction(sliding_force=0.2),),
    "gap of 0.1 mm": (Gap(stiffness=3e4, clearance=1e-4),),
    "quadratic damping": (QuadraticDamping(coefficient=30.0),),
    "cubic spring": (CubicStiffness(coefficient=2e10),),
    "slip in a joint": (Jenkins(stiffness=1e4, slip_force=1.0),),
}


def decay_of(law: tuple[AbstractEffect, ...]) -> DecayCurve:
    """Return the curve of a mass on a spring and a damper, and a further law."""
    laws = (Spring(stiffness=STIFFNESS), Damper(damping=DAMPING), *law)
    model = Model(
        title="a decay",
        masses={"mass": MASS},
        elements=tuple(Element(one, ("base", "mass")) for one in laws),
        excitation=Excitation("free decay"),
        sensors={"x": Sensor("mass", "relative displacement")},
    )
    motion = simulate(
        model, np.zeros(round(SECONDS * RATE)), RATE, start={"mass": (START, 0.0)}, growth=False
    )
    samples = motion.outputs["x"]
    samples = samples + NOISE * np.random.default_rng(1).standard_normal(samples.size)
    (line,) = decay_lines(samples[np.newaxis], RATE, (20.0, 100.0), count=1)
    return decay_curve(samples, RATE, line)


def draw(path: str) -> None:
    """Draw frequency and damping of every law against amplitude, both methods."""
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 4.2), layout="constrained")
    for i, (name, curve) in enumerate(curves.items()):
        for readings, dash in ((curve.fitted, "-"), (curve.charted, ":")):
            x = [1e3 * one.amplitude for one in readings]
            look = {
                "color": f"C{i}",
                "linestyle": dash,
                "linewidth": 1.3 if dash == "-" else 3.0,
            }
            label = name if dash == "-" else "_"
            left.plot(x, [one.frequency for one in readings], label=label, **look)
            right.plot(x, [100.0 * one.damping for one in readings], label=label, **look)
    for axis, label in ((left, "natural frequency [Hz]"), (right, "damping ratio [%]")):
        axis.set(xscale="log", xlabel="amplitude [mm]", ylabel=label, xlim=(3e-3, 1.0))
        axis.grid(color="#dddddd", linewidth=0.6)
    right.set(yscale="log", ylim=(0.2, 3.0), yticks=(0.2, 0.5, 1.0, 2.0))
    right.set_yticklabels(["0.2", "0.5", "1", "2"])
    right.yaxis.set_minor_locator(plt.NullLocator())
    left.legend(frameon=False, fontsize=8)
    figure.suptitle("Line: least squares; dots: peaks and crossings", fontsize=9, x=0.2)
    figure.savefig(path, dpi=110)


curves = {name: decay_of(law) for name, law in LAWS.items()}
trends = {name: trend_of(curve.fitted) for name, curve in curves.items()}

if __name__ == "__main__":
    for name, curve in curves.items():
        first, last, trend = curve.fitted[0], curve.fitted[-1], trends[name]
        print(
            f"{name}: {last.frequency:.2f} to {first.frequency:.2f} Hz, "
            f"{100.0 * last.damping:.2f} to {100.0 * first.damping:.2f} %, "
            f"law {trend.law if trend else None}"
        )
    if len(sys.argv) > 1:
        draw(sys.argv[1])
