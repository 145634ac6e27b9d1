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
    grid, m = spectra.grid, spectra.realisations
    found: dict[Kind, Share] = {}
    kinds: tuple[tuple[Kind, NDArray[np.bool_], FloatArray, int], ...] = (
        ("even", grid.even, spectra.level, m),
        ("odd", grid.odd, spectra.level, m),
        ("all", grid.excited & (m > 1), spectra.scatter, m - 1),
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
    repeats: int,
) -> Share:
    """Return the share of one kind, seen at `lines` with so many `repeats` at each."""
    excited = np.flatnonzero(spectra.grid.excited)
    carried = spectra.level**2
    whole = float(np.mean(carried[excited]))
    known = spectra.periods > 1
    noise = spectra.noise**2 if known else np.zeros(power.size)
    noisy = spectra.realisations * (spectra.periods - 1)
    value = max(float(np.mean(power[lines] - noise[lines])), 0.0)
    seen, quiet = np.maximum(power[lines], noise[lines]), noise[lines]
    spread = np.sum((2.0 * seen - quiet) * quiet) / repeats
    spread += np.sum(quiet**2) / noisy if known else 0.0
    limit = value + LIMIT * float(np.sqrt(spread)) / lines.size
    blocks = np.array_split(lines, max(1, lines.size // BLOCK))
    share, place, stands = [], [], []
    for block in blocks:
        near = excited[np.argsort(np.abs(excited - block.mean()))[: block.size]]
        over = float(np.mean(power[block] - noise[block]) / np.mean(carried[near]))
        share.append(np.sqrt(max(over, 0.0)))
        place.append(float(spectra.grid.frequency[block].mean()))
        stands.append(known and _stands(power[block], noise[block], (repeats, noisy),
                                        CHANCE / len(blocks)))  # fmt: skip
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
    power: FloatArray, noise: FloatArray, repeats: tuple[int, int], chance: float
) -> bool:
    """Return whether the power of lines is more than noise makes of it by chance."""
    above, below = (2 * power.size * count for count in repeats)
    limit = 1.0 / scipy.special.fdtri(below, above, chance)  # F's upper quantile
    return bool(np.sum(power) > limit * np.sum(noise))


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
