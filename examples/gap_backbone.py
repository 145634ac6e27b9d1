"""How the resonance of a joint with play moves with amplitude, and its response curve."""

import numpy as np

from shakerproc.models import Element, Excitation, Model, Sensor
from shakerproc.models.effects import Damper, Gap
from shakerproc.simulation.harmonic_balance import backbone, frequency_response

MASS, STIFFNESS, CLEARANCE = 28.6e-3, 1.52e5, 5e-5  # closed joint: 367 Hz
BETWEEN = ("base", "coupon")

model = Model(
    title="coupon with play",
    masses={"coupon": MASS},
    elements=(
        Element(Damper(damping=2.6), BETWEEN),
        Element(Gap(stiffness=STIFFNESS, clearance=CLEARANCE), BETWEEN),
    ),
    excitation=Excitation("base acceleration"),
    sensors={"ch3": Sensor("coupon")},
)
free = backbone(model, (1.1 * CLEARANCE, 20.0 * CLEARANCE))
forced = frequency_response(model, 50.0, from_hz=100.0, to_hz=450.0)  # 50 m/s² of the table
folds = [mark for branch in forced.branches for mark in branch.marks if mark.kind == "fold"]
closed = float(np.sqrt(STIFFNESS / MASS) / (2.0 * np.pi))

if __name__ == "__main__":
    for amplitude, frequency in zip(free.amplitude[::20], free.frequency[::20], strict=True):
        print(f"{1e3 * amplitude:.3f} mm: {frequency:.1f} Hz")
    print(f"closed joint: {closed:.1f} Hz")
    print("a sweep jumps at", ", ".join(f"{fold.frequency:.1f} Hz" for fold in folds))
