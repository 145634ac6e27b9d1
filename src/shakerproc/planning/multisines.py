"""The realisations of a multisine as a shaker would play them, one after the other."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.errors import LogError, SpectrumError
from shakerproc.simulation.noise import NoiseProfile, multisine
from shakerproc.spectra.multisines import samples_of_period
from shakerproc.testlog import Multisine, Test

GROUP: Final = 4
"""Odd lines in a row of which one is left out to detect odd distortion [-]."""


def check_period(test: Test, sample_rate: float) -> None:
    """Pass a test whose multisine, if it has one, fits a sample rate [Hz].

    Raises
    ------
    LogError
        If a period is no whole number of samples.
    """
    if test.multisine is None:
        return
    try:
        samples_of_period(test.multisine.period, sample_rate)
    except SpectrumError as error:
        raise LogError(f"{test.source}: test {test.id}: {error}") from error


def excited_lines(
    said: Multisine, n_lines: int, generator: np.random.Generator
) -> NDArray[np.bool_]:
    """Return which multiples of one over the period are excited, from the first.

    Parameters
    ----------
    said : Multisine
        Which the log wants.
    n_lines : int
        How many there are.
    generator : numpy.random.Generator
        Where the lines that are left out come from.
    """
    excited = np.ones(n_lines, dtype=bool)
    if said.lines == "all":
        return excited
    excited[1::2] = False
    if said.lines == "odd with detection":
        odd = np.flatnonzero(excited)
        groups = odd[: odd.size // GROUP * GROUP].reshape(-1, GROUP)
        excited[groups[np.arange(len(groups)), generator.integers(GROUP, size=len(groups))]] = (
            False
        )
    return excited


def played(
    test: Test,
    profile: NoiseProfile,
    sample_rate: float,
    ramp: float,
    generator: np.random.Generator,
) -> FloatArray:
    """Return all realisations, (n,) array [m/s² or N], each faded into the next.

    A realisation is led up within its first period, and goes on after its last one while it is
    led down: all other periods are whole.

    Parameters
    ----------
    test : Test
        The line of the log, which says how its multisine repeats.
    profile : NoiseProfile
        Density.
    sample_rate : float
        Samples per second [Hz].
    ramp : float
        Over which a realisation is led up and down [s]; a tenth of a period at most.
    generator : numpy.random.Generator
        Where lines and phases come from.

    Raises
    ------
    LogError
        If the log does not say the periods.
    """
    said = test.multisine
    if said is None or said.periods is None:
        raise LogError(
            f"{test.source}: test {test.id}: the log does not say how many periods; add "
            "multisine: {period: ..., periods: 9}"
        )
    n_period = round(said.period * sample_rate)
    length = said.periods * n_period
    step = length if said.every is None else round(said.every * sample_rate)
    n_ramp = min(round(ramp * sample_rate), n_period // 10)
    rise = 0.5 - 0.5 * np.cos(np.pi * (np.arange(n_ramp) + 0.5) / max(n_ramp, 1))
    window = np.concatenate([rise, np.ones(length - n_ramp), rise[::-1]])
    excited = excited_lines(said, n_period, generator)
    total = np.zeros((said.realisations - 1) * step + window.size)
    for m in range(said.realisations):
        one = multisine(
            profile, said.period, sample_rate, generator,
            periods=said.periods + 1, excited=excited,
        )  # fmt: skip
        total[m * step : m * step + window.size] += window * one[: window.size]
    return total
