"""Recordings of others, as this program reads them.

python -m configs.benchmarks.convert SET FOLDER

Each set of this folder is a model and a test log. Its recordings were measured and published by
others and are no part of the project: they are read from ../shared/data (SOURCES.md there says
where they come from) and written into FOLDER, beside copies of model and log.
"""

import argparse
import json
import shutil
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

import h5py
import numpy as np
from scipy.io import loadmat
from scipy.signal import butter, resample_poly, sosfilt

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SHARED = ROOT.parent / "shared" / "data"

INCH, KIP, G = 0.0254, 4448.2216, 9.80665
"""An inch [m], a thousand pounds of force [N], standard gravity [m/s²]."""


def folder_of(name: str, place: Path, source: Path = SHARED) -> Path:
    """Return the folder into which a set was written: model.yaml, testlog.yaml, recordings.

    Raises
    ------
    FileNotFoundError
        If the recordings of the set are not there.
    """
    target = place / name
    (target / "recordings").mkdir(parents=True, exist_ok=True)
    for path in sorted((HERE / name).glob("*.yaml")):
        shutil.copy(path, target)
    SETS[name](source, target / "recordings")
    return target


def save(path: Path, rate: float | np.ndarray, **channels: np.ndarray) -> None:
    """Write channels and their sample rate [Hz] as NumPy arrays by name."""
    columns = {name: np.ascontiguousarray(np.ravel(x), float) for name, x in channels.items()}
    np.savez(path, fs=np.ravel(rate)[:1].astype(float), **columns)


def copied(pattern: str) -> Callable[[Path, Path], None]:
    """Return a converter of recordings that are read as they are."""

    def copy(source: Path, target: Path) -> None:
        found = sorted(source.glob(pattern))
        if not found:
            raise FileNotFoundError(f"{source / pattern} is absent")
        for path in found:
            shutil.copy(path, target / path.name.replace(" ", "_"))

    return copy


def bouc_wen(source: Path, target: Path) -> None:
    """Five periods of the multisine to learn from; the published tests."""
    for file, name, out in (
        ("train", "multisine", "train"),
        ("test", "multisine", "multisine"),
        ("test", "sinesweep", "sweep"),
    ):
        with h5py.File(source / "boucwen_benchmark" / f"{file}.h5") as archive:
            group = archive[name]
            rate, force, moved = (group[key][()] for key in ("fs", "u", "y"))
        save(target / f"{out}.npz", rate, force=force, displacement=moved)


def emps(source: Path, target: Path) -> None:
    """Force of the drive (its gain times its voltage) and position."""
    for file, out in (("DATA_EMPS", "train"), ("DATA_EMPS_PULSES", "pulses")):
        content = loadmat(source / "emps" / f"{file}.mat")
        force = content["gtau"] * content["vir"]
        save(target / f"{out}.npz", 1000.0, force=force, position=content["qm"])


def mr_damper(source: Path, target: Path) -> None:
    """Stroke from mm to m; the force as it is. Runs 2 to 5 from 50 samples a second to 100."""
    for i in range(1, 6):
        content = loadmat(source / "mr_damper_labcontrol" / f"ensaio{i}.mat")
        finer = round(float(content["Ts"][0, 0]) / 0.01)
        stroke, force = (
            resample_poly(content[name][:, 0], finer, 1, padtype="line")
            for name in ("dist", "forc")
        )
        save(target / f"run{i}.npz", 100.0, stroke=1e-3 * stroke, force=force)


def friction_damper(source: Path, target: Path) -> None:
    """Stroke and force from inches and thousands of pounds."""
    for name in ("0.5Hz70lb", "1Hz20lb", "1Hz70lb", "1Hz80lb"):
        text = (source / "friction_backlash_arts" / f"ds1_{name}tension.json").read_text()
        rows = np.array(json.loads(text)["data"], dtype=float)
        save(
            target / f"{name}.npz", 1024.0, stroke=INCH * rows[:, 1], force=KIP * rows[:, 2]
        )  # fmt: skip


def shaking_table(source: Path, target: Path) -> None:
    """Ground and top on one clock, from sensors that each have their own."""
    for run in ("El Centro", "Northridge"):
        below, above = (
            next((source / "mini_shaketable_brace2").glob(f"*{place}*{run}*"))
            for place in ("GroundFloor", "TopFloor")
        )
        (ground, first), (top, second) = loose_sensor(below), loose_sensor(above)
        n = min(ground.size, top.size)
        top = later(top[:n], 120.0 * (second - first))
        save(target / f"{run.replace(' ', '_')}.npz", 120.0, ground=ground[:n], top=top)


