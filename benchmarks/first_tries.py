"""What is said of first tries of a laboratory: held pendulum, slow column, bracket on a shaker.

``python -m benchmarks.first_tries [NAME...]``

The recordings are integrated here, by fixed steps of Runge and Kutta; no code of the program
takes part. Each prints what is hidden, and what `diagnose` says.
"""

import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numba import njit
from scipy import signal

from shakerproc.diagnosis import diagnose
from shakerproc.model_files import read_model
from shakerproc.testlog import read_testlog

LOG = """testlog: 1
title: {title}
recordings: .
channels:
{channels}
processing: {{crop: none}}
tests:
{tests}
"""
MODEL = """model: 1
title: {title}
masses: {{{mass}: {kg} kg}}
elements:
  - {{kind: spring, between: [base, {mass}], stiffness: {stiffness} N/m}}
  - {{kind: damper, between: [base, {mass}], damping: {damping} N s/m}}
excitation: {{{excitation}}}
sensors: {{{sensor}: {{at: {mass}, measures: {measures}}}}}
"""
GRAVITY, LENGTH, BOB = 9.81, 0.62, 1.3  # m/s^2, m, kg
BRACKET, NATURAL, RATIO = 1.6, 210.0, 0.012  # kg, Hz, share of critical damping
STIFFNESS = BRACKET * (2.0 * np.pi * NATURAL) ** 2
DAMPING = 2.0 * RATIO * np.sqrt(STIFFNESS * BRACKET)
MODES = ((730.0, 0.01, 0.25), (1500.0, 0.01, -0.15))  # Hz, damping ratio, participation
CLEARANCE, CONTACT, SLIDING = 2e-5, 0.8, 6.0  # m, share of the stiffness, N


def write(folder: Path, model: dict, channels: str, tests: list[tuple[np.ndarray, str]]):
    """Write model, log and recordings; the columns are named as the channels."""
    names = [line.split(":")[0].strip() for line in channels.splitlines()]
    lines = []
    for number, (table, said) in enumerate(tests, 1):
        np.savetxt(
            folder / f"{number}.csv", table, delimiter=",", comments="", fmt="%.9g",
            header=",".join(["time [s]", *names]),
        )  # fmt: skip
        held_out = ", hold_out: true" if len(tests) > 1 and number == 2 else ""
        lines.append(f"  - {{id: {number}, recording: {number}.csv, {said}{held_out}}}")
    (folder / "model.yaml").write_text(MODEL.format(title=folder.name, **model))
    (folder / "log.yaml").write_text(
        LOG.format(title=folder.name, channels=channels, tests="\n".join(lines))
    )


@njit
def swing(angle: float, n: int, step: float, omega: float, friction: float):
    """Return the angle of a pendulum with drag and dry friction, (n,) array [rad]."""
    y, found = np.array([angle, 0.0]), np.empty(n)
    for i in range(n):
        found[i] = y[0]
        total, k = np.zeros(2), np.zeros(2)
        for s, (share, weight) in enumerate(((0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0))):
            z = y + share * step * k if s else y
            turning = omega**2 * (np.sin(z[0]) + friction * np.tanh(z[1] / 1e-3))
            k = np.array([z[1], -turning - 0.003 * omega * z[1]])
            total += weight * k
        y = y + step / 6.0 * total
    return found


def pendulum(folder: Path) -> str:
    """Write the decays of a pendulum that is held for 0.8 s and let go, by an encoder."""
    omega, quantum, rng = np.sqrt(GRAVITY / LENGTH), np.deg2rad(0.088), np.random.default_rng(2)
    tests = []
    for degrees in (20.0, 50.0, 75.0):
        angle = swing(np.deg2rad(degrees), 40_000, 1e-3, omega, 0.004)[::10]
        angle = np.concatenate([np.full(80, angle[0]), angle])
        angle = quantum * np.round(angle / quantum + 0.02 * rng.standard_normal(angle.size))
        table = np.column_stack([np.arange(angle.size) / 100.0, LENGTH * angle])
        tests.append((table, "excitation: free decay, from: 0.3 Hz, to: 5 Hz"))
    model = {
        "mass": "bob", "kg": BOB, "stiffness": 0.97 * BOB * omega**2,
        "damping": 0.008 * BOB * omega, "excitation": "free: decay", "sensor": "arc",
        "measures": "displacement",
    }  # fmt: skip
    write(folder, model, "  arc: {role: displacement, at: bob, unit: m}", tests)
    return f"softening (sine), Coulomb friction {0.004 * BOB * omega**2 * LENGTH:.4g} N"


