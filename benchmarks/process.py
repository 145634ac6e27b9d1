"""How long a 6-minute recording of 5 channels takes to process, and --help to show."""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numba
import numpy as np

from shakerproc.data import STANDARD_GRAVITY, Channel, recording_of_arrays
from shakerproc.recordings import write_tdms
from shakerproc.runs import open_path, process_recording
from shakerproc.testlog import Test

RATE = 5688.9
SECONDS = 360.0
NAMES = ("control 1", "control 2", "response 1", "response 2", "response 3")


def write_long_recording(path: Path) -> None:
    """Write random base motion from 5 to 1000 Hz and three oscillators on it."""
    rng = np.random.default_rng(1)
    n = int(SECONDS * RATE)
    frequency = np.fft.rfftfreq(n, 1.0 / RATE)
    spectrum = np.fft.rfft(rng.standard_normal(n))
    spectrum[(frequency < 5.0) | (frequency > 1000.0)] = 0.0
    rows = [np.fft.irfft(spectrum, n)] * 2
    for resonance, damping in ((315.0, 0.02), (366.0, 0.01), (410.0, 0.03)):
        r = frequency / resonance
        gain = (1 + 2j * damping * r) / (1 - r**2 + 2j * damping * r)
        rows.append(np.fft.irfft(spectrum * gain, n))
    samples = np.array(rows) + 1e-3 * rng.standard_normal((5, n))
    channels = [Channel(name, "m/s^2", name, "g") for name in NAMES]
    write_tdms(path, recording_of_arrays("long", channels, samples * STANDARD_GRAVITY, RATE))


def write_rattling_recording(path: Path) -> None:
    """Write such a motion, louder, and three coupons with play on it: no linear modes."""
    rng = np.random.default_rng(3)
    n = int(SECONDS * RATE)
    frequency = np.fft.rfftfreq(n, 1.0 / RATE)
    spectrum = np.fft.rfft(rng.standard_normal(n))
    spectrum[(frequency < 5.0) | (frequency > 1000.0)] = 0.0
    base = np.fft.irfft(spectrum, n)
    base *= 4.5 * STANDARD_GRAVITY / base.std()
    clearances = np.array([5e-5, 1e-4, 2e-5])
    samples = np.array([base, base, *_coupons_with_play(base, clearances)])
    samples += 1e-3 * STANDARD_GRAVITY * rng.standard_normal(samples.shape)
    channels = [Channel(name, "m/s^2", name, "g") for name in NAMES]
    write_tdms(path, recording_of_arrays("rattle", channels, samples, RATE))


@numba.njit
def _coupons_with_play(base: np.ndarray, clearances: np.ndarray) -> np.ndarray:
    """Return accelerations [m/s^2] by symplectic Euler, 8 steps a sample, 367 Hz, 2 %."""
    omega, step = 2.0 * np.pi * 367.0, 1.0 / RATE / 8
    found = np.zeros((clearances.size, base.size))
    for row, clearance in enumerate(clearances):
        z, v = 0.0, 0.0
        for i in range(base.size - 1):
            for k in range(8):
                moved = base[i] + (base[i + 1] - base[i]) * k / 8
                force = np.sign(z) * max(abs(z) - clearance, 0.0)
                found[row, i] = -0.04 * omega * v - omega**2 * force
                v += step * (found[row, i] - moved)
                z += step * v
    return found


def main() -> None:
    """Print the table."""
    test = Test("long", excitation="random", from_hz=5.0, to_hz=1000.0)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "long.tdms"
        write_long_recording(path)
        times = []
        for _ in range(4):
            start, cpu = time.perf_counter(), time.process_time()
            with open_path(path, test) as recording:
                process_recording(recording, test)
            times.append((time.perf_counter() - start, time.process_time() - cpu))
    print(f"first (kernels compiled or loaded)  {times[0][0]:6.2f} s")
    warm = min(times[1:])
    print(
        f"warm, best of three                 {warm[0]:6.2f} s ({warm[1]:.2f} s of processor)"
    )
    helps = []
    for _ in range(3):
        start = time.perf_counter()
        subprocess.run(
            [sys.executable, "-m", "shakerproc", "--help"],
            stdout=subprocess.DEVNULL,
            check=True,
        )
        helps.append(time.perf_counter() - start)
    print(f"shakerproc --help, best of three    {min(helps):6.2f} s")


if __name__ == "__main__":
    main()
