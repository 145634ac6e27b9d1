"""Write docs/conformance.md: python docs/make_conformance.py [--check].

Each number that a standard or a published table defines is recomputed with the code that
processes recordings, and stands beside the value of the standard. Values of standards are typed
here, or computed from the standard's own formula with numpy and scipy alone.
"""

import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Final

import numpy as np
import scipy

from shakerproc import spectra
from shakerproc.runs import levels
from shakerproc.runs.analyses.tones import frequency_tolerance
from shakerproc.runs.budget import Budget, normal, rectangular
from shakerproc.runs.levels import Level
from shakerproc.runs.pairs import NAMES
from shakerproc.spectra.kernels import rainflow
from shakerproc.spectra.octaves import octave_bands, octave_filter
from shakerproc.spectra.profiles import profile_rms
from shakerproc.spectra.response_spectra import shock_spectra, transitions
from shakerproc.testlog import Processing, Test
from shakerproc.testlog.excitation import LevelKind
from shakerproc.testlog.one_test import nominal_duration
from shakerproc.testlog.processing import Shock
from shakerproc.units import to_si

PAGE = Path(__file__).with_name("conformance.md")

MEMORY: Final = "from memory"
"""Mark of a clause behind whose number stands nothing else."""


@dataclass(frozen=True, slots=True)
class Check:
    """One number: what the standard says, what the program finds, and how far they may differ.

    Attributes
    ----------
    standard, clause, quantity, unit : str
        Where the number is defined, what it is, and its unit.
    wanted : float, text, or a pair of floats
        The number or the name of the standard, or limits.
    found : float or str
        What the program finds.
    tolerance : float
        Largest difference: half the last digit of the standard's number, or what it allows.
    """

    standard: str
    clause: str
    quantity: str
    unit: str
    wanted: float | str | tuple[float, float]
    found: float | str
    tolerance: float = 0.0

    @property
    def difference(self) -> float | None:
        """How far the number is off; beyond limits, by how much; None of a name."""
        if isinstance(self.wanted, str) or isinstance(self.found, str):
            return None
        if isinstance(self.wanted, tuple):
            low, high = self.wanted
            return max(low - self.found, self.found - high, 0.0)
        return self.found - self.wanted

    @property
    def passed(self) -> bool:
        """Whether the program agrees with the standard."""
        if self.difference is None:
            return self.wanted == self.found
        return abs(self.difference) <= self.tolerance * (1.0 + 1e-9) + 1e-12 * abs(self.scale)

    @property
    def scale(self) -> float:
        """Size of the number."""
        return float(self.found) if not isinstance(self.found, str) else 1.0


IEC_61260: Final = "IEC 61260-1:2014"
EXACT: Final = (
    25.119, 31.623, 39.811, 50.119, 63.096, 79.433, 100.00, 125.89, 158.49, 199.53, 251.19,
    316.23, 398.11, 501.19, 630.96, 794.33, 1000.0, 1258.9, 1584.9, 1995.3, 2511.9, 3162.3,
    3981.1, 5011.9, 6309.6, 7943.3, 10000.0, 12589.0, 15849.0, 19953.0,
)  # fmt: skip
NOMINAL: Final = (31.5, 63.0, 125.0, 250.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0, 16000.0)
CLASS_1: Final = (
    (0.0, -0.4, 0.4), (0.125, -0.4, 0.5), (0.25, -0.4, 0.7), (0.375, -0.4, 1.4),
    (0.5, 1.2, 5.3), (1.0, 16.6, np.inf), (2.0, 40.5, np.inf), (3.0, 60.0, np.inf),
    (4.0, 70.0, np.inf),
)  # fmt: skip
"""Octaves from the middle, least and largest relative attenuation of class 1 [dB]."""
EVEN: Final = ((2, 1188.5), (6, 1059.3), (12, 1029.2), (24, 1014.5))