def column(folder: Path) -> str:
    """Write one test of a column that is pushed to and fro at 0.05 Hz, and degrades."""
    rng = np.random.default_rng(6)
    turn = np.sin(2.0 * np.pi * np.arange(100) / 100)
    sizes = np.repeat([3e-3, 6e-3, 0.01, 0.015, 0.02, 0.028, 0.036], 2)
    stroke = np.concatenate([size * turn for size in sizes])
    way = np.interp(np.arange(stroke.size * 40) / 40, np.arange(stroke.size), stroke)
    force, energy, found = 0.0, 0.0, []
    for i, step in enumerate(np.diff(way, append=way[-1])):
        if i % 40 == 0:
            found.append(force + 0.04 * 9e6 * way[i])
        side = np.sign(step) * force - 0.12 * 75e3
        pinched = 0.65 * (1.0 - np.exp(-energy / 6e3)) * np.exp(-((side / 26.25e3) ** 2))
        yields = (0.55 + 0.45 * np.sign(step * force)) * abs(force / 75e3) ** 1.2
        softer = (1.0 - (1.0 + energy / 2e4) * yields) / (1.0 + energy / 2.2e4)
        force += 9e6 * step * softer * (1.0 - pinched)
        energy += force * step
    noise = rng.standard_normal((2, stroke.size)) * np.array([[1e-5], [400.0]])
    rows = np.array([stroke, found]) + noise
    model = {
        "mass": "top", "kg": 1, "stiffness": 5e6, "damping": 1e4,
        "excitation": "displacement of: top", "sensor": "force", "measures": "force",
    }  # fmt: skip
    channels = (
        "  stroke: {role: displacement, at: top, unit: m}\n"
        "  force: {role: force, at: top, unit: N}"
    )
    table = np.column_stack([np.arange(stroke.size) / 5.0, *rows])
    write(folder, model, channels, [(table, "excitation: sine, frequency: 0.05 Hz")])
    return "degrading, pinched hysteresis, which the library lacks"


@njit
def shaken(base: np.ndarray, step: float, stiffness: float, kind: int):
    """Return the absolute acceleration of a bracket on a base [m/s^2], (n,) array."""
    y, found = np.zeros(2), np.zeros(base.size)
    for i in range(base.size - 1):
        total, k = np.zeros(2), np.zeros(2)
        for s, (share, weight) in enumerate(((0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0))):
            z = y + share * step * k if s else y
            force = stiffness * z[0] + DAMPING * z[1]
            if kind == 1:
                beyond = max(abs(z[0]) - CLEARANCE, 0.0)
                force += CONTACT * stiffness * beyond * np.sign(z[0])
            elif kind == 2:
                force += SLIDING * np.tanh(z[1] / 2e-4)
            if s == 0:
                found[i] = -force / BRACKET
            drive = base[i] + share * (base[i + 1] - base[i])
            k = np.array([z[1], -force / BRACKET - drive])
            total += weight * k
        y = y + step / 6.0 * total
    return found


def bracket(folder: Path, kind: int) -> str:
    """Write three levels of random vibration of a bracket with two modes more."""
    rate, tests, rng = 5120.0, [], np.random.default_rng(20)
    sections = signal.butter(4, (20.0, 1000.0), "band", fs=rate, output="sos")
    for level in (10.0, 25.0, 50.0):
        wave = signal.sosfilt(sections, rng.standard_normal(81_920))
        wave *= level / wave.std() * np.minimum(1.0, np.arange(wave.size) / 2560.0)
        base = np.concatenate([np.zeros(3072), wave, np.zeros(3072)])
        whole = np.concatenate([base, np.zeros(base.size)])
        fine = signal.resample(whole, 8 * whole.size)[: 8 * base.size]
        rows = shaken(fine, 1.0 / (8.0 * rate), STIFFNESS, kind)[::8]
        s = 2j * np.pi * np.fft.rfftfreq(whole.size, 1.0 / rate)
        for frequency, ratio, share in MODES:
            omega = 2.0 * np.pi * frequency
            answer = -share * s**2 / (s**2 + 2.0 * ratio * omega * s + omega**2)
            rows = rows + np.fft.irfft(answer * np.fft.rfft(whole), whole.size)[: rows.size]
        noise = level * rng.standard_normal((2, rows.size)) * np.array([[0.003], [0.004]])
        table = np.column_stack([np.arange(rows.size) / rate, base + noise[0], rows + noise[1]])
        said = f"excitation: random, level: {level:g} m/s^2 rms, from: 20 Hz, to: 1000 Hz"
        tests.append((table, said))
    model = {
        "mass": "bracket", "kg": BRACKET, "stiffness": 1.35 * STIFFNESS,
        "damping": 0.7 * DAMPING, "excitation": "base: acceleration", "sensor": "top",
        "measures": "acceleration",
    }  # fmt: skip
    channels = (
        "  table: {role: control, unit: m/s^2}\n"
        "  top: {role: response, at: bracket, unit: m/s^2}"
    )
    write(folder, model, channels, tests)
    law = (
        "nothing", f"gap of {CLEARANCE:g} m, {CONTACT * STIFFNESS:.4g} N/m",
        f"Coulomb friction of {SLIDING:g} N",
    )[kind]  # fmt: skip
    return f"{law}; stiffness {STIFFNESS:.4g} N/m; modes at 730 and 1500 Hz"


RECORDINGS: dict[str, Callable[[Path], str]] = {
    "pendulum": pendulum,
    "column": column,
    "bracket": lambda folder: bracket(folder, 0),
    "bracket_gap": lambda folder: bracket(folder, 1),
    "bracket_friction": lambda folder: bracket(folder, 2),
}


def main(names: list[str]) -> None:
    """Print what each recording hides, and what is said of it."""
    with tempfile.TemporaryDirectory() as made:
        for name in names or RECORDINGS:
            folder = Path(made) / name
            folder.mkdir()
            hidden = RECORDINGS[name](folder)
            start = time.process_time()
            found = diagnose(
                read_model(folder / "model.yaml"), read_testlog(folder / "log.yaml")
            )
            print(f"{name}: hidden: {hidden}")
            print(f"  {found.sentence} ({time.process_time() - start:.0f} s of processor)")
            for effect in found.effects:
                numbers = {key: one.value for key, one in effect.parameters.items()}
                print(f"  {effect.kind}: {numbers}")
            for note in found.notes:
                print(f"  note: {note}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
