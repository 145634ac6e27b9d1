"""Methods of the runs in words, with references."""

import importlib.metadata
import inspect
import platform
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from shakerproc.runs.summary import RunSummary


@dataclass(frozen=True, slots=True)
class Methods:
    """Text for the report.

    Attributes
    ----------
    paragraphs, references : sequence of str
        What was done and where it is written.
    packages : str
        Versions of the packages that computed.
    """

    paragraphs: Sequence[str]
    references: Sequence[str]
    packages: str


_SPECTRA = (
    "Power spectral densities and cross spectra are Welch averages [1] of one pass over the "
    "cropped samples, one-sided. Their bounds follow from the effective number of averages of "
    "overlapping segments [1, 2]. H1 is the cross spectrum with the mean control signal over "
    "that signal's density, coherence the share of the response that follows it linearly [2]. "
    "Values outside the excited band are drawn but never judged."
)
_PEAKS = (
    "The peak frequency is that of the tallest peak of a response's density inside the excited "
    "band, interpolated between bins. A peak is listed where it stands out of its saddles by "
    "more than chance makes in the whole band, with a probability of 95 %. Natural frequency "
    "and damping are a least-squares fit of the mode, its neighbours and a straight background "
    "to H1, with leakage. Intervals follow from the covariance of "
    "smeared spectra, widened where the fit is worse than chance. The damping is withheld "
    "where its 95 % interval is wider than 4 % to each side or no linear modes fit the peak."
)
_SWEEP = (
    "The Welch density of a sine sweep depends on its rate and on the crop: compare sweeps of "
    "one rate only [3]. The swept response follows the fundamental instead. The response to a "
    "slow sweep comes from a fit of a mode that is passed at the sweep's rate (F. M. Lewis, "
    "1932)."
)
_UNITS = "1 g is 9.80665 m/s² (ISO 80000-3); terms after ISO 2041, tests after IEC 60068-2."
_REFERENCES = (
    "P. D. Welch, The use of fast Fourier transform for the estimation of power spectra, IEEE "
    "Transactions on Audio and Electroacoustics 15, 70-73, 1967.",
    "J. S. Bendat and A. G. Piersol, Random Data, 4th ed., Wiley, 2010, chapters 6, 8, 9, 11.",
    "IEC 60068-2-6, Vibration (sinusoidal), and IEC 60068-2-64, Vibration, broadband random.",
)