def octaves() -> Iterator[Check]:
    """Yield exact and nominal middles, edges and the mask of class 1."""
    thirds = octave_bands(3, 25.0, 20_000.0)
    yield Check(
        IEC_61260, "eq. 1", "octave ratio G", "1", 1.99526,
        float(thirds.middle[3] / thirds.middle[0]), 5e-6,
    )  # fmt: skip
    for exact, found, nominal in zip(EXACT, thirds.middle, thirds.nominal, strict=True):
        digit = 0.5 * 10.0 ** (np.floor(np.log10(exact)) - 4)
        name = f"exact middle of the third octave {nominal:g} Hz"
        yield Check(IEC_61260, "eq. 2, annex E", name, "Hz", exact, float(found), digit)
    for nominal, found in zip(NOMINAL, octave_bands(1, 31.5, 16_000.0).nominal, strict=True):
        name = f"nominal middle of the octave {nominal:g} Hz"
        yield Check(IEC_61260, "annex E", name, "Hz", nominal, float(found))
    for fraction, above in EVEN:
        bands = octave_bands(fraction, 1000.0, 1300.0)
        name = f"first exact middle above 1 kHz, 1/{fraction} octave"
        yield Check(IEC_61260, "eq. 3", name, "Hz", above, float(bands.middle[0]), 0.05)
    for fraction, low, high in ((1, 707.95, 1412.5), (3, 891.25, 1122.0)):
        band = octave_bands(fraction, 1000.0, 1000.0)
        name = f"edge of the 1/{fraction} octave at 1 kHz"
        yield Check(IEC_61260, "eq. 4", f"lower {name}", "Hz", low, float(band.lower[0]), 5e-3)
        yield Check(IEC_61260, "eq. 5", f"upper {name}", "Hz", high, float(band.upper[0]), 0.05)
    yield from _masks()


def _masks() -> Iterator[Check]:
    """Yield the attenuation of the filters of 1 kHz at the points of the mask."""
    ratio, rate = 10.0**0.3, 51_200.0
    for fraction in (1, 3):
        sos = octave_filter(octave_bands(fraction, 1000.0, 1000.0), 0, rate)
        share = (ratio ** (0.5 / fraction) - 1.0) / (ratio**0.5 - 1.0)
        for octave, least, most in CLASS_1:
            high = 1.0 + share * (ratio**octave - 1.0)
            for frequency in sorted({1000.0 / high, 1000.0 * high}):
                response = scipy.signal.sosfreqz(sos, worN=[frequency], fs=rate)[1][0]
                yield Check(
                    IEC_61260, "table 1, class 1",
                    f"attenuation of the 1/{fraction} octave at 1 kHz, at {frequency:.1f} Hz",
                    "dB", (least, most), round(-20.0 * np.log10(np.abs(response)), 9) + 0.0,
                )  # fmt: skip


def cycles() -> Iterator[Check]:
    """Yield the counts of the example of the standard."""
    ranges, counts = rainflow(np.array([-2.0, 1, -3, 5, -1, 3, -4, 4, -2]))
    wanted = {9: 0.5, 8: 1.0, 6: 0.5, 4: 1.5, 3: 0.5}
    for size in range(10, 0, -1):
        found = float(counts[ranges == size].sum())
        yield Check(
            "ASTM E1049-85", "5.4.4, figure 6", f"rainflow cycles of range {size}", "1",
            wanted.get(size, 0.0), found,
        )  # fmt: skip


ISO_18431: Final = "ISO 18431-4:2007"


def shocks() -> Iterator[Check]:
    """Yield coefficients of the ramp-invariant filter, and the spectrum of a half-sine."""
    for relative in (0.005, 0.02, 0.05):
        wanted, found = _ramp_invariant(relative, 10.0), _coefficients(relative, 0.05)
        for name, value in wanted.items():
            yield Check(
                ISO_18431, "ramp-invariant filter, absolute acceleration",
                f"{name}, f T = {relative:g}, Q = 10", "1", value, found[name],
                1e-9 * abs(value),
            )  # fmt: skip
    quality = 0.5 / Shock().damping
    yield Check(
        ISO_18431, "usual quality factor", "Q without a word of the log", "1", 10.0, quality
    )
    rate, length = 100_000.0, 0.01
    pulse = np.sin(np.pi * np.arange(0.0, length + 0.5 / rate, 1.0 / rate) / length)
    ratios = np.array([0.25, 0.5, 0.75, 1.5, 2.0, 3.5, 5.5, 10.0])
    found = shock_spectra([pulse[np.newaxis]], rate, ratios / (2.0 * length), 0.0).values
    part = found["absolute_acceleration"]
    for k, x in enumerate(ratios):
        residual = abs(2.0 * x * np.cos(0.5 * np.pi * x) / (1.0 - x * x))
        yield Check(
            ISO_18431, "definition, residual", f"half-sine, undamped, 2 f D = {x:g}", "1",
            float(residual), float(part["residual_positive"][0, k]), 2e-3,
        )  # fmt: skip
        if x > 1.0:
            n = np.arange(1.0, np.floor(0.5 * (x + 1.0)) + 1.0)
            primary = float(np.max(x / (x - 1.0) * np.sin(2.0 * np.pi * n / (x + 1.0))))
            yield Check(
                ISO_18431, "definition, primary", f"half-sine, undamped, 2 f D = {x:g}", "1",
                primary, float(part["primary_positive"][0, k]), 2e-3,
            )  # fmt: skip


