"""What was done, in words, with references: collected from the runs."""

import importlib.metadata
from collections.abc import Sequence
from dataclasses import dataclass

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
    "cropped samples, one-sided; their bounds follow from the effective number of averages of "
    "overlapping segments [1, 2]. H1 is the cross spectrum with the mean control signal over "
    "that signal's density, coherence the share of the response that follows it linearly [2]. "
    "Values outside the excited band are drawn but never judged."
)
_PEAKS = (
    "ω_e is the frequency of the tallest peak of a response's density inside the excited "
    "band, interpolated between bins. Natural frequency and damping are a least-squares fit of "
    "one mode to H1 with the leakage of the window in it; the damping is withheld where its "
    "95 % interval is wider than 4 % to each side or the peak has not the shape of one linear "
    "mode."
)
_SWEEP = (
    "The Welch density of a sine sweep depends on its rate and on the crop: compare sweeps of "
    "one rate only [3]. The swept response follows the fundamental instead."
)
_UNITS = "1 g is 9.80665 m/s² (ISO 80000-3); terms after ISO 2041, tests after IEC 60068-2."
_REFERENCES = (
    "P. D. Welch, The use of fast Fourier transform for the estimation of power spectra, IEEE "
    "Transactions on Audio and Electroacoustics 15, 70-73, 1967.",
    "J. S. Bendat and A. G. Piersol, Random Data, 4th ed., Wiley, 2010, chapters 6, 8, 9, 11.",
    "IEC 60068-2-6, Vibration (sinusoidal), and IEC 60068-2-64, Vibration, broadband random.",
)


def methods_of(runs: Sequence[RunSummary]) -> Methods:
    """Return the methods that these runs used."""
    swept = any("sweep" in str(run.facts.get("excitation", "")) for run in runs)
    paragraphs = [_SPECTRA, _PEAKS, *([_SWEEP] if swept else []), _UNITS]
    names = ("numpy", "scipy", "nptdms")
    packages = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in names)
    return Methods(paragraphs, _REFERENCES if swept else _REFERENCES[:2], packages)
