"""What every laboratory has and nobody asks about: nuisances, never the answer.

| nuisance | what is drawn |
|---|---|
| second_mode | 1 to 5 % of the (last) mass hangs on a spring of its own, at 4 to 8 times f_n, ratio 0.005-0.03 |
| flicker_noise | noise of every channel grows as 1/f in power below a corner of 20 to 200 Hz |
| quantisation | 16 bit; the range is 10 to 100 times the largest value of the campaign |
| anti_alias_filter | the recorder's Butterworth filter of order 2 to 8, corner at 0.3 to 0.45 of the rate |
| gain_error | every channel reads 1 % too much or too little |
| skew | every response is sampled 20 us before or after the controls |
| slow_drift | the stiffness of all joints changes by 0.5 %: in each test, or over the campaign |
| rocking_table | the two controls differ by 2 % rms, by a resonance of the table; the joint stands off centre |

The generator of a nuisance is its own, so that a campaign with nuisances is otherwise the one
without.
"""  # noqa: E501 - a table

import zlib
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy import fft, signal

from blind.draws import Rng, log_uniform, sign
from blind.excitations import SAMPLE_RATE

NUISANCES = (
    "second_mode", "flicker_noise", "quantisation", "anti_alias_filter", "gain_error", "skew",
    "slow_drift", "rocking_table",
)  # fmt: skip
GAIN_ERROR, SKEW, DRIFT, ROCKING = 0.01, 20e-6, 0.005, 0.02
"""Gain [-], delay [s], relative change of stiffness [-], difference of the controls [-]."""


def chosen(text: str) -> tuple[str, ...]:
    """Return the nuisances that the tail of a class name asks for.

    Raises
    ------
    ValueError
        If there is no such nuisance.
    """
    if text == "all":
        return NUISANCES
    names = tuple(filter(None, text.split("+")))
    for name in names:
        if name not in NUISANCES:
            raise ValueError(f"no nuisance {name!r}; there are all, {', '.join(NUISANCES)}")
    return names


@dataclass(frozen=True)
class Nuisances:
    """What was drawn; the neutral value is none of it.

    Attributes
    ----------
    second_mode : (share of the mass, factor of the frequency, damping ratio) or None
    flicker_corner : float
        Frequency at which 1/f noise equals the white noise [Hz].
    quantisation : float
        Range over the largest value; 0 for none [-].
    filter_order, filter_corner : int, float
        Of the recorder; order 0 for none; corner [Hz].
    gains : tuple of float
        Of the channels, controls first; empty for none [-].
    skews : tuple of float
        Delays of the responses; empty for none [s].
    drift : tuple of (float, float)
        For each test the change of stiffness a second and the time of no change [1/s, s].
    rocking : (frequency, damping ratio, place of the joint from -0.5 to 0.5) or None
    """

    second_mode: tuple[float, float, float] | None = None
    flicker_corner: float = 0.0
    quantisation: float = 0.0
    filter_order: int = 0
    filter_corner: float = 0.0
    gains: tuple[float, ...] = ()
    skews: tuple[float, ...] = ()
    drift: tuple[tuple[float, float], ...] = ()
    rocking: tuple[float, float, float] | None = None
    numbers: dict[str, Any] = field(default_factory=dict)


def draw(seed: int, base: str, names: tuple[str, ...], n_responses: int) -> Nuisances:
    """Return the nuisances of a campaign; each has a generator of its own."""
    drawn: dict[str, Any] = {}
    for name in names:
        rng = np.random.default_rng([
            seed,
            zlib.crc32(base.encode()),
            zlib.crc32(name.encode()),
        ])
        drawn |= _DRAWS[name](rng, n_responses)
    return Nuisances(**drawn, numbers=dict(drawn))


def _second_mode(rng: Rng, _: int) -> dict[str, Any]:
    share, factor = log_uniform(rng, 0.01, 0.05), rng.uniform(4.0, 8.0)
    return {"second_mode": (share, float(factor), log_uniform(rng, 0.005, 0.03))}


def _flicker(rng: Rng, _: int) -> dict[str, Any]:
    return {"flicker_corner": log_uniform(rng, 20.0, 200.0)}


def _quantisation(rng: Rng, _: int) -> dict[str, Any]:
    return {"quantisation": log_uniform(rng, 10.0, 100.0)}


def _filter(rng: Rng, _: int) -> dict[str, Any]:
    corner = SAMPLE_RATE * rng.uniform(0.3, 0.45)
    return {"filter_order": int(rng.integers(2, 9)), "filter_corner": float(corner)}