_ANALYSES: Final[Mapping[str, tuple[str, str]]] = {
    "forecast": (
        "Parameters of the model are fitted to all tests that are not held out. They are drawn "
        "from their covariance for each simulated test, with calibration and phases. The model "
        "error is the miss of measured levels predicted from lower ones, beyond the "
        "uncertainty of the parameters. It grows with the distance in decibels and follows "
        "Student's law. Responses are freed from the error of the nearest level. Largest "
        "values of longer durations follow Gumbel's. Notches clip the mean square that each "
        "octave of the drive gives to a limited quantity.",
        "A. G. Davenport, Note on the distribution of the largest value of a random function "
        "with application to gust loading, Proceedings of the Institution of Civil Engineers "
        "28, 187-196, 1964.",
    ),
    "profile": (
        "A profile is straight between its breakpoints where level and frequency are "
        "logarithmic. The mean control is compared with every alarm and abort line. An abort "
        "line is kept where no value lies beyond it by more than chance, an alarm line where "
        "5 % do at most.",
        "IEC 60068-2-64, Vibration, broadband random.",
    ),
    "shock": (
        "Shock response spectra are the largest values of oscillators that start from rest, "
        "solved exactly for an acceleration that is straight between samples. Residual ones "
        "are the closed form of the decay after the last sample.",
        "ISO 18431-4:2007, Signal processing, shock-response spectrum analysis.",
    ),
    "octaves": (
        "Octave bands are the root mean squares of what passes Butterworth filters of fourth "
        "order to each side, within the limits of class 1.",
        "IEC 61260-1:2014, Octave-band and fractional-octave-band filters.",
    ),
    "blows": (
        "A blow begins where the force reaches the trigger. A block is not used if it holds a "
        "second pulse, clipped samples, no response or the end of the recording. Spectra are "
        "averages over the other blocks, without overlap; an "
        "exponential window is put on force and responses alike.",
        "ISO 7626-5:2019, Mechanical mobility, measurements using impact excitation.",
    ),
    "resonances": (
        "Natural frequency and damping are those of modes fitted to H1 around each peak. The "
        "decay of an exponential window is part of the fit, and is subtracted.",
        "W. G. Halvorsen and D. L. Brown, Impulse technique for structural frequency response "
        "testing, Sound and Vibration 11 (11), 8-21, 1977.",
    ),
    "driving_point": (
        "Where a force and a sensor sit in one place, a passive structure takes power in at "
        "every frequency. The real part of the cross spectrum of force and velocity is then "
        "positive.",
        "D. J. Ewins, Modal Testing, 2nd ed., Research Studies Press, 2000.",
    ),
    "decays": (
        "After the input rests, each mode is isolated by a filter that looks ahead only. It is "
        "read over stretches in which it falls to 70 %. Two methods do so: least squares of a "
        "decaying sinusoid on its envelope, and peaks and zero crossings.",
        "M. Jin, W. Chen, M. R. W. Brake and H. Song, Identification of instantaneous "
        "frequency and damping from transient decay data, J. Vib. Acoust. 142, 051111, 2020.",
    ),
    "multisine": (
        "Of a multisine, whole periods are transformed, after the first ones that do not yet "
        "repeat. The best linear approximation is the mean over realisations of response over "
        "input at the excited lines. Noise is the part that does not repeat. Even and odd "
        "distortion are the power of lines that are not excited. Scatter is the difference "
        "between realisations.",
        "R. Pintelon and J. Schoukens, System Identification: A Frequency Domain Approach, "
        "2nd ed., Wiley, 2012, chapter 4.",
    ),
    "integration": (
        "Velocity and displacement are acceleration over iω and its square, the baseline of "
        "the run taken out, with a high-pass 1/(1 + (f_c/f)⁸) without phase shift. Without a "
        "high-pass, straight lines between samples are integrated from rest.",
        "",
    ),
    "distribution": (
        "Probability densities are counts of samples in intervals of equal width over their "
        "number and width. Exceedance is the share of samples at or above a level.",
        "",
    ),
    "orders": (
        "The angle of the shaft is a cubic spline through the rising edges of the tachometer. "
        "All orders and an offset are fitted together to the samples of so many revolutions, "
        "with Hann weights.",
        "J. R. Blough, Development and analysis of time variant discrete Fourier transform "
        "order tracking, Mechanical Systems and Signal Processing 17, 1185-1199, 2003.",
    ),
    "tones": (
        "Tones of a sine on random are fitted by least squares in segments of the run. Their "
        "frequency is that at which the readings of the mean control add up to most. They are "
        "subtracted from the samples before densities and response functions.",
        "",
    ),
    "dwell": (
        "Of a dwell, frequency, gain and phase are those of the sine that fits control and "
        "responses best in each stretch (four-parameter sine fit).",
        "IEEE Std 1057, Digitizing waveform recorders.",
    ),
    "waterfall": (
        "A waterfall is of spectra with a Hann window in stretches of equal time, scaled so "
        "that a sine reads its amplitude.",
        "",
    ),
    "spectrogram": (
        "A spectrogram is the density of segments with a Hann window, the mean of those that "
        "begin in one stretch of time.",
        "",
    ),
    "splitting": (
        "A shock is a short stretch whose peak stands out of the rms of the vibration around "
        "it, the median of 10 s. The rest is split where the level changes, by least squares. "
        "A part is stationary where 20 of its mean squares have no trend (reverse "
        "arrangements, 1 %).",
        "J. S. Bendat and A. G. Piersol, Random Data, 4th ed., Wiley, 2010, section 4.5.2.",
    ),
    "fatigue": (
        "A vibration response spectrum is the root mean square of oscillators on the place of "
        "a sensor. A fatigue damage spectrum adds up the amplitudes of their pseudo-velocity, "
        "counted by rainflow, to the exponent of the S-N curve.",
        "ASTM E1049-85, Standard practices for cycle counting in fatigue analysis.",
    ),
    "uncertainty": (
        "An uncertainty budget holds what the calibration sheet, the bins, chance and noise do "
        "to a number, each as a standard uncertainty. Their root sum of squares times k = 2 is "
        "its expanded uncertainty.",
        "JCGM 100:2008, Evaluation of measurement data - Guide to the expression of "
        "uncertainty in measurement.",
    ),
}
"""What each further analysis did, and where it is written."""


