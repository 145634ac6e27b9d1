"""Notch plans of blind campaigns: how often the truth breaks a limit that they keep.

``python -m benchmarks.notches [FIRST [COUNT]]``. Four seconds of noise 6 dB above the loudest
level are notched so that the largest value of the first response stays, with 95 %, below 70 %
of what linear scaling says of it. The truth is then driven by twenty realisations of the
notched profile, by the code of the hidden campaigns.
"""

import sys
import time
from dataclasses import dataclass, replace

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
ABOVE_DB, SHARE, TRUTHS, SECONDS = 6.0, 0.7, 20, 4.0


@dataclass(frozen=True)
class Kept:
    """A plan: what it says of itself, and how many truths of how many break its limit."""

    told: str
    stated: float = 0.0
    broken: int = 0
    truths: int = 0


def campaign(seed: int, text: str) -> Kept:
    """Return how the plan of a campaign went."""
    own = ready(seed, f"{text}:random")
    drawn = own.drawn
    measured = own.tests[2]
    row = measured.responses[0, measured.start : measured.stop]
    most = SHARE * 10.0 ** (ABOVE_DB / 20.0) * float(np.max(np.abs(row - row.mean())))
    name = measured.sensors[0]
    unit = own.model.sensor_unit(own.model.sensors[name])
    log = replace(own.log, limits=(Limit("response", name, "peak", most, unit, (name,)),))
    planned = replace(planned_test(log.tests[2], drawn, ABOVE_DB), duration=SECONDS)
    (one,) = forecast_tests(own.model, log, own.tests, [planned], wish=NotchWish()).tests
    found = one.notch.notched if one.notch else None
    if found is None or found.test.profile is None:
        return Kept(one.notch.why_none if one.notch else "no plan")
    profile = found.test.profile
    peaks = [_peak(drawn, profile, i, one.planned.compared) for i in range(TRUTHS)]
    return Kept(
        f"{found.deepest_db:.1f} dB at most", found.exceeds[0],
        sum(peak > most for peak in peaks), len(peaks),
    )  # fmt: skip


def _peak(drawn: Drawn, profile: Profile, number: int, band: tuple[float, float]) -> float:
    """Return the largest value of the first response in one truth, infinite if it runs away."""
    plan = drawn.plan
    drive = plan.drives[2]
    louder = replace(
        drive, level=drive.level * 10.0 ** (ABOVE_DB / 20.0), seed=(*drive.seed, 1000 + number)
    )
    samples = round((drive.lead_in + SECONDS + drive.tail) * SAMPLE_RATE)
    wave = waveform(louder, 2 * SUBSTEPS, samples)
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
    found = []
    for i in range(count):
        kind, seed = CLASSES[i % len(CLASSES)], first + i // len(CLASSES)
        start = time.process_time()
        try:
            one = campaign(seed, kind)
        except (ShakerprocError, RuntimeError) as error:
            one = Kept(str(error))
        found.append(one)
        print(
            f"{kind} {seed}: {one.told}; stated {one.stated:.1%}, limit broken in {one.broken} "
            f"of {one.truths} truths; {time.process_time() - start:.0f} s",
            flush=True,
        )
    made = [one for one in found if one.truths]
    stated = np.mean([one.stated for one in made])
    broken, of = sum(one.broken for one in made), sum(one.truths for one in made)
    print(f"{len(made)} plans of {len(found)}: stated {stated:.1%}, broken in {broken} of {of}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
