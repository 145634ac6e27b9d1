"""From the motion to what the channels hold: sensors, noise, faults, the recorder."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from scipy import fft, signal

from blind import nuisances
from blind.draws import Rng, log_uniform, sign
from blind.excitations import N_SAMPLES, SAMPLE_RATE
from blind.nuisances import Nuisances
from blind.structures import Structure
from blind.truth import Motion

SUBSTEPS = 8
"""Steps of the truth in one sample."""


def rms(values: np.ndarray) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def responses(
    structure: Structure, motion: Motion, drawn: Nuisances, *, filtered: bool
) -> np.ndarray:
    """Return what the sensors see, behind the recorder's filter, (n_masses, n) array."""
    n = len(structure.masses)
    delays = drawn.skews or (0.0,) * n
    if structure.measures != "acceleration":
        rows = {"displacement": motion.displacement, "velocity": motion.velocity}
        row = rows[structure.measures]
        return np.array([
            nuisances.recorded(drawn, row[:, i].copy(), SAMPLE_RATE, delays[i])
            for i in range(n)
        ])
    if filtered and not drawn.filter_order:
        taps = _low_pass()
        return np.array([
            nuisances.recorded(
                drawn,
                signal.resample_poly(motion.means[:, i], 1, SUBSTEPS, window=taps),
                SAMPLE_RATE,
                delays[i],
            )
            for i in range(n)
        ])
    fine = SAMPLE_RATE * SUBSTEPS
    return np.array([
        nuisances.recorded(drawn, motion.acceleration[:, i], fine, delays[i])[::SUBSTEPS]
        for i in range(n)
    ])


@cache
def _low_pass() -> np.ndarray:
    """Return the recorder's filter, flat to 1e-5 up to 0.42 of the rate, from means over steps.

    Means hold a thirtieth of what folds back of jumps into the steps. Their droop is made good,
    and an even length moves them from the middles of the steps to their beginnings.
    """
    share = np.linspace(0.0, 1.0, 8193)  # of half the rate of the steps
    edge = 0.9 / SUBSTEPS
    gain = np.where(share <= edge, 1.0 / np.sinc(0.5 * share), 0.0)
    taps: np.ndarray = signal.firwin2(128 * SUBSTEPS, share, gain, window=("kaiser", 10.06))
    return taps


@dataclass(frozen=True)
class Channels:
    """The chain of measurement of one campaign.

    Attributes
    ----------
    share : float
        White noise over the response [-].
    own : bool
        Whether the noise follows the level of a test, instead of standing still.
    faulty : int
        Response that has the fault.
    spoil : callable
        What the fault makes of a response.
    drawn : Nuisances
        What else the chain does.
    """

    share: float
    own: bool
    faulty: int
    spoil: Any
    drawn: Nuisances

    def record(
        self, rng: Rng, flickering: Rng, control: list[np.ndarray], clean: list[np.ndarray]
    ) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return inputs and responses of every test as recorded; the quiet ones are clean."""
        out = []
        for i, (felt, seen) in enumerate(zip(control, clean, strict=True)):
            reference = i if self.own else 1
            levels = [self.share * rms(row) for row in clean[reference]]
            level = self.share * rms(control[reference][0])
            noisy = np.array([
                row + size * rng.standard_normal(row.size)
                for row, size in zip(seen, levels, strict=True)
            ])
            noisy[self.faulty] = self.spoil(noisy[self.faulty])
            inputs = felt + level * rng.standard_normal(felt.shape)
            if self.drawn.flicker_corner:
                inputs = inputs + self._flicker(flickering, [level] * len(inputs))
                noisy = noisy + self._flicker(flickering, levels)
            out.append(self._gained(inputs, noisy))
        return self._quantised(out)

    def _flicker(self, rng: Rng, levels: list[float]) -> np.ndarray:
        rows = [nuisances.flicker(self.drawn, level, N_SAMPLES, rng) for level in levels]
        return np.array(rows)

    def _gained(self, inputs: np.ndarray, noisy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        gains = np.array(self.drawn.gains or (1.0,) * (2 + len(noisy)))[:, None]
        return inputs * gains[: len(inputs)], noisy * gains[2:]

    def _quantised(
        self, tests: list[tuple[np.ndarray, np.ndarray]]
    ) -> list[tuple[np.ndarray, np.ndarray]]:
        if not self.drawn.quantisation:
            return tests
        largest = [
            np.max([np.max(np.abs(test[side]), axis=1) for test in tests], axis=0)
            for side in (0, 1)
        ]
        return [
            tuple(  # type: ignore[misc]
                np.array([
                    nuisances.quantised(self.drawn, row, top)
                    for row, top in zip(test[side], largest[side], strict=True)
                ])
                for side in (0, 1)
            )
            for test in tests
        ]


def draw_fault(
    rng: Rng, fault: str | None, clean: list[np.ndarray], share: float
) -> tuple[Any, dict[str, float]]:
    """Return what spoils a channel, and its parameters."""
    if fault is None:
        return (lambda x: x), {}
    spoil, numbers = _FAULTS[fault](rng, clean, share)
    return spoil, numbers


def _delay(rng: Rng, _: list[np.ndarray], __: float) -> Any:
    tau = log_uniform(rng, 5e-5, 1e-2)
    f = fft.rfftfreq(2 * N_SAMPLES, 1.0 / SAMPLE_RATE)
    turn = np.exp(-2j * np.pi * f * tau)
    return (
        lambda x: fft.irfft(fft.rfft(x, 2 * N_SAMPLES) * turn, 2 * N_SAMPLES)[:N_SAMPLES],
        {"delay": tau},
    )


def _gain(rng: Rng, _: list[np.ndarray], __: float) -> Any:
    gain = float(np.exp(sign(rng) * rng.uniform(0.06, 0.6)))
    return lambda x: gain * x, {"gain": gain}


def _polarity(_: Rng, __: list[np.ndarray], ___: float) -> Any:
    return np.negative, {}


def _clipping(rng: Rng, clean: list[np.ndarray], _: float) -> Any:
    peak = float(np.max(np.abs(clean[2])))
    level = peak * rng.uniform(0.3, 0.75)
    return lambda x: np.clip(x, -level, level), {"level": level}


def _hum(rng: Rng, clean: list[np.ndarray], share: float) -> Any:
    t = np.arange(N_SAMPLES) / SAMPLE_RATE
    f, size = float(rng.choice([50.0, 60.0])), rms(clean[1][0])
    a = size * max(log_uniform(rng, 0.05, 0.5), 2.0 * share)
    p = rng.uniform(0.0, 6.28, 3)
    hum = sum(
        a * s * np.sin(2.0 * np.pi * h * f * t + x)
        for h, s, x in zip((1, 3, 5), (1.0, 0.3, 0.1), p, strict=True)
    )
    return lambda x: x + hum, {"frequency": f, "amplitude": a}


_FAULTS = {
    "sensor_delay": _delay,
    "sensor_gain": _gain,
    "sensor_polarity": _polarity,
    "clipping": _clipping,
    "mains_hum": _hum,
}