def _ramp_invariant(relative: float, quality: float) -> dict[str, float]:
    """Return the coefficients of the standard for absolute acceleration."""
    a = np.pi * relative / quality
    b = 2.0 * np.pi * relative * np.sqrt(1.0 - 0.25 / quality**2)
    decay, turn = np.exp(-a), np.sin(b) / b
    return {
        "β0": float(1.0 - decay * turn),
        "β1": float(2.0 * decay * (turn - np.cos(b))),
        "β2": float(decay**2 - decay * turn),
        "α1": float(-2.0 * decay * np.cos(b)),
        "α2": float(decay**2),
    }


def _coefficients(relative: float, damping: float) -> dict[str, float]:
    """Return the same of the step that shock spectra are made with, by its unit response."""
    step = transitions(np.array([2.0 * np.pi * relative]), damping)[0]
    phi, now, ahead = step[:, :2], step[:, 2], step[:, 3]
    one, two = float(-np.trace(phi)), float(np.linalg.det(phi))
    seen = np.array([-1.0, -2.0 * damping])
    states = [ahead, phi @ ahead + now, phi @ (phi @ ahead + now)]
    first, second, third = (float(seen @ state) for state in states)
    return {
        "β0": first,
        "β1": second + one * first,
        "β2": third + one * second + two * first,
        "α1": one,
        "α2": two,
    }


FUNCTIONS: Final = (
    ("m/s^2", "N", "accelerance"), ("m/s", "N", "mobility"), ("m", "N", "receptance"),
    ("N", "m/s^2", "apparent mass"), ("N", "m/s", "impedance"), ("N", "m", "dynamic stiffness"),
)  # fmt: skip


def functions() -> Iterator[Check]:
    """Yield the names of the response functions."""
    for output, over, name in FUNCTIONS:
        quantity = f"name of a function in {output} over {over}"
        yield Check("ISO 7626-1:2011", "table 1", quantity, "", name, NAMES[(output, over)])


UNITS: Final = (
    ("ISO 16063-1:1998", "standard acceleration", "1 g", "m/s^2", 9.80665),
    ("ISO 16063-1:1998", "sensitivity", "100 mV/g", "V/(m/s^2)", 0.1 / 9.80665),
    ("ISO 16063-1:1998", "sensitivity", "10 pC/g", "C/(m/s^2)", 1e-11 / 9.80665),
    ("ISO 16063-1:1998", "density", "1 g^2/Hz", "(m/s^2)^2/Hz", 96.1703842225),
    ("NIST SP 811", "appendix B", "1 in", "m", 0.0254),
    ("NIST SP 811", "appendix B", "1 ft", "m", 0.3048),
    ("NIST SP 811", "appendix B", "1 mil", "m", 2.54e-5),
    ("NIST SP 811", "appendix B", "1 in/s", "m/s", 0.0254),
    ("NIST SP 811", "appendix B", "1 lb", "kg", 0.45359237),
    ("NIST SP 811", "appendix B", "1 oz", "kg", 0.028349523125),
    ("NIST SP 811", "appendix B", "1 slug", "kg", 14.593902937206364),
    ("NIST SP 811", "appendix B", "1 lbf", "N", 4.4482216152605),
    ("NIST SP 811", "appendix B", "1 kip", "N", 4448.2216152605),
    ("NIST SP 811", "appendix B", "1 kgf", "N", 9.80665),
    ("NIST SP 811", "appendix B", "1 ozf", "N", 0.27801385095378125),
    ("NIST SP 811", "appendix B", "1 psi", "Pa", 6894.757293168361),
    ("NIST SP 811", "appendix B", "1 lbf in", "N m", 0.1129848290276167),
    ("NIST SP 811", "appendix B", "1 lbf/in", "N/m", 175.12683524647636),
    ("NIST SP 811", "appendix B", "180 deg", "rad", np.pi),
    ("NIST SP 811", "appendix B", "60 rpm", "rad/s", 2.0 * np.pi),
    ("NIST SP 811", "appendix B", "32 degF", "K", 273.15),
    ("ISO 1683:2015", "acceleration re 1 µm/s²", "120 dB re 1e-6 m/s^2", "m/s^2", 1.0),
    ("ISO 1683:2015", "velocity re 1 nm/s", "120 dB re 1e-9 m/s", "m/s", 1e-3),
    ("ISO 1683:2015", "displacement re 1 pm", "120 dB re 1e-12 m", "m", 1e-6),
    ("ISO 1683:2015", "force re 1 µN", "120 dB re 1e-6 N", "N", 1.0),
    ("ISO 1683:2015", "sound pressure re 20 µPa", "94 dB re 20e-6 Pa", "Pa", 1.00237),
)  # fmt: skip


