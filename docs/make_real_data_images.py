"""Draw the pictures of docs/real_data.md from ../shared/data; nothing is copied from there."""

import json
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from scipy import io, signal

mpl.use("Agg")

ROOT = Path(__file__).resolve().parents[1]
DATA, IMAGES = ROOT.parent / "shared" / "data", ROOT / "docs" / "images"


def silverbox() -> None:
    """Draw the force that a linear model lacks over the displacement."""
    content = io.loadmat(DATA / "silverbox" / "SNLS80mV.mat")
    force, moved = (content[name].ravel()[:40_600] for name in ("V1", "V2"))
    rate, mass, damping = 610.35, 5.375e-6, 2.25e-4
    omega = 2.0 * np.pi * np.fft.rfftfreq(moved.size, 1.0 / rate)
    inside = (omega > 2.0 * np.pi) & (omega < 2.0 * np.pi * 240.0)  # harmonics, not the noise
    line_of = np.fft.rfft(moved * signal.windows.tukey(moved.size, 0.02))
    pull = np.fft.rfft(force * signal.windows.tukey(moved.size, 0.02))
    free = inside * (pull + (mass * omega**2 - 1j * damping * omega) * line_of)
    spring = np.fft.irfft(free, moved.size)
    figure, axes = plt.subplots(figsize=(7.0, 4.5), layout="constrained")
    axes.plot(moved[900:-900], spring[900:-900], ".", markersize=1.5, label="measured")
    line = np.linspace(moved.min(), moved.max(), 200)
    axes.plot(line, line, "--", color="0.4", label="linear, 1 V/V")
    axes.plot(line, 0.9906 * line + 3.91 * line**3, label="with cubic stiffness")
    axes.set(xlabel="V2, like a displacement [V]", ylabel="V1 without inertia and damping [V]")
    axes.legend()
    figure.savefig(IMAGES / "real_silverbox.png", dpi=100)


def play_and_slider(
    moved: np.ndarray, stiffness: float, play: float, limit: float
) -> np.ndarray:
    """Return the force of a slider that is dragged through a play [kN], for way in mm."""
    slider, force = moved[0], np.zeros(moved.size)
    for i, way in enumerate(moved):
        stretch = way - slider
        pull = stiffness * np.sign(stretch) * max(abs(stretch) - play, 0.0)
        if abs(pull) > limit:
            slider += np.sign(pull) * (abs(pull) - limit) / stiffness
            pull = np.sign(pull) * limit
        force[i] = pull
    return force


def damper() -> None:
    """Draw measured loops of the friction damper, and those of the numbers diagnosed."""
    cases = {  # contact [kN/mm], clearance [mm], sliding force [kN], spring, damper beside
        "1Hz20lbtension": (4.87, 1.561, 4.161, 0.0, 0.0),
        "1Hz80lbtension": (5.97, 1.733, 11.13, 0.0209, 4.66e-3),
    }
    figure, both = plt.subplots(1, 2, figsize=(10.5, 4.5), layout="constrained")
    for axes, (name, (contact, play, limit, spring, damping)) in zip(
        both, cases.items(), strict=True
    ):
        path = DATA / "friction_backlash_arts" / f"ds1_{name}.json"
        rows = np.array(json.loads(path.read_text(encoding="utf-8"))["data"], dtype=float)
        moved, force = 25.4 * rows[:, 1], 4.448222 * rows[:, 2]
        fast = signal.savgol_filter(moved, 41, 2, deriv=1, delta=1.0 / 1024.0)
        fitted = play_and_slider(moved, contact, play, limit)
        fitted += spring * moved + damping * fast
        fitted += np.mean(force - fitted)
        axes.plot(moved, force, linewidth=0.5, label="measured")
        axes.plot(moved, fitted, linewidth=0.9, label="play and friction in series")
        axes.set(xlabel="displacement [mm]", ylabel="force [kN]", title=name)
    lines = both[0].get_lines()
    figure.legend(handles=lines, loc="outside lower center", ncols=2)
    figure.savefig(IMAGES / "real_friction_damper.png", dpi=100)


def table() -> None:
    """Draw the phase between the two sensors of the small table."""
    figure, axes = plt.subplots(figsize=(7.0, 4.5), layout="constrained")
    for run in ("El Centro", "Northridge"):
        both = []
        for floor in ("Ground", "Top"):
            (path,) = (DATA / "mini_shaketable_brace2").glob(f"*{floor}Floor*{run}*")
            lines = path.read_text(encoding="utf-8").splitlines()
            head = next(i for i, line in enumerate(lines) if line.startswith("PacketCounter"))
            rows = np.array([line.split(",") for line in lines[head + 2 :]], dtype=float)
            both.append((rows[:, 5] - rows[:, 5].mean(), 1e-6 * rows[0, 1]))
        (ground, first), (top, second) = both
        n = min(ground.size, top.size)
        frequency, cross = signal.csd(ground[:n], top[:n], 120.0, nperseg=512)
        late = -2.0 * np.pi * frequency * (second - first)
        inside = (frequency > 0.5) & (frequency < 16.0)
        phase = np.degrees(np.unwrap(np.angle(cross[inside])) + late[inside])
        axes.plot(frequency[inside], phase, ".-", label=run)
    line = np.array([0.0, 16.0])
    axes.plot(line, -360.0 * 0.0195 * line, "--", color="0.4", label="a delay of 19.5 ms")
    axes.set(xlabel="frequency [Hz]", ylabel="phase, top against ground [°]")
    axes.legend()
    figure.savefig(IMAGES / "real_shaking_table.png", dpi=100)


if __name__ == "__main__":
    silverbox()
    damper()
    table()
