"""An antenna on three feet, one with a hidden clearance: finite elements, model, truth, log.

``python make_antenna.py FOLDER`` writes eight files. ``plate.unv`` holds the modes of the plate
at all nodes of the built-in finite elements, free, with its rigid-body modes; ``antenna.yaml``
is what ``shakerproc convert`` makes of it at the sensors of the log and at the feet. Glued to
three alike feet it resonates at 62 Hz; while the clearance of foot 2 is open, at 56 Hz.
``coil.yaml`` is the glued antenna with a damper at its tip that a coil sets, and
``voltages.yaml`` its log, each test at a voltage of its own; ``coil-truth.yaml`` rubs besides.
"""

import sys
from pathlib import Path

import numpy as np

from shakerproc.exchange.modes import ModeTable, write_mode_file
from shakerproc.finite_elements.rectangular_plate import Plate, free_plate_modes
from shakerproc.model_files import write_model
from shakerproc.models import Element, Excitation, Model, Scale, Sensor
from shakerproc.models.effects import CoulombFriction, Damper, Gap, Spring
from shakerproc.models.structure import Structure, StructureMode
from shakerproc.workflows.mode_sets import ModeOptions, convert_modes

PLATE = Plate(0.5, 0.3, 5e-3, youngs_modulus=70e9, poissons_ratio=0.33, density=2700.0)
POINTS = {  # m
    "foot 1": (0.03, 0.15),
    "foot 2": (0.33, 0.03),
    "foot 3": (0.33, 0.27),
    "corner": (0.47, 0.04),
    "tip": (0.50, 0.15),
}
MODES, DAMPING_RATIO, PITCH = 9, 0.005, 10  # [-], [-], mm
GLUED = 5.79e5  # stiffness of a foot [N/m]
LOOSE = 1.42e5  # that of foot 2 while its clearance is open [N/m]
CLEARANCE = 2e-5  # m
RUBS = 1.0  # dry friction of the coil at 2 V [N]
SENSORS = ("tip", "corner", "foot 1")  # none on the feet 2 and 3

HEAD = """\
testlog: 1
title: antenna on three feet
processing: {crop: none}
channels:
  control: {role: control}
  tip: {role: response, position: [498 mm, 151 mm, 0 mm], direction: z}
  corner: {role: response, position: [470 mm, 41 mm, 0 mm], direction: z}
  foot 1: {role: response, position: [30 mm, 150 mm, 0 mm], direction: z}
tests:
"""
LOG = """\
  - {id: 1, recording: low.tdms, excitation: random, level: 0.00002 g^2/Hz,
     from: 20 Hz, to: 300 Hz}
  - {id: 2, recording: high.tdms, excitation: random, level: 0.001 g^2/Hz,
     from: 20 Hz, to: 300 Hz}
  - {id: 3, recording: kept.tdms, excitation: random, level: 0.0005 g^2/Hz,
     from: 20 Hz, to: 300 Hz, hold_out: true}
"""
VOLTAGES = """\
  - {id: 1, recording: off.tdms, excitation: random, level: 0.0005 g^2/Hz,
     from: 20 Hz, to: 300 Hz, conditions: {voltage: 0 V}}
  - {id: 2, recording: half.tdms, excitation: random, level: 0.0005 g^2/Hz,
     from: 20 Hz, to: 300 Hz, conditions: {voltage: 2 V}}
  - {id: 3, recording: full.tdms, excitation: random, level: 0.0005 g^2/Hz,
     from: 20 Hz, to: 300 Hz, conditions: {voltage: 4 V}}
  - {id: 4, recording: kept.tdms, excitation: random, level: 0.001 g^2/Hz,
     from: 20 Hz, to: 300 Hz, conditions: {voltage: 3 V}, hold_out: true}
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


def nodes() -> dict[int, tuple[float, float]]:
    """Return where the nodes of the plate are, every 10 mm [m]."""
    along, across = (round(1e3 * size / PITCH) + 1 for size in (PLATE.length, PLATE.width))
    return {
        1 + i + along * j: (1e-3 * PITCH * i, 1e-3 * PITCH * j)
        for j in range(across)
        for i in range(along)
    }


def node_at(point: str) -> int:
    """Return the node at a point of the antenna."""
    return min(nodes(), key=lambda node: np.hypot(*np.subtract(nodes()[node], POINTS[point])))


def finite_elements() -> ModeTable:
    """Return the modes at all nodes, as a program of finite elements writes them."""
    frequencies, shapes = free_plate_modes(PLATE, list(nodes().values()), MODES)
    places = {f"{node}/z": (x, y, 0.0) for node, (x, y) in nodes().items()}
    ratios = np.where(frequencies > 0.0, DAMPING_RATIO, 0.0)
    return ModeTable(
        tuple(places), frequencies, shapes, ratios, positions=places, units="SI"
    )  # fmt: skip


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


def with_coil(title: str, *laws: Damper | CoulombFriction) -> Model:
    """Return the glued antenna with laws at its tip, in proportion to the voltage of a coil."""
    at_2_volts = Scale("voltage", "2 V")
    tip = [Element(law, ("base", "tip"), at_2_volts) for law in laws]
    return on_feet(title, (GLUED, GLUED, GLUED), *tip)


def write(folder: Path) -> None:
    """Write finite elements, structure, model, truth and log."""
    folder.mkdir(parents=True, exist_ok=True)
    log, plate = folder / "testlog.yaml", folder / "plate.unv"
    log.write_text(HEAD + LOG, "utf-8")
    (folder / "voltages.yaml").write_text(HEAD + VOLTAGES, "utf-8")
    write_mode_file(plate, finite_elements(), "plate")
    feet = [f"{foot}={node_at(foot)} z" for foot in ("foot 2", "foot 3")]
    convert_modes(plate, folder / "antenna.yaml", ModeOptions(at=feet, sensors=log))
    coil, rubs = Damper(damping=3.0), CoulombFriction(sliding_force=RUBS)
    models = {
        "model.yaml": glued(),
        "truth.yaml": truth(),
        "coil.yaml": with_coil("antenna with a coil", coil),
        "coil-truth.yaml": with_coil("antenna with a coil that rubs", coil, rubs),
    }
    for name, model in models.items():
        write_model(model, folder / name, structures={"antenna": "antenna.yaml"})


if __name__ == "__main__":
    write(Path(sys.argv[1] if len(sys.argv) > 1 else "antenna"))
