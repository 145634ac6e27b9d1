"""Multisines: what is known exactly must come back, line by line."""

import numpy as np
import pytest

from shakerproc.errors import SpectrumError
from shakerproc.spectra.multisines import (
    check_input,
    cut,
    grid_of,
    layout_of,
    line_spectra,
    shares_of,
    transient_periods,
)

RATE, N, BAND = 512.0, 1024, (5.0, 100.0)  # Hz, samples of a period, Hz


def excited(rng):
    number = np.arange(11, 200, 2)
    left_out = [rng.choice(group) for group in np.array_split(number, 24)]
    return np.setdiff1d(number, left_out)


def sines(count, seed=1, lines=None):
    """One period of `count` realisations of amplitude 1 at every excited line."""
    rng = np.random.default_rng(seed)
    lines = excited(rng) if lines is None else lines
    spectrum = np.zeros((count, N // 2 + 1), dtype=complex)
    spectrum[:, lines] = 0.5 * N * np.exp(2j * np.pi * rng.random((count, lines.size)))
    return lines, np.fft.irfft(spectrum, N, axis=1)


def measured(force, response, periods, noise=0.0, seed=2):
    """Force and response (realisations, N), repeated, with noise on the response."""
    count = len(force)
    rng = np.random.default_rng(seed)
    rows = np.array([np.tile(one, periods).ravel() for one in (force, response)])
    rows[1] += noise * rng.standard_normal(rows.shape[1])
    layout = layout_of(rows.shape[1], RATE, N / RATE, periods=periods, realisations=count)
    lines = 2.0 / N * np.fft.rfft(cut(rows, layout))[..., : N // 2]
    grid = grid_of(lines[0], RATE / N, BAND)
    return line_spectra(lines[0][..., grid.number], lines[1][..., grid.number], grid)


def test_lines_that_are_excited_are_found_whatever_their_phases():
    lines, force = sines(1)
    grid = measured(force, force, 3).grid
    assert list(grid.number[grid.excited]) == list(lines)
    assert not (grid.even & grid.odd).any()
    assert (grid.even | grid.odd | grid.excited).all()
    assert grid.frequency == pytest.approx(grid.number / 2.0)


def test_hum_at_an_even_line_does_not_hide_that_the_multisine_is_odd():
    lines, force = sines(3)
    hum = 0.4 * np.sin(2.0 * np.pi * 100.0 * np.arange(N) / N)
    grid = measured(force + hum, force + hum, 1).grid
    assert list(grid.number[grid.excited]) == list(lines)
    assert grid.even.any()


def test_a_static_law_of_second_and_third_order_splits_into_even_and_odd():
    """Squares of odd lines lie at even lines, cubes at odd ones; the share is numpy's alone."""
    lines, force = sines(12)
    square, cube = 0.002 * force**2, 0.0002 * force**3
    found = shares_of(measured(force, 2.0 * force + square + cube, 4, noise=0.01))
    whole = np.abs(2.0 / N * np.fft.rfft(2.0 * force + cube)[:, lines]) ** 2
    number = np.arange(lines[0], lines[-1] + 1)
    for kind, part, parity in (("even", square, 0), ("odd", cube, 1)):
        at = np.setdiff1d(number[number % 2 == parity], lines)
        true = np.abs(2.0 / N * np.fft.rfft(part)[:, at]) ** 2
        decibels = 20.0 * np.log10(found[kind].value / np.sqrt(true.mean() / whole.mean()))
        assert abs(decibels) < 0.2
        assert found[kind].bands[0][0] < 10.0
    assert found["all"].bands


def own_lines(count, seed=1, share=0.75):
    """Excited lines, drawn anew for each realisation, and one period of each."""
    rng, numbers = np.random.default_rng(seed), np.arange(11, 200, 2)
    excited = rng.random((count, numbers.size)) < share
    excited[:, [0, -1]] = True
    spectrum = np.zeros((count, N // 2 + 1), dtype=complex)
    spectrum[:, numbers] = excited * 0.5 * N * np.exp(2j * np.pi * rng.random(excited.shape))
    lines = [numbers[one] for one in excited]
    return lines, np.fft.irfft(spectrum, N, axis=1)


def test_realisations_with_lines_of_their_own_split_a_law_line_by_line():
    """Each is excited at its own odd lines; the cube is seen at those that it leaves out."""
    lines, force = own_lines(8)
    cube = 0.0002 * force**3
    spectra = measured(force, 2.0 * force + cube, 4, noise=0.01)
    grid = spectra.grid
    assert [list(grid.number[one]) for one in grid.excited_in] == list(map(list, lines))
    found = shares_of(spectra)
    odd = np.arange(lines[0][0], lines[0][-1] + 1, 2)
    part, response = (np.abs(2.0 / N * np.fft.rfft(x)) ** 2 for x in (cube, 2.0 * force + cube))
    pairs = list(enumerate(lines))
    true = np.concatenate([part[m, np.setdiff1d(odd, one)] for m, one in pairs])
    whole = np.concatenate([response[m, one] for m, one in pairs])
    decibels = 20.0 * np.log10(found["odd"].value / np.sqrt(true.mean() / whole.mean()))
    assert abs(decibels) < 0.2
    assert found["odd"].bands
    assert not found["even"].bands
    assert found["all"].value == pytest.approx(found["odd"].value, rel=0.2)


@pytest.mark.parametrize("share", [0.75, 0.5])
def test_a_linear_response_to_lines_drawn_anew_shows_nothing_but_noise(share):
    _, force = own_lines(4, share=share)
    seen = []
    for seed in range(100):
        spectra = measured(force, 3.0 * force, 3, 0.1, seed)
        shares = shares_of(spectra)
        seen += [bool(one.bands) for one in shares.values()]
        assert max(one.limit for one in shares.values()) < 0.01
    assert sum(seen) <= 9  # 3 expected of 300; more than 9 in 1 of 1000
    expected = 0.2 / np.sqrt(N * 3)
    silent = ~np.isnan(spectra.distortion)
    assert np.sqrt(np.mean(spectra.distortion[silent] ** 2)) == pytest.approx(
        expected, rel=0.15
    )


def test_realisations_that_share_no_line_still_tell_odd_from_even():
    numbers = np.arange(11, 200, 2)
    spectrum = np.zeros((2, N // 2 + 1), dtype=complex)
    rng = np.random.default_rng(1)
    for m in range(2):
        own = numbers[m::2]
        spectrum[m, own] = 0.5 * N * np.exp(2j * np.pi * rng.random(own.size))
    force = np.fft.irfft(spectrum, N, axis=1)
    found = shares_of(measured(force, 2.0 * force + 0.0002 * force**3, 4, 0.01))
    assert set(found) == {"even", "odd"}
    assert found["odd"].bands
    assert not found["even"].bands


def test_a_realisation_that_excites_nothing_is_named():
    _, force = own_lines(3)
    force[1] *= 0.0
    with pytest.raises(SpectrumError, match=r"only 0 lines of the input .* in realisation 2"):
        measured(force, force, 2)


@pytest.mark.parametrize("noise", [0.01, 0.1, 1.0])
def test_the_noise_of_every_line_is_that_of_its_samples(noise):
    """White noise of deviation s has lines of amplitude 2 s / sqrt(n), less by the averages."""
    _, force = sines(4)
    periods = 8
    spectra = measured(force, 2.0 * force, periods, noise)
    expected = 2.0 * noise / np.sqrt(N * periods)
    assert np.sqrt(np.mean(spectra.noise**2)) == pytest.approx(expected, rel=0.05)
    at = spectra.grid.excited
    scatter = np.sqrt(np.mean(spectra.scatter[at] ** 2))
    assert scatter == pytest.approx(expected, rel=0.15)  # nothing but noise, of three
    assert np.abs(spectra.function[at]) == pytest.approx(2.0, abs=4.0 * expected)


def test_a_linear_response_shows_no_distortion_and_its_limit_falls_with_the_noise():
    """A curve of noise alone stands out by chance in 1 % of the draws."""
    _, force = sines(2)
    seen = []
    for seed in range(200):
        shares = shares_of(measured(force, 3.0 * force, 4, 0.1, seed))
        seen += [bool(one.bands) for one in shares.values()]
    assert sum(seen) <= 14  # 6 expected of 600; more than 14 in 1 of 500
    limits = [
        max(one.limit for one in shares_of(measured(force, 3.0 * force, 4, noise)).values())
        for noise in (0.1, 0.01)
    ]
    assert limits[1] == pytest.approx(0.1 * limits[0], rel=1e-3)


def test_an_input_that_is_not_clean_counts_as_input():
    """Force at lines that should be still, passed on linearly, is no distortion."""
    _, force = sines(1)
    impure = force + 1e-3 * force**2 + 1e-4 * force**3
    shares = shares_of(measured(impure, 5.0 * impure, 4, noise=1e-4))
    assert max(one.value for one in shares.values()) < 1e-5
    assert not any(one.bands for one in shares.values())


def test_periods_before_the_motion_repeats_are_counted():
    _, force = sines(1)
    rng = np.random.default_rng(3)
    response = np.tile(force, 8).ravel()
    time = np.arange(response.size) / RATE
    response = response + 30.0 * np.exp(-1.5 * time) * np.sin(250.0 * time)
    response += 0.01 * rng.standard_normal(time.size)
    layout = layout_of(time.size, RATE, N / RATE)
    lines = np.fft.rfft(cut(response[np.newaxis], layout))[..., 10:200]
    assert (
        transient_periods(lines) == 3
    )  # exp(-9) of 30 in the fourth period lies within the noise
    steady = response[5 * N :][np.newaxis]
    kept = np.fft.rfft(cut(steady, layout_of(3 * N, RATE, N / RATE)))[..., 10:200]
    assert transient_periods(kept) == 0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"period": 2.001}, r"2.001 s is 1024.512 samples at 512 Hz, .*\. Write 2.00195312 s"),
        ({"period": 2.0, "periods": 20}, "1 realisations of 20 periods of 2 s need 40 s"),
        ({"period": 30.0}, "need 30 s, and the run has 16 s"),
        ({"period": 0.01}, "whole number from 8 on"),
        ({"period": 2.0, "periods": 4, "realisations": 2, "every": 12.0}, "need 20 s"),
    ],
)
def test_a_layout_that_does_not_fit_is_refused(arguments, said):
    with pytest.raises(SpectrumError, match=said):
        layout_of(16 * 512, RATE, **arguments)


def test_an_input_that_does_not_repeat_is_refused_with_the_time_after_which_it_does():
    _, force = sines(1)
    rows = np.tile(force, 8).ravel()
    with pytest.raises(SpectrumError, match="it repeats after 2 s: correct period"):
        check_input(rows, layout_of(rows.size, RATE, 1.5), RATE)
    random = np.random.default_rng(1).standard_normal(rows.size)
    with pytest.raises(SpectrumError, match="nothing in it repeats"):
        check_input(random, layout_of(rows.size, RATE, 2.0), RATE)
    with pytest.raises(SpectrumError, match="realisations 1 and 2 have the same phases"):
        check_input(rows, layout_of(rows.size, RATE, 2.0, realisations=2), RATE)
    with pytest.raises(SpectrumError, match="does not move"):
        check_input(0.0 * rows, layout_of(rows.size, RATE, 2.0), RATE)
