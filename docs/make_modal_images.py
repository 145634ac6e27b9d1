"""Draw the figures of modal.md: python docs/make_modal_images.py, from the checkout."""

import tempfile
from pathlib import Path

import numpy as np
from benchmarks.modal_signals import draw

from shakerproc.modal.from_log import analyse_log
from shakerproc.report.figures import style
from shakerproc.report.figures.to_png import save
from shakerproc.report.modal.figures import (
    shapes_figure,
    stabilisation_figure,
    synthesis_figure,
)
from shakerproc.testlog import read_testlog

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


if __name__ == "__main__":
    main()