def units() -> Iterator[Check]:
    """Yield conversions to SI and levels over the reference values."""
    for standard, clause, text, unit, wanted in UNITS:
        digits = 5e-6 if wanted == 1.00237 else 1e-12 * wanted
        yield Check(standard, clause, text, unit, wanted, to_si(text, unit), digits)


HARRIS: Final = (
    ("rectangular", 1.00, 1.00, 75.0, 50.0), ("hann", 0.50, 1.50, 65.9, 16.7),
    ("hamming", 0.54, 1.36, 70.7, 23.4), ("blackman", 0.42, 1.73, 56.7, 9.0),
    ("blackman-harris", 0.36, 2.00, 46.0, 3.8),
)  # fmt: skip
"""Coherent gain [-], noise bandwidth [bins], correlation at 75 and 50 % overlap [%]; of hamming
the table prints 23.5, and the integral of its cosines is 23.377."""


def windows() -> Iterator[Check]:
    """Yield gain, noise bandwidth and overlap correlation of the windows."""
    n, table = 4096, "Harris (1978)"
    for name, gain, bandwidth, most, half in HARRIS:
        window = spectra.window_samples(f"periodic {name}", n)
        yield Check(
            table, "table I", f"coherent gain, {name}", "1", gain, float(window.mean()), 0.005
        )
        yield _bandwidth(table, name, bandwidth)
        for share, wanted in ((0.75, most), (0.5, half)):
            step = round(n * (1.0 - share))
            correlation = np.sqrt(2.0 / spectra.effective_averages(window, step, 2) - 1.0)
            name_of = f"correlation at {100 * share:.0f} % overlap, {name}"
            clause = "closed form" if wanted == 23.4 else "table I"
            yield Check(table, clause, name_of, "%", wanted, 100.0 * float(correlation), 0.06)
    yield _bandwidth("MATLAB, flattopwin", "flat top", 3.77)


def _bandwidth(standard: str, name: str, wanted: float) -> Check:
    rows = np.zeros((1, 4096))
    rows[0, 7] = 1.0
    cross = spectra.cross_spectra(
        [rows], 4096.0, segment=4096, overlap=0, window=f"periodic {name}"
    )
    found = cross.resolution / cross.bin_width
    clause = "table I" if standard.startswith("Harris") else "noise bandwidth"
    return Check(standard, clause, f"noise bandwidth, {name}", "bins", wanted, found, 0.006)


CHI_SQUARE: Final = ((10, 3.25, 20.48), (20, 9.59, 34.17), (40, 24.43, 59.34))
"""Degrees of freedom, and the values that 97.5 and 2.5 % exceed."""


def confidence() -> Iterator[Check]:
    """Yield the limits of a density that chi-square's table gives."""
    for freedom, least, most in CHI_SQUARE:
        rows = np.random.default_rng(0).standard_normal((1, 32 * freedom))
        cross = spectra.cross_spectra([rows], 1.0, segment=64, overlap=0, window="rectangular")
        bounds, density = spectra.psd_bounds(cross), spectra.psd(cross)
        for name, limit, wanted in (("lower", bounds.low, most), ("upper", bounds.high, least)):
            found = freedom * float(density[0, 8] / limit[0, 8])
            yield Check(
                "Bendat and Piersol (2010)", "table A.3",
                f"chi-square behind the {name} 95 % limit, {freedom} degrees of freedom", "1",
                wanted, found, 0.006,
            )  # fmt: skip