def _gains(rng: Rng, n_responses: int) -> dict[str, Any]:
    return {"gains": tuple(1.0 + GAIN_ERROR * sign(rng) for _ in range(2 + n_responses))}


def _skew(rng: Rng, n_responses: int) -> dict[str, Any]:
    return {"skews": tuple(SKEW * sign(rng) for _ in range(n_responses))}


def _slow_drift(rng: Rng, _: int) -> dict[str, Any]:
    """Four tests of 20 s: in each test about its middle, or on and on through the campaign."""
    change, seconds = DRIFT * sign(rng), 20.0
    if rng.random() < 0.5:
        return {"drift": ((change / seconds, seconds / 2.0),) * 4}
    return {"drift": tuple((change / (4 * seconds), (2 - i) * seconds) for i in range(4))}


def _rocking(rng: Rng, _: int) -> dict[str, Any]:
    resonance, ratio = log_uniform(rng, 100.0, 1500.0), log_uniform(rng, 0.02, 0.1)
    return {"rocking": (resonance, ratio, float(rng.uniform(-0.5, 0.5)))}


_DRAWS = {
    "second_mode": _second_mode,
    "flicker_noise": _flicker,
    "quantisation": _quantisation,
    "anti_alias_filter": _filter,
    "gain_error": _gains,
    "skew": _skew,
    "slow_drift": _slow_drift,
    "rocking_table": _rocking,
}


def inputs(drawn: Nuisances, waves: list[np.ndarray], *, forced: bool) -> list[np.ndarray]:
    """Return what controls (or the force channel) record of each excitation."""
    felt = [wave[None, :] for wave in waves] if forced else _rocked(drawn, waves)
    return [np.array([recorded(drawn, row, SAMPLE_RATE) for row in rows]) for rows in felt]


def _rocked(drawn: Nuisances, waves: list[np.ndarray]) -> list[np.ndarray]:
    """Return what the two controls feel of each base acceleration, (2, n_samples) arrays."""
    if drawn.rocking is None:
        return [np.array([wave, wave]) for wave in waves]
    resonance, ratio, place = drawn.rocking
    rocking = [_filtered(wave, _mode(resonance, ratio), SAMPLE_RATE) for wave in waves]
    size = ROCKING * _rms(waves[1]) / (2.0 * _rms(rocking[1]))
    return [
        np.array([wave + (1.0 - place) * size * r, wave - (1.0 + place) * size * r])
        for wave, r in zip(waves, rocking, strict=True)
    ]


def _mode(resonance: float, ratio: float) -> Any:
    def gain(f: np.ndarray) -> np.ndarray:
        x = f / resonance
        return x**2 / (1.0 - x**2 + 2j * ratio * x)

    return gain


def recorded(drawn: Nuisances, values: np.ndarray, rate: float, delay: float = 0.0) -> Any:
    """Return a channel behind the recorder's filter and its delay, at the rate it is given."""
    if not drawn.filter_order and not delay:
        return values
    poles = ((0.0,), (1.0,))
    if drawn.filter_order:
        corner = 2.0 * np.pi * drawn.filter_corner
        poles = signal.butter(drawn.filter_order, corner, analog=True)

    def gain(f: np.ndarray) -> np.ndarray:
        turn = np.exp(-2j * np.pi * f * delay)
        if not drawn.filter_order:
            return turn
        return turn * signal.freqs(*poles, worN=2.0 * np.pi * f)[1]

    return _filtered(values, gain, rate)


def _filtered(values: np.ndarray, gain: Any, rate: float) -> np.ndarray:
    n = fft.next_fast_len(2 * values.size, real=True)
    f = fft.rfftfreq(n, 1.0 / rate)
    out: np.ndarray = fft.irfft(fft.rfft(values, n) * gain(f), n)[: values.size]
    return out


def flicker(drawn: Nuisances, white_rms: float, n: int, rng: Rng) -> np.ndarray:
    """Return 1/f noise that equals white noise of this rms at the corner; none below 0.5 Hz."""
    f = fft.rfftfreq(n, 1.0 / SAMPLE_RATE)
    share = np.sqrt(drawn.flicker_corner / np.maximum(f, 0.5))
    share[0] = 0.0
    out: np.ndarray = white_rms * fft.irfft(fft.rfft(rng.standard_normal(n)) * share, n)
    return out


def quantised(drawn: Nuisances, values: np.ndarray, largest: float) -> np.ndarray:
    """Return a channel in steps of 16 bit of a range that is too wide."""
    if not drawn.quantisation:
        return values
    step = drawn.quantisation * largest / 2.0**15
    return step * np.round(values / step)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
