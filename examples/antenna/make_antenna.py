"""An antenna on three feet, one of them with a hidden clearance: structure, model, truth, log.

``python make_antenna.py FOLDER`` writes four files. The antenna is a plate by the built-in
finite elements, free, with its rigid-body modes. Glued to three alike feet it resonates at
62 Hz; while the clearance of foot 2 is open, at 56 Hz.
"""

import sys
from pathlib import Path

from shakerproc.finite_elements.rectangular_plate import Plate, free_plate_modes
from shakerproc.model_files import structure_text, write_model
from shakerproc.models import Element, Excitation, Model, Sensor
from shakerproc.models.effects import Damper, Gap, Spring
from shakerproc.models.structure import Structure, StructureMode

PLATE = Plate(0.5, 0.3, 5e-3, youngs_modulus=70e9, poissons_ratio=0.33, density=2700.0)
POINTS = {  # m
    "foot 1": (0.03, 0.15),
    "foot 2": (0.33, 0.03),
    "foot 3": (0.33, 0.27),
    "corner": (0.47, 0.04),
    "tip": (0.50, 0.15),
}
MODES, DAMPING_RATIO = 9, 0.005
GLUED = 5.79e5  # stiffness of a foot [N/m]
LOOSE = 1.42e5  # that of foot 2 while its clearance is open [N/m]
CLEARANCE = 2e-5  # m
SENSORS = ("tip", "corner", "foot 1")  # none on the feet 2 and 3

LOG = """\
testlog: 1
title: antenna on three feet
processing: {crop: none}
channels:
  control: {role: control}
  tip: {role: response, at: tip}
  corner: {role: response, at: corner}
  foot 1: {role: response, at: foot 1}
tests:
  - {id: 1, recording: low.tdms, excitation: random, level: 0.00002 g^2/Hz,
     from: 20 Hz, to: 300 Hz}
  - {id: 2, recording: high.tdms, excitation: random, level: 0.001 g^2/Hz,
     from: 20 Hz, to: 300 Hz}
  - {id: 3, recording: kept.tdms, excitation: random, level: 0.0005 g^2/Hz,
     from: 20 Hz, to: 300 Hz, hold_out: true}
"""


def antenna() -> Structure:
    """Return the plate by its modes."""
    frequencies, shapes = free_plate_modes(PLATE, list(POINTS.values()), MODES)
    modes = (
        StructureMode(f, DAMPING_RATIO if f else 0.0, tuple(shape))
        for f, shape in zip(frequencies, shapes.T, strict=True)
    )
    positions = {name: (x, y, 0.0) for name, (x, y) in POINTS.items()}
    return Structure(tuple(POINTS), tuple(modes), positions=positions)


def on_feet(title: str, stiffness: tuple[float, float, float], *more: Element) -> Model:
    """Return the antenna on three feet of given stiffness [N/m]."""
    feet = [
        Element(law, ("base", f"foot {i}"))
        for i, k in enumerate(stiffness, 1)
        for law in (Spring(stiffness=k), Damper(damping=40.0))
    ]
    sensors = {name: Sensor(name) for name in SENSORS}
    return Model(
        title, {}, (*feet, *more), Excitation("base acceleration"), sensors,
        structures={"antenna": antenna()},
    )  # fmt: skip


def glued() -> Model:
    """Return the model of the laboratory: every joint glued."""
    return on_feet("antenna, glued", (GLUED, GLUED, GLUED))


def truth() -> Model:
    """Return what stands on the shaker: foot 2 has a clearance."""
    gap = Gap(stiffness=GLUED - LOOSE, clearance=CLEARANCE)
    return on_feet(
        "antenna, foot 2 loose", (GLUED, LOOSE, GLUED), Element(gap, ("base", "foot 2"))
    )


def write(folder: Path) -> None:
    """Write structure, model, truth and log."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "antenna.yaml").write_text(structure_text(antenna(), "antenna, free"), "utf-8")
    for model, name in ((glued(), "model.yaml"), (truth(), "truth.yaml")):
        write_model(model, folder / name, structures={"antenna": "antenna.yaml"})
    (folder / "testlog.yaml").write_text(LOG, "utf-8")


if __name__ == "__main__":
    write(Path(sys.argv[1] if len(sys.argv) > 1 else "antenna"))
