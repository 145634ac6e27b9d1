"""``python -m tests.modal.read_by_others``: our universal files, read by other programs.

Writes modes, geometry, response functions (`modal`), samples (`convert`) and spectra
(`process --export uff`) of a plate, and has SDynPy and Gmsh read them. ``--python`` names the
interpreter that has these, as both bring a window system: ``pip install sdynpy gmsh`` in an
environment of its own. What they read is compared with what pyuff reads, and with what was
written; a program that is not there is said.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pyuff
from scipy import signal
from tests.in_process import run
from tests.modal.test_geometry import CORNERS, plate

from shakerproc.data import STANDARD_GRAVITY, Channel, recording_of_arrays
from shakerproc.recordings.writers import write_tdms

RATE = 1000.0
SDYNPY = """
import json, sys
import numpy as np, sdynpy as sd
from sdynpy.fileio.sdynpy_uff import readunv
plain = lambda x: [np.real(x).tolist(), np.imag(x).tolist()]
modes, samples, spectra = (readunv(path) for path in sys.argv[1:])
geometry = sd.Geometry.from_unv(modes)
shapes = sd.ShapeArray.from_unv(modes).flatten()
found = {"sets": sorted(modes)}
found["nodes"] = geometry.node.coordinate.tolist()
found["lines"] = [line.tolist() for line in geometry.traceline.connectivity]
found["surfaces"] = [one.tolist() for one in geometry.element.connectivity]
found["frequency"] = shapes.frequency.tolist()
found["damping"] = shapes.damping.tolist()
found["shapes"] = [plain(one) for one in shapes.shape_matrix]
for name, sets in (("functions", modes), ("samples", samples), ("spectra", spectra)):
    data = sd.data.NDDataArray.from_uff(sets)
    parts = data if isinstance(data, list) else [data]
    every = [one for part in parts for one in part.flatten()]
    found[name] = [
        [np.ravel(one.abscissa).tolist(), plain(np.ravel(one.ordinate))] for one in every
    ]
print("\\n" + json.dumps(found))
"""
GMSH = """
import json, sys
import gmsh
gmsh.initialize(["gmsh", "-nopopup", "-v", "0"])
gmsh.open(sys.argv[1])
numbers, places, _ = gmsh.model.mesh.getNodes()
_, _, nodes = gmsh.model.mesh.getElements(2)
found = {"nodes": places.reshape(-1, 3).tolist(), "surfaces": nodes[0].tolist()}
print("\\n" + json.dumps(found))
"""


def written(folder: Path) -> tuple[Path, Path, Path]:
    """Files of modes, samples and spectra, each by the command that writes it."""
    out = folder / "out"
    assert run("modal", plate(folder / "plate.uff"), "--out", out, "--no-figures") == 0
    noise = np.random.default_rng(3).standard_normal(20_000)
    values = np.array([noise, signal.lfilter(*signal.iirpeak(120.0, 20.0, fs=RATE), noise)])
    channels = [Channel(name, "m/s^2", name, "g") for name in ("control", "response")]
    recording = recording_of_arrays("run", channels, values * STANDARD_GRAVITY, RATE)
    write_tdms(folder / "run.tdms", recording)
    assert run("convert", folder / "run.tdms", folder / "run.uff") == 0
    done = run(
        "process", folder / "run.tdms", "--export", "uff", "--no-figures", "--no-crop",
        "--out", folder / "spectra",
    )  # fmt: skip
    assert done == 0
    (spectra,) = (folder / "spectra").rglob("*.uff")
    return out / "test_plate.uff", folder / "run.uff", spectra


def told(python: str, script: str, *paths: Path) -> dict | str:
    """What another program read, or why it did not."""
    done = subprocess.run(
        [python, "-c", script, *map(str, paths)], capture_output=True, text=True, check=False,
        env={**os.environ, "QT_QPA_PLATFORM": "offscreen", "PYTHONPATH": ""},
    )  # fmt: skip
    if done.returncode:
        return (done.stderr.strip().splitlines() or ["no reason given"])[-1]
    return json.loads(done.stdout.splitlines()[-1])


def functions(path: Path) -> list[tuple[np.ndarray, np.ndarray]]:
    """Abscissa and values of each record 58, by pyuff."""
    sets = pyuff.UFF(str(path)).read_sets()
    return [(one["x"], one["data"]) for one in sets if int(one["type"]) == 58]


def same(found: list, expected: list[tuple[np.ndarray, np.ndarray]]) -> bool:
    """Whether functions are those of pyuff: abscissas to six digits, as printed; values all."""
    return len(found) == len(expected) and all(
        np.allclose(x, one, rtol=1e-5)
        and np.array_equal(np.add(re, np.multiply(1j, im)), value)
        for (x, (re, im)), (one, value) in zip(found, expected, strict=True)
    )


def by_sdynpy(found: dict, paths: tuple[Path, Path, Path]) -> dict[str, bool]:
    """What holds of the numbers of SDynPy."""
    sets = pyuff.UFF(str(paths[0])).read_sets()
    modes = [one for one in sets if int(one["type"]) == 55]
    poles = np.array([one["eig"] for one in modes])
    shapes = np.array([
        np.column_stack([one[f"r{i}"] for i in (1, 2, 3)]).ravel() for one in modes
    ])
    read = [np.add(re, np.multiply(1j, im)) for re, im in found["shapes"]]
    return {
        "nodes": np.allclose(found["nodes"], CORNERS, atol=1e-12),
        "lines": len(found["lines"]) == 3,
        "surface": [list(one) for one in found["surfaces"]] == [[1, 2, 3, 4]],
        "frequency": np.allclose(found["frequency"], np.abs(poles) / (2 * np.pi), rtol=1e-4),
        "damping": np.allclose(found["damping"], -poles.real / np.abs(poles), rtol=1e-3),
        "shapes": all(
            np.isclose(np.abs(np.vdot(one[one != 0], other[other != 0])),
                       np.linalg.norm(one) * np.linalg.norm(other), rtol=1e-9)
            for one, other in zip(read, shapes, strict=True)
        ),
        **{
            name: same(found[name], functions(path))
            for name, path in zip(("functions", "samples", "spectra"), paths, strict=True)
        },
    }  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--python", default=sys.executable)
    options = parser.parse_args()
    bad = 0
    with tempfile.TemporaryDirectory() as name:
        paths = written(Path(name))
        unv = paths[0].with_suffix(".unv")
        unv.write_bytes(paths[0].read_bytes())
        read = told(options.python, SDYNPY, *paths)
        rows = {"SDynPy": read if isinstance(read, str) else by_sdynpy(read, paths)}
        read = told(options.python, GMSH, unv)
        rows["Gmsh"] = read if isinstance(read, str) else {
            "nodes": np.allclose(read["nodes"], CORNERS[:4], atol=1e-12),  # of elements alone
            "surface": read["surfaces"] == [1, 2, 3, 4],
        }  # fmt: skip
    for program, holds in rows.items():
        if isinstance(holds, str):
            sys.stdout.write(f"{program}: {holds}\n")
            bad += "No module" not in holds
            continue
        wrong = [what for what, right in holds.items() if not right]
        bad += len(wrong)
        sys.stdout.write(f"{program}: {', '.join(holds)} read; differ: {wrong or 'none'}\n")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
