"""A small campaign to begin with: a coupon whose joint has play, simulated and recorded."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from shakerproc import files

if TYPE_CHECKING:
    from shakerproc.data import FloatArray, Recording
    from shakerproc.models import Model

RATE: Final = 2560.0
BAND: Final = (20.0, 800.0)
QUIET: Final = 0.5
RAMP: Final = 0.1
NOISE_G: Final = 0.01
OVERSAMPLED: Final = 4
"""Samples that the converter takes for each one that it stores, past its filter [-]."""

MASS: Final = 28.6e-3
SUPPORT: Final = 3.6e4
DAMPING: Final = 2.6
CONTACT: Final = 5.0e4
PLAY: Final = 5.0e-5


@dataclass(frozen=True, slots=True)
class ExampleTest:
    """One test of the example.

    Attributes
    ----------
    number : int
        Its id.
    level : float
        Density of the excitation [g²/Hz].
    seconds : float
        Length of the run [s].
    hold_out : bool
        Whether it is kept aside.
    """

    number: int
    level: float
    seconds: float
    hold_out: bool = False


TESTS: Final = (
    ExampleTest(1, 0.001, 6.0),
    ExampleTest(2, 0.005, 6.0),
    ExampleTest(3, 0.02, 6.0),
    ExampleTest(4, 0.01, 6.0, hold_out=True),
)

LOG: Final = """\
# The log sheet of a campaign: what was on the shaker, test by test.

testlog: 1
title: {title}
recordings: recordings          # folder beside this file; nothing outside it is ever read

channels:                       # name in the recording (or its number): what it is
  control 1:  {{role: control}}   # sensors on the table that the controller holds to the level
  control 2:  {{role: control}}
  response 1: {{role: response, name: ch3, at: coupon}}   # `name` is used in tables and models

processing:                     # all optional
  crop: {{channel: control 2, threshold: 0.3 g}}          # the run is what lies between
  welch: {{segment: 1024, overlap: 512, window: hamming}}

tests:                          # every value is text with a unit
"""

ROW: Final = """\
  - {{id: {number}, recording: test_{number}.tdms, joint: radial, specimen: a_0_10,
     clearance: 0.10 mm, orientation: out of plane, excitation: random, level: {level} g^2/Hz,
     from: 20 Hz, to: 800 Hz{more}}}
"""

MODEL: Final = """\
# What is thought to be on the shaker: a coupon on a spring and a damper. What else a model may
# hold is listed by `shakerproc effects`. Compare it with the recordings, and let the program
# find what it leaves out:
#
#     shakerproc compare model.yaml testlog.yaml
#     shakerproc diagnose model.yaml testlog.yaml

model: 1
title: radial coupon, linear
masses: {coupon: 28.6 g}
elements:
  - {kind: spring, between: [base, coupon], stiffness: 3.8e4 N/m}    # guesses will do:
  - {kind: damper, between: [base, coupon], damping: 3.2 N s/m}      # both are fitted
excitation: {base: acceleration}        # or {force on: coupon}
sensors:                                # which channel measures what
  ch3: {at: coupon, measures: acceleration}
"""


def write_example(
    folder: Path,
    title: str = "A coupon with play in its joint, simulated",
    advance: Callable[[str], None] = lambda _text: None,
) -> tuple[Path, Path]:
    """Write recordings, a log and a model of them that lacks the gap; return log and model."""
    from shakerproc.recordings import write_tdms

    recordings = folder / "recordings"
    recordings.mkdir(parents=True, exist_ok=True)
    for test in TESTS:
        path = recordings / f"test_{test.number}.tdms"
        with files.atomic_path(path) as temporary:
            write_tdms(temporary, _recorded(test))
        advance(f"test {test.number}")
    rows = [
        ROW.format(
            number=test.number,
            level=f"{test.level:g}",
            more=",\n     hold_out: true" if test.hold_out else "",
        )
        for test in TESTS
    ]
    log, model = folder / "testlog.yaml", folder / "model.yaml"
    files.write_text(log, LOG.format(title=title) + "".join(rows))
    files.write_text(model, MODEL)
    return log, model


def _truth() -> "Model":
    """Return what the recordings come from; the model that is written lacks the gap."""
    from shakerproc.models import Element, Excitation, Model, Sensor
    from shakerproc.models.effects.damper import Damper
    from shakerproc.models.effects.gap import Gap
    from shakerproc.models.effects.spring import Spring

    between = ("base", "coupon")
    return Model(
        title="truth",
        masses={"coupon": MASS},
        elements=(
            Element(Spring(stiffness=SUPPORT), between),
            Element(Damper(damping=DAMPING), between),
            Element(Gap(stiffness=CONTACT, clearance=PLAY), between),
        ),
        excitation=Excitation("base acceleration"),
        sensors={"ch3": Sensor("coupon")},
    )


def _base_motion(test: ExampleTest) -> "FloatArray":
    """Return random acceleration of the table, quiet before and after, (n,) array [m/s²]."""
    import numpy as np

    from shakerproc.data import STANDARD_GRAVITY

    rng = np.random.default_rng(20180605 + test.number)
    n = round((test.seconds + 2.0 * QUIET) * RATE)
    frequency = np.fft.rfftfreq(n, 1.0 / RATE)
    spectrum = rng.standard_normal(frequency.size) + 1j * rng.standard_normal(frequency.size)
    spectrum[(frequency < BAND[0]) | (frequency > BAND[1])] = 0.0
    motion = np.fft.irfft(spectrum, n)
    motion *= np.sqrt(test.level * (BAND[1] - BAND[0])) / np.std(motion)
    from_end = np.minimum(np.arange(n), np.arange(n)[::-1]) / RATE
    return np.asarray(
        motion * np.clip((from_end - QUIET) / RAMP, 0.0, 1.0) * STANDARD_GRAVITY, dtype=float
    )


def _resampled(samples: "FloatArray", count: int) -> "FloatArray":
    """Return the same signal in so many samples, without what they cannot hold, (count,) array.

    A contact bends the acceleration, which holds frequencies without end; a recorder's filter
    keeps them from folding into the band.
    """
    import numpy as np

    spectrum = np.fft.rfft(samples)[: count // 2 + 1]
    return np.asarray(np.fft.irfft(spectrum, count) * (count / samples.size), dtype=float)


def _recorded(test: ExampleTest) -> "Recording":
    """Return what the logger would have stored of a test."""
    import numpy as np

    from shakerproc.data import STANDARD_GRAVITY, Channel, recording_of_arrays
    from shakerproc.simulation import simulate

    base = _base_motion(test)
    finer = _resampled(base, OVERSAMPLED * base.size)
    response = simulate(_truth(), finer, OVERSAMPLED * RATE, growth=False).outputs["ch3"]
    response = _resampled(response, base.size)
    rng = np.random.default_rng(test.number)
    rows = np.array([base, base, response])
    rows += NOISE_G * STANDARD_GRAVITY * rng.standard_normal(rows.shape)
    channels = [
        Channel(name, "m/s^2", name, "g") for name in ("control 1", "control 2", "response 1")
    ]
    return recording_of_arrays(f"test {test.number}", channels, rows, RATE)
