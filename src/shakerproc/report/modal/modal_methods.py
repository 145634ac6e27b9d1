"""How modes were found, in words, with references, at the end of their report."""

import importlib.metadata
import platform
from typing import Final

from shakerproc.modal.analysis import ModalAnalysis
from shakerproc.report.page.methods import Methods

_WITH_INPUT: Final = (
    "Candidates are the poles that stay in place over the orders of a least-squares complex "
    "frequency fit (Peeters et al., 2004) of the discrete Fourier transforms of inputs and "
    "responses over the whole record, its transient taken up by terms of its own, so that no "
    "window smears the peaks. Modes are those that Schwarz' criterion needs; poles, residues, "
    "transients and residual terms are refined by maximum likelihood. Their 95 % intervals "
    "come from the scatter of the lines about the model (White), which holds for noise that is "
    "coloured or shared by the sensors, not for what drifts from test to test: that is the "
    "scatter over tests."
)
_OUTPUT_ONLY: Final = (
    "Where no input was measured, poles come from covariance-driven stochastic subspace "
    "identification (Peeters and De Roeck, 1999) over orders; intervals from leaving out one "
    "of twelve blocks at a time. Their scatter also tells how much of the imaginary parts of a "
    "shape is chance, and they are shrunk by that share (Efron and Morris, 1973). The "
    "excitation is taken for broadband."
)
_REFERENCES: Final = (
    "B. Peeters, H. Van der Auweraer, P. Guillaume and J. Leuridan, The PolyMAX "
    "frequency-domain method, Shock and Vibration 11, 395-409, 2004.",
    "M. El-Kafafy, P. Guillaume and B. Peeters, Modal parameter estimation by combining "
    "stochastic and deterministic frequency-domain approaches, Mechanical Systems and Signal "
    "Processing 35, 52-68, 2013.",
    "R. Pintelon and J. Schoukens, System Identification: A Frequency Domain Approach, 2nd "
    "ed., Wiley, 2012.",
    "B. Peeters and G. De Roeck, Reference-based stochastic subspace identification for "
    "output-only modal analysis, Mechanical Systems and Signal Processing 13, 855-878, 1999.",
    "B. Efron and C. Morris, Stein's estimation rule and its competitors: an empirical Bayes "
    "approach, Journal of the American Statistical Association 68, 117-130, 1973.",
    "R. J. Allemang, The modal assurance criterion, Sound and Vibration 37, 14-23, 2003.",
)


def methods_of(analysis: ModalAnalysis) -> Methods:
    """Return the methods of an analysis, those that it took."""
    output_only = any(one.modes.model is None for one in analysis.tests)
    with_input = any(one.modes.model is not None for one in analysis.tests)
    names = ("numpy", "scipy")
    packages = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in names)
    return Methods(
        [*([_WITH_INPUT] if with_input else []), *([_OUTPUT_ONLY] if output_only else [])],
        _REFERENCES,
        f"{packages}, Python {platform.python_version()} on {platform.system()}",
    )
