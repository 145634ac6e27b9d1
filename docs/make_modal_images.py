"""Draw the figures of modal.md: python docs/make_modal_images.py, from the checkout."""

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from benchmarks.modal_signals import draw

import shakerproc
from shakerproc.geometry import Wireframe
from shakerproc.geometry.data_sets import geometry, header
from shakerproc.modal.from_measurements import analyse_log
from shakerproc.recordings.writers import (
    FREQUENCY,
    End,
    RecordAxis,
    RecordHead,
    write_function,
)
from shakerproc.report.figures import style
from shakerproc.report.figures.to_png import save
from shakerproc.report.modal.figures import (
    shapes_figure,
    stabilisation_figure,
    synthesis_figure,
)
from shakerproc.testlog import read_testlog

if TYPE_CHECKING:
    from matplotlib.figure import Figure

IMAGES = Path(__file__).with_name("images")
SENSORS = "".join(
    f"  a{i}: {{role: response, position: [{100 * i} mm, 0 mm, 0 mm], direction: z}}\n"
    for i in range(1, 9)
)
LOG = f"""\
testlog: 1
title: Beam, simulated
channels:
  force: {{role: force}}
{SENSORS}processing: {{crop: none}}
modal: {{band: {{from: 3 Hz, to: 205 Hz}}}}
tests:
  - {{id: 1, recording: 1.csv, excitation: random, level: 1 N rms, from: 3 Hz, to: 215 Hz}}
"""


def main() -> None:
    """Simulate, analyse, draw."""
    structure = draw(np.random.default_rng(11), 6, noise_db=40.0)
    time = np.arange(structure.response.shape[1]) / structure.sample_rate
    names = ["time [s]", "force [N]", *(f"a{i} [m/s^2]" for i in range(1, 9))]
    rows = np.column_stack([time, structure.force[0], structure.response.T])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "recordings").mkdir()
        np.savetxt(
            folder / "recordings" / "1.csv", rows, delimiter=",",
            header=",".join(names), comments="", fmt="%.9g",
        )  # fmt: skip
        (folder / "log.yaml").write_text(LOG)
        log = read_testlog(folder / "log.yaml")
        one = analyse_log(log, log.active, log.modal).tests[0]
    with style.look():
        for kind, drawn in (
            ("stabilisation", stabilisation_figure(one)),
            ("synthesis", synthesis_figure(one)),
            ("shapes", shapes_figure(one)),
        ):
            if drawn is not None:
                save(drawn, IMAGES / f"modal_{kind}.png")
        save(plate_figure(), IMAGES / "modal_geometry.png")


def plate_figure() -> "Figure":
    """Return three modes of a plate on a frame, from response functions in closed form."""
    across, deep = np.meshgrid(np.linspace(0, 0.6, 5), np.linspace(0, 0.4, 4), indexing="ij")
    grid = np.arange(1, 21).reshape(5, 4)
    places = zip(across.ravel(), deep.ravel(), strict=True)
    nodes = {i: (float(x), float(y), 0.0) for i, (x, y) in enumerate(places, 1)}
    corners = [int(grid[i, j]) for i, j in ((0, 0), (4, 0), (4, 3), (0, 3))]
    feet = {101 + i: (*nodes[corner][:2], -0.15) for i, corner in enumerate(corners)}
    quads = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=-1)
    wireframe = Wireframe(
        nodes | feet,
        ((101, 102, 103, 104, 101), *zip(feet, corners, strict=True)),
        tuple(tuple(int(v) for v in quad) for quad in quads.reshape(-1, 4)),
    )
    x, y = across.ravel() / 0.3 - 1.0, deep.ravel() / 0.2 - 1.0
    shapes = np.stack([x * y, 1.5 * x**2 - 0.5, 1.5 * y**2 - 0.5])
    own, damping = 2 * np.pi * np.array([62.0, 88.0, 131.0]), np.array([0.01, 0.008, 0.012])
    lines = np.arange(20.0, 200.0, 0.25)
    omega = 2 * np.pi * lines
    below = own[:, None] ** 2 - omega**2 + 2j * (damping * own)[:, None] * omega
    values = np.einsum("mr,mf->rf", shapes * shapes[:, :1], -(omega**2) / below)
    noise = np.random.default_rng(1).standard_normal((2, *values.shape))
    values += 0.002 * (noise[0] + 1j * noise[1])
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "plate.uff"
        with path.open("wb") as file:
            file.write((header("Plate", "closed form", "docs") + geometry(wireframe)).encode())
            for node, one in enumerate(values, 1):
                ends = (End(node=node, direction=3), End(node=1, direction=3))
                axes = (FREQUENCY, RecordAxis(12, "NONE", "m/s^2"), RecordAxis(13, "NONE", "N"))
                write_function(
                    file, RecordHead(4, (), *ends, 20.0, 0.25, *axes), one, binary=False
                )
        return shakerproc.modes(path).plot("test_plate_shapes")


if __name__ == "__main__":
    main()
