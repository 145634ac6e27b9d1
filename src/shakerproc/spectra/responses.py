"""Response functions and coherence of a run, and what chance makes of them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, TypeVar, cast, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.numerals import numeral
from shakerproc.spectra.welch.cross import CrossSpectra, psd

NOTCH_BINS: Final = 3.0
"""Bins to both sides of a notch that the window smears it over."""

AUDIBLE: Final = 1e-4
"""Share of the largest density of the input in the band below which a bin is not excited [-]:
40 dB below, where the side lobes of a Hamming window (-43 dB) carry what leaks."""


def excited(
    frequency: FloatArray,
    band: tuple[float, float],
    *,
    notches: Sequence[float] = (),
    half_width: float = 1.0,
) -> NDArray[np.bool_]:
    """Return which frequencies the excitation reaches and no notch has emptied.

    Parameters
    ----------
    frequency : (n_frequencies,) array
        Equally spaced frequencies [Hz].
    band : (float, float)
        Lower and upper limit of the excitation [Hz].
    notches : sequence of float
        Frequencies of notch filters [Hz].
    half_width : float
        Half the width of a notch [Hz]; three bins are added for the window.

    Returns
    -------
    (n_frequencies,) array of bool
        True where a response function means something.
    """
    keep = (frequency >= band[0]) & (frequency <= band[1])
    reach = half_width + NOTCH_BINS * (frequency[1] - frequency[0])
    for notch in notches:
        keep &= np.abs(frequency - notch) > reach
    return keep


def audible(
    frequency: FloatArray, density: FloatArray, band: tuple[float, float]
) -> NDArray[np.bool_]:
    """Return which frequencies, inside the band or not, have an input to divide by.

    Parameters
    ----------
    frequency : (n_frequencies,) array
        Equally spaced frequencies [Hz].
    density : (n_frequencies,) array
        Of the input, such as that of the mean control [unit²/Hz].
    band : (float, float)
        Lower and upper limit of the excitation [Hz].

    Returns
    -------
    (n_frequencies,) array of bool
        True where the density exceeds `AUDIBLE` of its largest value in the band; nowhere
        where there is none.
    """
    largest = density[excited(frequency, band)].max(initial=0.0)
    return np.array((largest > 0.0) & (density > AUDIBLE * largest))


def driven(
    frequency: FloatArray, density: FloatArray, band: tuple[float, float]
) -> NDArray[np.bool_]:
    """Return where `audible` holds within the excited band, (n_frequencies,) array of bool.

    Parameters
    ----------
    frequency, density, band
        As of `audible` [Hz], [unit²/Hz], [Hz].
    """
    return np.array(excited(frequency, band) & audible(frequency, density, band))


def masked(values: FloatArray, keep: NDArray[np.bool_]) -> FloatArray:
    """Return values, those that are not kept replaced by not-a-number.

    Parameters
    ----------
    values : (..., n_frequencies) array
        Real or complex values [any unit].
    keep : (n_frequencies,) array of bool
        What is kept.

    Returns
    -------
    (..., n_frequencies) array
        New array of the same kind.
    """
    return np.where(keep, values, np.nan)


Values = TypeVar("Values", FloatArray, ComplexArray)

SAME_MOTION: Final = 1e-10
"""Share of the power in a motion of the controls below which it is taken for rounding."""

INTEGRATIONS: Final = {"m/s^2": 1, "m/s": 0, "m": -1, "rad/s^2": 1, "rad/s": 0, "rad": -1}
"""How often a motion of a unit is integrated to a velocity."""


def h1(
    spectra: CrossSpectra, controls: Sequence[int], responses: Sequence[int]
) -> ComplexArray:
    r"""Return the response functions that noise on the responses does not bias.

    .. math:: H_1 = S_{xy} / S_{xx}

    with the mean of the control signals as :math:`x`.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.
    controls, responses : sequence of int
        Rows of the control and of the response channels, from 0.

    Returns
    -------
    (n_responses, n_frequencies) complex array
        Response over control [-]; not a number where the control has no power.

    References
    ----------
    .. [1] J. S. Bendat and A. G. Piersol, "Random Data", 4th ed., Wiley, 2010, ch. 6.
    """
    control, cross, _ = _against_mean(spectra, controls, responses)
    return _ratio(cross, control)


def h2(
    spectra: CrossSpectra, controls: Sequence[int], responses: Sequence[int]
) -> ComplexArray:
    r"""Return the response functions that noise on the controls does not bias.

    .. math:: H_2 = S_{yy} / S_{yx}

    Parameters and result are those of `h1`.
    """
    _, cross, response = _against_mean(spectra, controls, responses)
    return _ratio(response.astype(np.complex128), cross.conj())


def hv(
    spectra: CrossSpectra, controls: Sequence[int], responses: Sequence[int]
) -> ComplexArray:
    r"""Return the response functions that noise of equal share on both sides does not bias.

    .. math:: |H_v| = \sqrt{S_{yy} / S_{xx}} = \sqrt{|H_1| |H_2|}

    with the phase of :math:`S_{xy}`. Parameters and result are those of `h1`.
    """
    control, cross, response = _against_mean(spectra, controls, responses)
    magnitude: FloatArray = np.sqrt(_ratio(response, control))
    phase: ComplexArray = np.exp(1j * np.angle(cross))
    return magnitude * phase


def h1_of_inputs(
    spectra: CrossSpectra, inputs: Sequence[int], responses: Sequence[int]
) -> ComplexArray:
    r"""Return the response functions to each of several inputs that act at once.

    .. math:: H_1^T = S_{xx}^{+} S_{xy}

    Inputs that move as one (to ten digits) share what they cause: the inverse is a
    pseudo-inverse. It needs at least as many averages as inputs to mean anything.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.
    inputs, responses : sequence of int
        Rows of the inputs and of the response channels, from 0.

    Returns
    -------
    (n_responses, n_inputs, n_frequencies) complex array
        Response over each input [response unit/input unit].

    References
    ----------
    .. [1] J. S. Bendat and A. G. Piersol, "Random Data", 4th ed., Wiley, 2010, ch. 7.
    """
    s_xy, inverse, scale = scaled_inputs(spectra, inputs, responses)
    functions = np.einsum("fij,jrf->rif", inverse, s_xy)
    return np.asarray(functions / scale, dtype=np.complex128)


def psd_ratio(
    spectra: CrossSpectra, controls: Sequence[int], responses: Sequence[int]
) -> FloatArray:
    r"""Return each response PSD over the mean of the control PSDs.

    .. math:: R = S_{yy} \Big/ \frac{1}{n} \sum_i S_{x_i x_i}

    The thesis calls it FRF. It is a squared magnitude and, unlike `h1` and `h2`, is raised
    by noise on the responses and lowered by noise on the controls.

    Parameters are those of `h1`.

    Returns
    -------
    (n_responses, n_frequencies) array
        Ratio [-]; not a number where the controls have no power.
    """
    density = psd(spectra)
    return _ratio(density[list(responses)], density[list(controls)].mean(axis=0))


def coherence(
    spectra: CrossSpectra, controls: Sequence[int], responses: Sequence[int]
) -> FloatArray:
    r"""Return the ordinary coherence with the mean of the control signals.

    .. math:: \gamma^2 = \frac{|S_{xy}|^2}{S_{xx} S_{yy}}

    Parameters are those of `h1`.

    Returns
    -------
    (n_responses, n_frequencies) array
        Magnitude-squared coherence, 0 to 1 [-]; not a number where a signal has no power.
    """
    control, cross, response = _against_mean(spectra, controls, responses)
    return _ratio(np.abs(cross) ** 2, control * response)


def multiple_coherence(
    spectra: CrossSpectra, controls: Sequence[int], responses: Sequence[int]
) -> FloatArray:
    r"""Return the share of each response that all controls together explain linearly.

    .. math:: \gamma_m^2 = \frac{S_{yx} S_{xx}^{+} S_{xy}}{S_{yy}}

    Controls that move as one (to ten digits) count as one: the inverse is a pseudo-inverse.
    It needs at least as many averages as controls to mean anything.

    Parameters are those of `h1`.

    Returns
    -------
    (n_responses, n_frequencies) array
        Multiple coherence, 0 to 1 [-]; not a number where the response has no power.
    """
    s_xy, inverse, _ = scaled_inputs(spectra, controls, responses)
    explained = np.einsum("irf,fij,jrf->rf", s_xy.conj(), inverse, s_xy).real
    return _ratio(explained, psd(spectra)[list(responses)])


def scaled_inputs(
    spectra: CrossSpectra, controls: Sequence[int], responses: Sequence[int]
) -> tuple[ComplexArray, ComplexArray, FloatArray]:
    """Return cross spectra and inverse density of the inputs scaled to 1, and their scale.

    Parameters are those of `h1`.

    Returns
    -------
    s_xy : (n_inputs, n_responses, n_frequencies) complex array
        Of scaled inputs with responses [response unit].
    inverse : (n_frequencies, n_inputs, n_inputs) complex array
        Pseudo-inverse of the density of the scaled inputs [-].
    scale : (n_inputs, n_frequencies) array
        Root of the density of each input, 1 where it has no power [input unit].
    """
    inputs, outputs = list(controls), list(responses)
    scale = np.sqrt(psd(spectra)[inputs])
    scale[scale == 0.0] = 1.0
    s_xx = spectra.between(inputs, inputs) / (scale[:, np.newaxis] * scale)
    s_xy = spectra.between(inputs, outputs) / scale[:, np.newaxis]
    inverse = np.linalg.pinv(np.moveaxis(s_xx, -1, 0), rcond=SAME_MOTION, hermitian=True)
    return s_xy, inverse, scale


def _against_mean(
    spectra: CrossSpectra, controls: Sequence[int], responses: Sequence[int]
) -> tuple[FloatArray, ComplexArray, FloatArray]:
    """Return the spectra of the mean control, of it with the responses, and of these.

    Raises
    ------
    ValueError
        If there is no control.
    """
    inputs, outputs = list(controls), list(responses)
    if not inputs:
        raise ValueError("a response function needs at least one control channel")
    control = spectra.between(inputs, inputs).mean(axis=(0, 1)).real
    cross = spectra.between(inputs, outputs).mean(axis=0)
    return control, cross, psd(spectra)[outputs]


def _ratio(above: Values, below: NDArray[Any]) -> Values:
    """Return the quotient, not a number where there is nothing below."""
    shape = np.broadcast_shapes(above.shape, below.shape)
    result = np.full(shape, np.nan, dtype=np.result_type(above, below))
    np.divide(above, below, out=result, where=below != 0.0)
    return cast("Values", result)


def conditioned(spectra: CrossSpectra, given: Sequence[int]) -> CrossSpectra:
    r"""Return the spectra of all channels without their parts that are linear in some of them.

    .. math:: S_{yz \cdot x} = S_{yz} - S_{yx} S_{xx}^{+} S_{xz}

    With all inputs but one given, H1 of what is left is that of several inputs at once
    (`h1_of_inputs`), and its coherence the partial coherence; H2 and Hv follow in the same way.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.
    given : sequence of int
        Rows of the channels whose effects are taken away, from 0.

    Returns
    -------
    CrossSpectra
        Of the same channels, with an average less for each that is given; 0 for those.

    Raises
    ------
    ValueError
        If there are not more averages than channels that are given, and one.

    References
    ----------
    .. [1] J. S. Bendat and A. G. Piersol, "Random Data", 4th ed., Wiley, 2010, ch. 7.3.
    """
    averages = spectra.effective_averages - len(given)
    if not averages > 1.0:
        raise ValueError(
            f"{numeral(spectra.effective_averages)} averages do not tell {len(given) + 1} "
            "inputs apart"
        )
    s_xy, inverse, _ = scaled_inputs(spectra, given, range(spectra.n_channels))
    gains, rows = np.einsum("fgh,hjf->gjf", inverse, s_xy), list(spectra.inputs)
    residual = spectra.matrix - np.einsum("gif,gjf->ijf", s_xy[:, rows].conj(), gains)
    density = spectra.density - np.einsum("gjf,gjf->jf", s_xy.conj(), gains).real
    residual[[rows.index(i) for i in given]] = 0.0
    residual[:, list(given)] = 0.0
    density[list(given)] = 0.0
    residual[range(len(rows)), rows] = density[rows]
    return replace(spectra, matrix=residual, density=density, effective_averages=averages)


def power_share(
    spectra: CrossSpectra, force: int, response: int, unit: str, band: tuple[float, float]
) -> float:
    r"""Return the power that a force feeds in at a point, net over gross.

    .. math:: \frac{\sum_f \Re S_{Fv}(f)}{\sum_f |\Re S_{Fv}(f)|}

    A passive structure takes power in at every frequency where the velocity :math:`v` is that
    of the point of the force, along it. Where an exponential window of the decay rate
    :math:`\sigma` multiplied both, this holds at :math:`s = \sigma + j\omega`, so that an
    acceleration is divided by that.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.
    force, response : int
        Rows of the force and of the motion.
    unit : str
        Of the motion: ``m/s^2``, ``m/s`` or ``m``.
    band : (float, float)
        Where the force reaches [Hz].

    Returns
    -------
    float
        1 where all power goes in, -1 where one of the two is the wrong way round, about 0
        where the motion is that of another point or late; 0 without any power.

    References
    ----------
    .. [1] D. J. Ewins, "Modal Testing", 2nd ed., Research Studies Press, 2000, ch. 2 and 3.
    """
    inside = excited(spectra.frequency, band) & (spectra.frequency > 0.0)
    s = (spectra.decay_rate or 0.0) + 2j * np.pi * spectra.frequency[inside]
    cross = spectra.between([force], [response])[0, 0, inside]
    power = (cross * s ** -INTEGRATIONS[unit]).real
    gross = float(np.abs(power).sum())
    return float(power.sum()) / gross if gross > 0.0 else 0.0


@final
@dataclass(frozen=True, slots=True, eq=False)
class Bounds:
    """Limits between which the true value lies with a given probability.

    Attributes
    ----------
    low, high : (..., n_frequencies) arrays
        Limits, in the unit of the value.
    """

    low: FloatArray
    high: FloatArray


def psd_bounds(spectra: CrossSpectra, confidence: float = 0.95) -> Bounds:
    r"""Return the confidence limits of every power spectral density.

    .. math:: \frac{\nu \hat S}{\chi^2_{1 - \alpha/2}} \le S \le
              \frac{\nu \hat S}{\chi^2_{\alpha/2}}, \quad \nu = 2 K_e

    with the effective averages :math:`K_e` of the overlapped segments; at 0 and at half the
    sample rate, where a spectrum is real, with half as many degrees of freedom. They hold
    for stationary random signals, not for sweeps.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.
    confidence : float
        Probability that the limits hold the true value, for each bin by itself [-].

    Returns
    -------
    Bounds
        (n_channels, n_frequencies) arrays [unit²/Hz].

    Raises
    ------
    ValueError
        If the confidence does not lie between 0 and 1.

    References
    ----------
    .. [1] J. S. Bendat and A. G. Piersol, "Random Data", 4th ed., Wiley, 2010, ch. 8.
    """
    # at 0 and at half the sample rate a transform is real: half the degrees of freedom
    freedom = np.full(spectra.frequency.size, spectra.degrees_of_freedom)
    freedom[0] /= 2.0
    if spectra.n_fft % 2 == 0:
        freedom[-1] /= 2.0
    tail = _tail(confidence)
    density = psd(spectra)
    return Bounds(
        density * freedom / (2.0 * scipy.special.gammaincinv(freedom / 2.0, 1.0 - tail)),
        density * freedom / (2.0 * scipy.special.gammaincinv(freedom / 2.0, tail)),
    )


def gain_random_error(coherence: FloatArray, n_averages: float) -> FloatArray:
    r"""Return the random error of a measured gain, as a share of the gain.

    .. math:: \varepsilon = \sqrt{\frac{1 - \gamma^2}{2 \gamma^2 (n_d - 1)}}

    It is the random error of the phase [rad] too, as long as it is small. Bendat and Piersol
    have :math:`n_d` below; less 1 it is free of bias when the coherence is measured.

    Parameters
    ----------
    coherence : (..., n_frequencies) array
        Magnitude-squared coherence :math:`\gamma^2`, from 0 to 1 [-].
    n_averages : float
        Number of independent averages :math:`n_d` [-].

    Returns
    -------
    (..., n_frequencies) array
        One standard deviation [-]; infinite where the coherence is 0, and of one average,
        which tells nothing of its error.

    Raises
    ------
    ValueError
        If a coherence lies outside 0 to 1, or `n_averages` is below 1.

    References
    ----------
    .. [1] J. S. Bendat and A. G. Piersol, "Random Data", 4th ed., Wiley, 2010, ch. 9.
    """
    outside = coherence[(coherence < 0.0) | (coherence > 1.0 + 1e-9)]
    if outside.size:
        raise ValueError(f"coherence must lie in 0 to 1, not {outside[0]:g}")
    if n_averages < 1.0 - 1e-9:
        raise ValueError(f"n_averages must be at least 1, not {n_averages:g}")
    if n_averages <= 1.0:
        return np.full_like(coherence, np.inf)
    missing = np.maximum(1.0 - coherence, 0.0)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.array(np.sqrt(missing / (2.0 * coherence * (n_averages - 1.0))))


def response_bounds(
    spectra: CrossSpectra,
    controls: Sequence[int],
    responses: Sequence[int],
    confidence: float = 0.95,
) -> tuple[Bounds, FloatArray]:
    r"""Return the confidence limits of the gain of H1, and how far its phase may be off.

    .. math:: |\hat H| (1 \mp t_{2 n_d - 2} \varepsilon), \quad
              \Delta\varphi = \arcsin \min(1, t_{2 n_d - 2} \varepsilon)

    with :math:`\varepsilon` of `gain_random_error` and Student's :math:`t`.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra, of more than one average.
    controls, responses : sequence of int
        Rows of the control and of the response channels, from 0.
    confidence : float
        Probability that the limits hold the true value, for each bin by itself [-].

    Returns
    -------
    Bounds
        Limits of the gain, (n_responses, n_frequencies) arrays [-].
    (n_responses, n_frequencies) array
        Half the width of the interval of the phase [rad]; pi where it is not known at all.

    Raises
    ------
    ValueError
        If the confidence does not lie between 0 and 1.
    """
    averages = spectra.effective_averages
    if averages <= 1.0:
        unknown = np.full((len(responses), spectra.frequency.size), np.pi)
        return Bounds(np.zeros_like(unknown), np.full_like(unknown, np.inf)), unknown
    student = scipy.special.stdtrit(2.0 * averages - 2.0, 1.0 - _tail(confidence))
    gain = np.abs(h1(spectra, controls, responses))
    error = gain_random_error(coherence(spectra, controls, responses), averages)
    half = student * error
    phase = np.where(half < 1.0, np.arcsin(np.minimum(half, 1.0)), np.pi)
    with np.errstate(invalid="ignore"):
        return Bounds(gain * np.maximum(1.0 - half, 0.0), gain * (1.0 + half)), phase


def _tail(confidence: float) -> float:
    """Return the probability outside one limit.

    Raises
    ------
    ValueError
        If the confidence does not lie between 0 and 1.
    """
    if not 0.0 < confidence < 1.0:
        raise ValueError(f"confidence must lie between 0 and 1, not {confidence:g}")
    return (1.0 - confidence) / 2.0


def mean_square_error(
    density: FloatArray, bin_width: float, duration: float, averages: float
) -> float:
    r"""Return the standard deviation of the mean square of random vibration.

    .. math:: \sigma^2 = \frac{1}{T} \int S^2(f) \, df

    The square of an averaged density is too large by :math:`1/K_e` on average, which is taken
    out. The mean square over its own bandwidth B has then a relative error of
    :math:`1/\sqrt{B T}`.

    Parameters
    ----------
    density : (n_frequencies,) array
        Measured one-sided density within the band [unit²/Hz].
    bin_width : float
        Distance of the frequencies [Hz].
    duration : float
        Length of the run [s].
    averages : float
        Effective averages of the density [-].

    Returns
    -------
    float
        One standard deviation [unit²].

    References
    ----------
    .. [1] J. S. Bendat and A. G. Piersol, "Random Data", 4th ed., Wiley, 2010, ch. 8.
    """
    area = float(np.sum(density**2)) * bin_width / (1.0 + 1.0 / averages)
    return float(np.sqrt(area / duration))


def tallest_bins(
    values: FloatArray, errors: FloatArray, peak: int, level: float
) -> tuple[int, int]:
    r"""Return the first and the last bin that chance does not tell from the tallest.

    .. math:: \ln y_p - \ln y_k \le 2 \sqrt{\varepsilon_p^2 + \varepsilon_k^2}

    The peak ends where it has fallen to the level by more than that.

    Parameters
    ----------
    values : (n_values,) array
        The spectrum [any unit].
    errors : (n_values,) array
        Random error of each value, as a share of it [-].
    peak : int
        Bin of the peak.
    level : float
        Share of the height down to which bins belong to the peak, 1/2 for a density [-].

    Returns
    -------
    int, int
        Bins; both the peak's where it stands alone.
    """
    ends = []
    for step in (-1, 1):
        last = k = peak
        while 0 <= k + step < values.size and values[k + step] > 0.0:
            k += step
            fall = np.log(values[peak] / values[k]) - 2.0 * np.hypot(errors[peak], errors[k])
            if fall > -np.log(level):
                break
            last = k if fall <= 0.0 else last
        ends.append(last)
    return ends[0], ends[1]