MIL: Final = "MIL-STD-810G"
PROFILES: Final = (
    (MIL, "514.6 annex C, US highway truck, vertical", 1.04, 0.005,
     ((10, 0.015), (40, 0.015), (500, 0.00015))),
    (MIL, "514.6 annex C, US highway truck, transverse", 0.204, 0.0005,
     ((10, 0.00013), (20, 0.00065), (30, 0.00065), (78, 0.00002), (79, 0.00019),
      (120, 0.00019), (500, 0.00001))),
    (MIL, "514.6 annex C, US highway truck, longitudinal", 0.740, 0.0005,
     ((10, 0.0065), (20, 0.0065), (120, 0.0002), (121, 0.003), (200, 0.003), (240, 0.0015),
      (340, 0.00003), (500, 0.00015))),
    (MIL, "514.6 annex E, general minimum integrity", 7.7, 0.05,
     ((20, 0.04), (1000, 0.04), (2000, 0.01))),
    ("NAVMAT P-9492", "screening", 6.06, 0.005,
     ((20, 0.01), (80, 0.04), (350, 0.04), (2000, 0.007))),
    ("GSFC-STD-7000", "components, qualification", 14.1, 0.05,
     ((20, 0.026), (50, 0.16), (800, 0.16), (2000, 0.026))),
    ("GSFC-STD-7000", "components, acceptance", 10.0, 0.05,
     ((20, 0.013), (50, 0.08), (800, 0.08), (2000, 0.013))),
    ("ASTM D4169", "truck, assurance level I", 0.73, 0.005,
     ((1, 1e-4), (4, 0.02), (16, 0.02), (40, 0.002), (80, 0.002), (200, 2e-5))),
    ("ASTM D4169", "truck, assurance level II", 0.52, 0.005,
     ((1, 5e-5), (4, 0.01), (16, 0.01), (40, 0.001), (80, 0.001), (200, 1e-5))),
)  # fmt: skip
"""Standard, clause, published rms and half its last digit [g], breakpoints [Hz, g²/Hz]."""


def profiles() -> Iterator[Check]:
    """Yield the rms of published profiles."""
    for standard, clause, wanted, digit, points in PROFILES:
        frequency, density = np.array(points, dtype=np.float64).T
        yield Check(
            standard, clause, "rms of the profile", "g", wanted,
            profile_rms(frequency, density), digit,
        )  # fmt: skip


FREQUENCIES: Final = (
    (0.2, 0.05), (1.0, 0.2), (4.0, 0.8), (10.0, 1.0), (40.0, 1.0), (100.0, 2.0), (500.0, 10.0)
)  # fmt: skip
"""Frequency and how far it may be off [Hz]."""
SWEEPS: Final = (
    (1, 35, 5.13), (10, 55, 2.46), (10, 150, 3.91), (10, 500, 5.64), (10, 2000, 7.64),
    (55, 500, 3.18),
)  # fmt: skip
"""From where to where [Hz], and how many octaves that is."""


def tolerances() -> Iterator[Check]:
    """Yield what a test may be off before it is flagged, and how long a sweep lasts."""
    iec = "IEC 60068-2-6:2007"
    for frequency, wanted in FREQUENCIES:
        yield Check(
            iec, f"4.1.3 ({MEMORY})", f"tolerance of a frequency of {frequency:g} Hz, ±", "Hz",
            wanted, frequency_tolerance(frequency),
        )  # fmt: skip
    sine = Test(1, excitation="sine", level=1.0, level_unit="m/s^2")
    noise = Test(1, excitation="random", level=1.0, level_unit="(m/s^2)^2/Hz")
    for sign, name in ((1.0, "above"), (-1.0, "below")):
        found = 100.0 * _largest(sine, "amplitude", sign, lambda off: 1.0 + off)
        yield Check(
            iec, f"4.1.4 ({MEMORY})", f"amplitude that is kept, {name} the demand", "%",
            sign * 15.0, found, 1e-6,
        )  # fmt: skip
        found = 10.0 * _largest(noise, "density", sign, lambda off: 10.0**off)
        yield Check(
            "IEC 60068-2-64:2008, MIL-STD-810", f"random, ±3 dB ({MEMORY})",
            f"density that is kept, {name} the demand", "dB", sign * 3.0, found, 1e-6,
        )  # fmt: skip
    abort = Processing().tolerance.abort
    yield Check(
        "usual practice of controllers", "abort", "abort limit without a word of the log, ±",
        "dB", 6.0, abort,
    )  # fmt: skip
    for low, high, octave in SWEEPS:
        swept = Test(
            1,
            excitation="sine sweep",
            from_hz=float(low),
            to_hz=float(high),
            rate_oct_per_min=1.0,
        )
        lasts = (nominal_duration(swept) or 0.0) / 60.0
        name = f"octaves of a sweep from {low} to {high} Hz, by its duration at 1 oct/min"
        yield Check(iec, "number of octaves", name, "oct", octave, lasts, 0.005)