def loose_sensor(path: Path) -> tuple[np.ndarray, float]:
    """Return accelerations along the table [m/s²] and the time of the first sample [s]."""
    lines = path.read_text(encoding="utf-8").splitlines()
    head = next(i for i, line in enumerate(lines) if line.startswith("PacketCounter"))
    rows = np.array([line.split(",") for line in lines[head + 1 :]], dtype=float)
    return rows[1:, 5], 1e-6 * rows[1, 1]


def later(samples: np.ndarray, shift: float) -> np.ndarray:
    """Return samples as a clock that started `shift` samples earlier has them."""
    n = samples.size
    bridge = np.linspace(samples[-1], samples[0], 3 * n)
    turn = np.exp(-2j * np.pi * np.fft.rfftfreq(4 * n) * shift)
    return np.fft.irfft(np.fft.rfft(np.concatenate([samples, bridge])) * turn, 4 * n)[:n]


def three_masses(_: Path, target: Path) -> None:
    """Write a campaign of the truth generator: a gap between the second mass and the third."""
    from blind.campaigns import draw

    from blind import folder

    folder.write(draw(0, "chain3:gap"), target.parent)


def base_isolation(source: Path, target: Path) -> None:
    """Accelerations of the ground and of six floors [m/s²]."""
    names = {"ground": "u"} | {f"floor{i}": f"a{i}" for i in range(1, 7)}
    rows = {
        name: np.loadtxt(source / "base_isolation_cnp100" / f"{file}.txt").ravel()
        for name, file in names.items()
    }
    save(target / "quake.npz", 200.0, **rows)


def f16(source: Path, target: Path) -> None:
    """Force and three accelerations, nine periods of one multisine."""
    file = source / "f16_level1" / "F16Data_FullMSine_Level1.csv"
    rows = np.genfromtxt(file, delimiter=",", skip_header=1, usecols=(0, 2, 3, 4)).T
    names = ("force", "point", "wing", "payload")
    save(target / "level1.npz", 400.0, **dict(zip(names, rows, strict=True)))


def ringdown(source: Path, target: Path) -> None:
    """Force and acceleration after a hammer blow, up to its first mode alone.

    One sample in 80 of 51.2 kHz leaves the mode at 151 Hz; those at 557 Hz and above go. Both
    channels pass one filter that looks back only: nothing moves before the blow. The
    accelerometer looks against the hammer, hence the sign.
    """
    content = loadmat(source / "ringdown_lms" / "Sample_LMS_Data.mat")
    low_pass = butter(8, 280.0, fs=51200.0, output="sos")
    force, moved = (sosfilt(low_pass, content[name][:, 0])[::80] for name in ("f", "x"))
    save(target / "blow.npz", 640.0, force=force, acceleration=-moved)


def coupon(_: Path, target: Path) -> None:
    """Take the simulated campaign of sample_data."""
    for number in (3, 4, 5, 12, 15):
        own = f"Test_{number}"
        shutil.copytree(ROOT / "sample_data" / "recordings" / own, target / own)


def pcb_shaker(source: Path, target: Path) -> None:
    """Accelerations of base and board, at the rate that their time column bears out."""
    for amplitude, vibration in ((1, "0.5"), (5, "0.5"), (5, "1")):
        name = f"amplitude_{amplitude}_Impact_0.0_vibration_{vibration}.lvm"
        lines = (source / "shaker_pcb_lvm_dataset7" / name).read_text().splitlines()
        start = next(i for i, line in enumerate(lines) if line.startswith("X_Value")) + 1
        cells = (line.split(",") for line in lines[start:])
        rows = np.array([c[4:7] for c in cells if all(c[4:7])], dtype=float)
        np.savez(
            target / f"amplitude{amplitude}_vibration{vibration}.npz",
            fs=np.array([1.0 / 0.000586]),
            base=rows[:, 1], board=rows[:, 2],
        )  # fmt: skip


SETS: Mapping[str, Callable[[Path, Path], None]] = MappingProxyType({
    "silverbox": copied("silverbox/SNLS80mV.mat"),
    "bouc_wen": bouc_wen,
    "emps": emps,
    "mr_damper": mr_damper,
    "friction_damper": friction_damper,
    "shaking_table": shaking_table,
    "three_masses": three_masses,
    "coupon": coupon,
    "base_isolation": base_isolation,
    "ringdown": ringdown,
    "f16": f16,
    "pcb_shaker": pcb_shaker,
})
"""Every set, and what writes its recordings from the folder of shared data into another."""


def main() -> None:
    """Write one set into a folder."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("set", choices=list(SETS))
    parser.add_argument("folder", type=Path)
    given = parser.parse_args()
    sys.stdout.write(f"{folder_of(given.set, given.folder)}\n")


if __name__ == "__main__":
    main()
