"""Modes, blows, decays and multisines of bad input: each is one line with the remedy."""

import numpy as np
import pytest
from tests.in_process import run
from tests.struck import RATE, struck

HEAD = "testlog: 1\nrecordings: .\nprocessing: {crop: none}\n"
FORCE = "  f: {role: force, unit: N}\n"
A, B = (f"  {name}: {{role: response, unit: m/s^2}}\n" for name in "ab")
PLACED = "".join(
    f"  {name}: {{role: response, unit: m/s^2, position: [{k} mm, 0 mm, 0 mm]}}\n"
    for k, name in enumerate("ab")
)
BAND = "from: 20 Hz, to: 350 Hz"


def blows():
    rows = struck([(0.5, 100.0), (2.5, 110.0), (4.5, 120.0)], 6.5, noise=(0.05, 0.005))
    return dict(zip("fab", rows, strict=True))


def noise(seconds=4.0):
    """Sensors that follow the force as stiffly as a block: no pole, and noise."""
    rows = np.random.default_rng(1).standard_normal((3, int(RATE * seconds)))
    rows[1:] += rows[0]
    return dict(zip("fab", rows, strict=True))


def ring(seconds):
    rows = struck([(0.02, 100.0)], seconds, noise=(0.05, 0.005))
    return dict(zip("fab", rows, strict=True))


def drifting():
    """A sine whose frequency moves: no period repeats."""
    time = np.arange(int(8.0 * RATE)) / RATE
    swept = np.sin(2.0 * np.pi * (30.0 + 10.0 * time) * time)
    return {"f": swept, "a": 0.5 * swept, "b": 0.3 * swept}


CASES = {
    "sensors without position": (
        "modal", FORCE + A + B, "excitation: hammer", blows,
        "no position for a, b", "add position",
    ),
    "one response only": (
        "modal", FORCE + A + "  b: {role: ignore}\n", "excitation: hammer", blows,
        "one response only", "two sensors or more",
    ),
    "poles that do not stabilise": (
        "modal", FORCE + PLACED, "excitation: random", noise,
        "no pole stays over the orders", "widen the band",
    ),
    "an order too high": (
        "modal", FORCE + PLACED, "excitation: random", lambda: noise(0.25),
        "is too high for", "at most",
    ),
    "a decay too short": (
        "process", FORCE + PLACED, "excitation: free decay", lambda: ring(0.18),
        "60.8 Hz: no curve: the decay lasts", "are needed to isolate",
    ),
    "no trigger": (
        "process", FORCE + PLACED, "excitation: hammer", noise, "no blow found", "role force",
    ),
    "periods that do not repeat": (
        "process", FORCE + PLACED,
        "excitation: multisine, multisine: {period: 1 s, periods: 8}", drifting,
        "the periods do not repeat", "correct",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_each_is_one_line_with_the_remedy(case, tmp_path, capsys):
    command, channels, test, rows, says, remedy = CASES[case]
    np.savez(tmp_path / "run.npz", fs=RATE, **rows())
    log = tmp_path / "testlog.yaml"
    log.write_text(
        f"{HEAD}channels:\n{channels}tests:\n"
        f"  - {{id: 1, recording: run.npz, {test}, {BAND}}}\n"
    )
    out = ("--out", tmp_path / "out", "--no-figures")
    if command == "modal":
        run("modal", log, *out)
    else:
        run("process", tmp_path / "run.npz", "--log", log, *out)
    shown = capsys.readouterr()
    lines = [one for one in (shown.out + shown.err).splitlines() if says in one]
    assert len(lines) == 1, shown
    assert remedy in lines[0]
    assert "Traceback" not in shown.err


def test_unequal_sets_of_sensors_are_one_line(tmp_path, capsys):
    for number in (1, 2):
        np.savez(tmp_path / f"{number}.npz", fs=RATE, **blows())
    log = tmp_path / "testlog.yaml"
    one, other = (
        f"  - {{id: {number}, recording: {number}.npz, excitation: hammer, {BAND}{more}}}\n"
        for number, more in ((1, ""), (2, ", channels: {b: {role: ignore}}"))
    )
    log.write_text(f"{HEAD}channels:\n{FORCE}{PLACED}tests:\n{one}{other}")
    assert run("modal", log, "--out", tmp_path / "out", "--no-figures") == 0
    lines = capsys.readouterr().out.splitlines()
    (told,) = [text for text in lines if "not the same sensors" in text]
    assert "give channels the same name" in told