def _largest(
    test: Test, kind: LevelKind, sign: float, level: Callable[[float], float]
) -> float:
    """Return the largest departure either way that is not flagged, by bisection."""
    kept, flagged = 0.0, 0.9 * sign
    for _ in range(60):
        middle = 0.5 * (kept + flagged)
        if levels.mismatch(test, Level(kind, level(middle), "m/s^2")):
            flagged = middle
        else:
            kept = middle
    return kept


def definitions() -> Iterator[Check]:
    """Yield what a sine and a resonance have by definition."""
    sine = 3.0 * np.sin(2.0 * np.pi * np.arange(10_000) / 100.0)[np.newaxis]
    found = spectra.statistics([sine])
    iso = "ISO 2041:2018"
    for name, wanted, value in (
        ("rms of a sine of amplitude 3", 3.0 / np.sqrt(2.0), found.rms[0]),
        ("crest factor of a sine", np.sqrt(2.0), found.crest_factor[0]),
        ("largest value of a sine of amplitude 3", 3.0, found.maximum[0]),
    ):
        yield Check(iso, "definition", name, "1", float(wanted), float(value), 1e-9)
    read = spectra.Damping(100.0, None, None, 0.05, None, None, None, None, 1.0)
    yield Check(
        iso, "definition", "Q of a damping ratio of 5 %", "1", 10.0, read.quality_factor or 0.0
    )
    f = np.linspace(0.0, 400.0, 400_001)
    power = 1.0 / ((1.0 - (f / 200.0) ** 2) ** 2 + (2.0 * 0.01 * f / 200.0) ** 2)
    ratio = spectra.half_power_ratio(f, power, int(power.argmax()))
    yield Check(
        iso, "half-power bandwidth", "damping ratio of a resonance of 1 %", "%", 1.0,
        100.0 * (ratio or (0.0, 0.0))[0], 1e-3,
    )  # fmt: skip


def budgets() -> Iterator[Check]:
    """Yield the example of the guide, and its rule for limits."""
    gum = "JCGM 100:2008"
    lines = (
        normal("calibration", 75.0, 3.0, ""),
        *(normal("random", u, 1.0, "") for u in (9.7, 2.9, 16.6)),
    )
    gauge = Budget("gauge", "length", None, 50.0, "nm", lines)
    yield Check(
        gum,
        "H.1, table H.1",
        "combined standard uncertainty of the end gauge",
        "nm",
        32.0,
        gauge.standard() or 0.0,
        0.5,
    )
    yield Check(
        gum,
        "H.1.3.1",
        "standard uncertainty of a certificate of 75 nm, k = 3",
        "nm",
        25.0,
        lines[0].standard or 0.0,
    )
    for clause, half, wanted, digit in (
        ("H.1.3.3", 2.0, 1.2, 0.05),
        ("H.1.3.5", 1.0, 0.58, 0.005),
        ("H.1.3.6", 0.05, 0.029, 5e-4),
    ):
        name = f"standard uncertainty of limits ±{half:g}"
        yield Check(
            gum,
            clause,
            name,
            "1",
            wanted,
            rectangular("noise", half, "").standard or 0.0,
            digit,
        )