_COMPARED = (
    "A model is driven by the measured input and its joints are integrated exactly between "
    "samples. Its free-run error is the rms of measured less simulated over the rms measured, "
    "within the band that the log states for the test. Where a disturbance of the motion "
    "grows more than 1e4 times, it is taken in windows whose starts are fitted. Its floor is "
    "the error that measurement noise causes. That noise is estimated from the quiet before "
    "or after the test, repeated tests, controls that disagree, or the band above the "
    "excitation. "
    "The force in a joint is what moves the masses beyond it, over its measured motion (Masri "
    "and Caughey)."
)
_DIAGNOSED = (
    "A diagnosis screens every effect of the library in every joint by regression on the "
    "measured motion. It fits the likely ones, and the others where none of these explains the "
    "tests. Each is fitted together with the model's own parameters and the measurement chain, "
    "by least squares to free-run simulations (Moré). Effects are ranked by how well they "
    "predict data that took no part in any fit. Intervals are 95 %, from the scatter between "
    "parts of the tests (Cameron and Miller) and the calibration of the channels."
)
_LEAST_SQUARES = (
    "J. J. Moré, The Levenberg-Marquardt algorithm: implementation and theory, Lecture Notes "
    "in Mathematics 630, Springer, 1978.",
    "A. C. Cameron and D. L. Miller, A practitioner's guide to cluster-robust inference, "
    "Journal of Human Resources 50, 317-372, 2015.",
)
_MASRI = (
    "S. F. Masri and T. K. Caughey, A nonparametric identification technique for nonlinear "
    "dynamic problems, Journal of Applied Mechanics 46, 433-447, 1979."
)


def methods_of(
    runs: Sequence[RunSummary],
    *,
    compared: bool = False,
    diagnosed: bool = False,
    analyses: Sequence[str] = (),
    kinds: Sequence[str] = (),
) -> Methods:
    """Return the methods that were used.

    Parameters
    ----------
    runs : sequence of RunSummary
        Runs that were processed.
    compared, diagnosed : bool
        Whether a model was compared with the tests, and whether an effect was sought.
    analyses : sequence of str
        Kinds of further analyses besides those of the runs.
    kinds : sequence of str
        Effects of the models; each brings its own references.
    """
    swept = any("sweep" in str(run.facts.get("excitation", "")) for run in runs)
    paragraphs = [_SPECTRA, _PEAKS, *([_SWEEP] if swept else [])]
    references = list(_REFERENCES if swept else _REFERENCES[:2])
    if not runs and (compared or diagnosed or analyses):
        paragraphs, references = [], [_REFERENCES[1]]
    shown = ["spectrogram"] if any(run.surface for run in runs) else []
    of_runs = [one.kind for run in runs for one in run.analyses]
    asked = dict.fromkeys([*of_runs, *shown, *analyses])
    methods = [_ANALYSES[kind] for kind in asked if kind in _ANALYSES]
    paragraphs += [text for text, _ in methods]
    references += [source for _, source in methods if source]
    if compared:
        paragraphs.append(_COMPARED)
        references.append(_MASRI)
    if diagnosed:
        paragraphs.append(_DIAGNOSED)
        references += _LEAST_SQUARES
    references += [text for kind in kinds for text in references_of(kind)]
    names = ("numpy", "scipy", "nptdms")
    python = f"Python {platform.python_version()} on {platform.system()}"
    packages = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in names)
    told = f"{packages}, {python}"
    return Methods([*paragraphs, _UNITS], tuple(dict.fromkeys(references)), told)


def references_of(kind: str) -> list[str]:
    """Return the references of an effect or a fault, from its own description."""
    from shakerproc.models import EFFECTS  # most reports name none: late
    from shakerproc.models.faults import FAULTS

    made = EFFECTS.get(kind) or FAULTS.get(kind)
    text = inspect.getdoc(made) or ""
    listed = text.partition("References\n----------")[2]
    parts = re.split(r"^\.\. \[\d+\]", listed, flags=re.MULTILINE)[1:]
    return [" ".join(part.replace('"', "").replace("`", "").split()) for part in parts]
