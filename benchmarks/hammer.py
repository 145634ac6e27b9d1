"""Hammer tests of a known structure: error and coverage by window, and 200 blows in how long.

Of the resonances of each response function, and of the modes that `shakerproc modal` fits to
all of them, with both sensors and with one.

python -m benchmarks.hammer [DRAWS]
"""

import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from tests.struck import MODES, RATE, struck

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.modal.from_measurements import analyse_test
from shakerproc.runs import process_recording
from shakerproc.testlog import Hammer, Processing, Test, read_testlog
from shakerproc.testlog.excitation import Amount

WINDOWS = {
    "2 s, none": Hammer(length=2.0),
    "2 s, force 10 ms": Hammer(length=2.0, force_window=0.01),
    "1 s, force 10 ms, 1 %": Hammer(
        length=1.0, force_window=0.01, exponential=Amount(0.01, "1")
    ),
    "0.5 s, force 10 ms, 1 %": Hammer(
        length=0.5, force_window=0.01, exponential=Amount(0.01, "1")
    ),
}
NOISE = (0.2, 0.1)
"""Standard deviations on the force [N] and on the accelerations [m/s²]."""


def processed(rows, hammer):
    """Return the run of blows that stand in rows, the force first."""
    names = ("hammer", *(f"a{i}" for i in range(1, len(rows))))
    channels = [
        Channel(name, "m/s^2" if i else "N", name, "g", "response" if i else "force")
        for i, name in enumerate(names)
    ]
    test = Test(
        1, excitation="hammer", from_hz=20.0, to_hz=350.0, processing=Processing(hammer=hammer)
    )
    return process_recording(recording_of_arrays("run", channels, rows, RATE), test)


def resonances(result):
    """Frequency and damping with its interval of every resonance that has them."""
    (one,) = [one for one in result.analyses if one.kind == "resonances"]
    return [row for row in one.summary if row["damping_percent"] is not None]


def scores(hammer, draws):
    """Relative errors of frequency and damping, and whether the interval holds, of draws."""
    found = []
    for seed in range(draws):
        rng = np.random.default_rng(seed)
        blows = [(0.5 + 2.2 * k, 100.0 + 50.0 * rng.random()) for k in range(6)]
        rows = struck(blows, 13.7, noise=NOISE, seed=seed)
        for row in resonances(processed(rows, hammer)):
            for natural, zeta, *_ in MODES:
                if abs(row["natural_frequency_hz"] / natural - 1.0) < 0.02:
                    found.append((
                        row["natural_frequency_hz"] / natural - 1.0,
                        row["damping_percent"] / (100.0 * zeta) - 1.0,
                        row["low_percent"] <= 100.0 * zeta <= row["high_percent"],
                    ))
    return np.array(found, dtype=float)


def modes(folder, hammer, sensors, draws):
    """Modes too many; of all modes, errors of damping and whether intervals hold."""
    channels = "".join(
        f"  a{i + 1}: {{role: {'response' if i < sensors else 'ignore'}, unit: m/s^2}}\n"
        for i in range(2)
    )
    said = ", ".join(f"{key}: {value}" for key, value in hammer.items())
    (folder / "log.yaml").write_text(
        f"testlog: 1\nrecordings: .\nchannels:\n  f: {{role: force, unit: N}}\n{channels}"
        f"processing: {{hammer: {{{said}}}}}\ntests:\n"
        "  - {id: 1, recording: run.npz, excitation: hammer, from: 20 Hz, to: 350 Hz}\n"
    )
    log, extra, found = read_testlog(folder / "log.yaml"), 0, []
    for seed in range(draws):
        rng = np.random.default_rng(seed)
        blows = [(0.5 + 2.0 * k, 100.0 + 50.0 * rng.random()) for k in range(6)]
        rows = struck(blows, 12.5, noise=NOISE, seed=seed)
        np.savez(folder / "run.npz", f=rows[0], a1=rows[1], a2=rows[2], fs=RATE)
        own = analyse_test(log, log.find(1), log.modal).modes
        extra += max(0, own.poles.size - len(MODES))
        for natural, zeta, *_ in MODES:
            i = int(np.argmin(np.abs(own.frequency - natural)))
            low, high = own.frequency_bounds[:, i]
            least, most = own.damping_bounds[:, i]
            off = own.damping[i] / zeta - 1.0
            found.append((off, low <= natural <= high, least <= zeta <= most))
    return extra, np.array(found, dtype=float)


def print_modes(draws):
    """Print what `shakerproc modal` finds."""
    print(f"modes of all response functions, {draws} draws:")
    print(
        "block and windows           sensors  extra  damping off (largest)  frequency, damping"
    )
    for hammer in (
        {"length": "1.9 s"},
        {"length": "1.9 s", "force_window": "10 ms"},
        {"length": "0.8 s", "exponential": "1 %"},
        {"length": "0.5 s", "force_window": "10 ms", "exponential": "1 %"},
    ):
        for sensors in (2, 1):
            with tempfile.TemporaryDirectory() as folder:
                extra, found = modes(Path(folder), hammer, sensors, draws)
            off = np.sqrt(np.mean(found[:, 0] ** 2))
            name = ", ".join(hammer.values())
            print(
                f"{name:28} {sensors:6d} {extra:6d} {off:11.2%} "
                f"({np.abs(found[:, 0]).max():.2%}) {found[:, 1].mean():12.1%} "
                f"{found[:, 2].mean():.1%}"
            )


def main(draws=30):
    """Print the table."""
    print(f"{draws} draws of 6 blows, 2 sensors, 2 modes; of {4 * draws} resonances")
    print(
        "block and windows        found  frequency off  damping off (largest)  interval holds"
    )
    for name, hammer in WINDOWS.items():
        one = scores(hammer, draws)
        off = np.sqrt(np.mean(one[:, :2] ** 2, axis=0))
        print(
            f"{name:24} {len(one):5d} {off[0]:13.4%} {off[1]:12.2%} "
            f"({np.abs(one[:, 1]).max():.2%}) {one[:, 2].mean():14.1%}"
        )
    print_modes(draws)
    rows = struck([(0.5 + 2.0 * k, 120.0) for k in range(200)], 401.0, noise=NOISE)
    many = np.concatenate([rows[:1], *[rows[1:] * gain for gain in (1.0, 0.7, 0.4, 0.2)]])
    begun = time.perf_counter()
    processed(many, Hammer(length=1.0, exponential=Amount(0.01, "1")))
    print(f"200 blows, 8 responses, {RATE:g} Hz: {time.perf_counter() - begun:.2f} s")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