SECTIONS: Final = {
    "Octave bands: IEC 61260-1": octaves,
    "Shock response spectra: ISO 18431-4": shocks,
    "Cycle counting: ASTM E1049": cycles,
    "Response functions: ISO 7626-1": functions,
    "Units and reference values: ISO 16063, ISO 1683, NIST SP 811": units,
    "Windows: Harris": windows,
    "Confidence of densities: chi-square": confidence,
    "Profiles: MIL-STD-810 and others": profiles,
    "Tolerances and sweeps: IEC 60068-2, MIL-STD-810": tolerances,
    "Definitions: ISO 2041": definitions,
    "Uncertainty: JCGM 100 (GUM)": budgets,
}
INTRODUCTION: Final = """\
# Conformance to standards

Made by `python docs/make_conformance.py`; a test of CI makes it anew, compares, and fails where
a line does not pass.

Each line is a number that a standard or a published table defines, beside what the code that
processes recordings finds. The tolerance is half the last digit that the standard prints, or
what it allows; limits are marked *within*. Differences below 1e-9 of a number are shown as 0.

The texts of the standards were not at hand when this page was made: their numbers are quoted
from knowledge. Behind them stand: for IEC 61260-1 its formulas and the mask as public programs
have them; for ISO 18431-4 the recursion of Smallwood (1981); for ASTM E1049 its example, which
public programs test with; for units exact definitions; for windows and chi-square closed forms
(of Hamming's window at 50 % overlap the table prints 23.5, its integral is 23.377); for
profiles the agreement of breakpoints and printed rms, which a slip in either would spoil. Where
nothing but memory stands behind a number, its clause says *from memory*.
"""
NOT_CHECKED: Final = """\
## Not checked, for the program does not compute it

Level crossing, peak and simple-range counting (ASTM E1049, 5.1 to 5.3); frequency weightings of
human vibration (ISO 2631, ISO 5349); filters of class 2. The ±10 % of a sine in MIL-STD-810 are
no default here: amplitudes are judged by the 15 % of IEC 60068-2-6, and a profile may state its
own alarm in dB.
"""
HEADER: Final = (
    "no.", "standard", "clause", "quantity", "unit", "standard says", "shakerproc",
    "difference", "tolerance", "passed",
)  # fmt: skip


def checks() -> dict[str, list[Check]]:
    """Return every check by its section."""
    return {title: list(made()) for title, made in SECTIONS.items()}


def shown(value: float | str | tuple[float, float] | None) -> str:
    """Return a number with six digits, limits or a name."""
    if value is None:
        return ""
    if isinstance(value, tuple):
        return (
            f"{value[0]:g} or more" if np.isinf(value[1]) else f"{value[0]:g} to {value[1]:g}"
        )
    return value if isinstance(value, str) else f"{value + 0.0:.6g}"


def page() -> str:
    """Return the whole page."""
    found = checks()
    every = list(chain.from_iterable(found.values()))
    passed = sum(check.passed for check in every)
    parts = [INTRODUCTION, f"Of {len(every)} checks {passed} pass.\n"]
    number = 0
    for title, made in found.items():
        parts.append(f"## {title}\n")
        rows = [f"| {' | '.join(HEADER)} |", "|---" * len(HEADER) + "|"]
        for check in made:
            number += 1
            rows.append(f"| {number} | {' | '.join(cells(check))} |")
        parts.append("\n".join(rows) + "\n")
    return "\n".join([*parts, NOT_CHECKED])


def cells(check: Check) -> list[str]:
    """Return the cells of a line but its number."""
    off = check.difference
    small = off is not None and abs(off) < 1e-9 * max(abs(check.scale), 1e-30)
    limits = isinstance(check.wanted, tuple)
    told = "" if off is None else "0" if small else f"{off:.2g}"
    tolerance = "within" if limits else shown(check.tolerance)
    if off is None or check.tolerance <= 1e-9 * abs(check.scale):
        tolerance = "exact"
    return [
        check.standard, check.clause, check.quantity, check.unit, shown(check.wanted),
        shown(check.found), told, tolerance, "yes" if check.passed else "NO",
    ]  # fmt: skip


def main() -> None:
    """Write the page, or with --check say whether it is up to date."""
    text = page()
    if "--check" not in sys.argv:
        PAGE.write_text(text, encoding="utf-8")
    elif PAGE.read_text(encoding="utf-8") != text:
        sys.exit("docs/conformance.md is not current; run python docs/make_conformance.py")


if __name__ == "__main__":
    main()
