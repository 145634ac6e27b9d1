"""How large the distortion of a response is, and where it stands out of the noise."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.spectra.multisines.measuring import LineSpectra

Kind: TypeAlias = Literal["even", "odd", "all"]
"""Even and odd distortion, of lines that are not excited; all of it, from realisations."""

BLOCK: Final = 8
"""Neighbouring lines of one kind that are judged together [-]."""

CHANCE: Final = 0.01
"""Probability that noise alone shows as distortion anywhere in a curve [-]."""

LIMIT: Final = 2.0
"""Deviations by which the limit of a share lies above it [-]."""


@final
@dataclass(frozen=True, slots=True)
class Share:
    """Distortion of one kind as a share of the response at excited lines.

    Attributes
    ----------
    kind : Kind
        Which.
    lines : int
        How many lines show it.
    value, limit : float
        Of the root mean squares over the band, the noise taken away; and its upper limit, 95 %,
        as far as noise hides it in these realisations [-]. With one period the noise is in
        both.
    largest, at : float
        Largest share of neighbouring lines [-], and where [Hz]; NaN where none stands out.
    bands : sequence of (float, float)
        Where it stands out of the noise [Hz].
    """

    kind: Kind
    lines: int
    value: float
    limit: float
    largest: float
    at: float
    bands: Sequence[tuple[float, float]]


def shares_of(spectra: LineSpectra) -> dict[Kind, Share]:
    """Return how large each kind of distortion is that the measurement shows.

    Parameters
    ----------
    spectra : LineSpectra
        What the response does at every line.
    """
    grid = spectra.grid
    silent = spectra.realisations - grid.carried
    found: dict[Kind, Share] = {}
    kinds: tuple[tuple[Kind, NDArray[np.bool_], FloatArray, NDArray[np.int_]], ...] = (
        ("even", grid.even, spectra.distortion, silent),
        ("odd", grid.odd, spectra.distortion, silent),
        ("all", grid.carried > 1, spectra.scatter, grid.carried - 1),
    )
    for kind, chosen, amplitude, repeats in kinds:
        if chosen.any():
            found[kind] = _share(spectra, kind, np.flatnonzero(chosen), amplitude**2, repeats)
    return found


def _share(
    spectra: LineSpectra,
    kind: Kind,
    lines: NDArray[np.int_],
    power: FloatArray,
    repeats: NDArray[np.int_],
) -> Share:
    """Return the share of one kind, seen at `lines` with so many `repeats` at each.

    Lines count by their repeats, so that every observation counts once.
    """
    excited = np.flatnonzero(spectra.grid.excited)
    whole, carried = spectra.response_power, spectra.level**2
    known = spectra.periods > 1
    noise = spectra.noise**2 if known else np.zeros(power.size)
    noisy = spectra.realisations * (spectra.periods - 1)
    count = repeats[lines]
    value = max(float(np.average(power[lines] - noise[lines], weights=count)), 0.0)
    seen, quiet = np.maximum(power[lines], noise[lines]), noise[lines]
    spread = np.sum(count * (2.0 * seen - quiet) * quiet)
    spread += np.sum((count * quiet) ** 2) / noisy if known else 0.0
    limit = value + LIMIT * float(np.sqrt(spread)) / float(count.sum())
    blocks = np.array_split(lines, max(1, lines.size // BLOCK))
    share, place, stands = [], [], []
    for block in blocks:
        near = excited[np.argsort(np.abs(excited - block.mean()))[: block.size]]
        each = repeats[block]
        over = np.average(power[block] - noise[block], weights=each) / np.mean(carried[near])
        share.append(float(np.sqrt(max(over, 0.0))))
        place.append(float(spectra.grid.frequency[block].mean()))
        stands.append(
            known and _stands(power[block], noise[block], (each, noisy), CHANCE / len(blocks))
        )
    top = int(np.argmax(np.where(stands, share, -1.0)))
    any_stands = bool(np.any(stands))
    return Share(
        kind,
        lines.size,
        float(np.sqrt(value / whole)),
        float(np.sqrt(limit / whole)),
        share[top] if any_stands else float("nan"),
        place[top] if any_stands else float("nan"),
        _bands(spectra.grid.frequency, blocks, stands),
    )


def _stands(
    power: FloatArray,
    noise: FloatArray,
    repeats: tuple[NDArray[np.int_], int],
    chance: float,
) -> bool:
    """Return whether the power of lines is more than noise makes of it by chance.

    Each line holds as many observations as it has repeats. The noise, of which a line has the
    same number everywhere, is weighted alike: Satterthwaite's degrees of freedom.
    """
    each, noisy = repeats
    above = 2 * int(each.sum())
    below = 2.0 * noisy * float(each.sum()) ** 2 / float(np.sum(each**2))
    limit = 1.0 / scipy.special.fdtri(below, above, chance)  # F's upper quantile
    return bool(np.sum(each * power) > limit * np.sum(each * noise))


def _bands(
    frequency: FloatArray,
    blocks: Sequence[NDArray[np.int_]],
    stands: Sequence[bool],
) -> tuple[tuple[float, float], ...]:
    """Return the bands of neighbouring blocks that stand out [Hz]."""
    bands: list[tuple[float, float]] = []
    before = False
    for block, yes in zip(blocks, stands, strict=True):
        if yes:
            low = bands.pop()[0] if before else float(frequency[block[0]])
            bands.append((low, float(frequency[block[-1]])))
        before = yes
    return tuple(bands)
