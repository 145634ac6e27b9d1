"""Notch plans of blind campaigns: how often the truth breaks a limit that they keep.

``python -m benchmarks.notches [FIRST [COUNT]]``. Noise 6 dB above the loudest level is notched
so that the largest value of the first response stays, with 95 %, below 70 % of what linear
scaling says of it. The truth is then driven by twenty realisations of the notched profile, by
the code of the hidden campaigns.
"""

import sys
from dataclasses import replace

import numpy as np
from blind.campaigns import Drawn
from blind.excitations import SAMPLE_RATE, waveform
from blind.recorder import SUBSTEPS

from benchmarks.forecast import planned_test, ready, recorded
from shakerproc.errors import ShakerprocError
from shakerproc.forecasts import forecast_tests
from shakerproc.forecasts.notch_plan import NotchWish
from shakerproc.testlog.excitation import Profile
from shakerproc.testlog.header import Limit

CLASSES = ("gap", "none", "cubic_stiffness", "coulomb_friction", "quadratic_damping", "jenkins",
           "stop", "bouc_wen", "power_law", "iwan")  # fmt: skip
ABOVE_DB, SHARE, TRUTHS = 6.0, 0.7, 20


def campaign(seed: int, text: str) -> tuple[str, int, int]:
    """Return how a plan went, and how many truths of how many break its limit."""
    own = ready(seed, f"{text}:random")
    drawn = own.drawn
    measured = max(own.tests, key=lambda test: float(np.std(test.input)))
    row = measured.responses[0, measured.start : measured.stop]
    most = SHARE * 10.0 ** (ABOVE_DB / 20.0) * float(np.max(np.abs(row - row.mean())))
    name = measured.sensors[0]
    unit = own.model.sensor_unit(own.model.sensors[name])
    log = replace(own.log, limits=(Limit("response", name, "peak", most, unit, (name,)),))
    planned = planned_test(log.tests[2], drawn, ABOVE_DB)
    (one,) = forecast_tests(own.model, log, own.tests, [planned], wish=NotchWish()).tests
    if one.notch is None or one.notch.found is None:
        return "no plan" if one.notch is None else one.notch.why_none, 0, 0
    profile = one.notch.found.test.profile
    if profile is None:
        return "no profile", 0, 0
    told = f"{one.notch.found.deepest_db:.1f} dB, {one.notch.found.exceeds[0]:.1%} stated"
    peaks = [_peak(drawn, profile, i, one.planned.compared) for i in range(TRUTHS)]
    return told, sum(peak > most for peak in peaks), len(peaks)


def _peak(drawn: Drawn, profile: Profile, number: int, band: tuple[float, float]) -> float:
    """Return the largest value of the first response in one truth, infinite if it runs away."""
    plan = drawn.plan
    drive = plan.drives[2]
    louder = replace(
        drive, level=drive.level * 10.0 ** (ABOVE_DB / 20.0), seed=(*drive.seed, 1000 + number)
    )
    wave = waveform(louder, 2 * SUBSTEPS)
    spectrum = np.fft.rfft(wave)
    f = np.maximum(np.fft.rfftfreq(wave.size, 1.0 / (2 * SUBSTEPS * SAMPLE_RATE)), 1e-3)
    level = np.interp(np.log(f), np.log(profile.frequency_hz), np.log(profile.level))
    spectrum *= np.sqrt(np.exp(level) / max(profile.level))
    notched = np.fft.irfft(spectrum, wave.size)
    motion = replace(plan, limit=100.0 * plan.limit).driven(notched, 2)
    if motion is None:
        return float("inf")
    row = recorded(drawn, motion, band)[0]
    return float(np.max(np.abs(row - row.mean())))


def main(first: int = 1, count: int = len(CLASSES)) -> None:
    """Print how each plan went."""
    broken, total = 0, 0
    for i in range(count):
        kind, seed = CLASSES[i % len(CLASSES)], first + i // len(CLASSES)
        try:
            told, over, of = campaign(seed, kind)
        except (ShakerprocError, RuntimeError) as error:
            print(f"{kind} {seed}: {error}", flush=True)
            continue
        broken, total = broken + over, total + of
        print(f"{kind} {seed}: {told}; limit broken in {over} of {of} truths", flush=True)
    print(f"all: {broken} of {total}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
