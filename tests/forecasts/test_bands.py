"""Bands and limits against closed forms, and the model error against errors that were made."""

import numpy as np
import pytest
import scipy.stats
from numpy.testing import assert_allclose

from shakerproc.forecasts.ensemble import Ensemble, even_normals
from shakerproc.forecasts.levels import level_of
from shakerproc.forecasts.model_error import LevelError, error_of, freed
from shakerproc.forecasts.quantities import Quantity, spread_of

RMS = Quantity("response", "ch3", "rms", "m/s^2")


@pytest.mark.parametrize("freedom", [1.0, 2.0, 5.0])
def test_a_band_of_model_error_alone_is_students_law_in_decibels(freedom):
    found = spread_of(np.full(60, 5.0), 0.5, freedom)
    half = 0.5 * scipy.stats.t.ppf(0.95, freedom)
    assert_allclose(20.0 * np.log10(np.array(found.band) / 5.0), [-half, half], rtol=0.12)
    for above in (0.3, 1.0):
        limit = 5.0 * 10.0 ** (above / 20.0)
        wanted = scipy.stats.t.sf(above / 0.5, freedom)
        assert_allclose(found.exceeds(limit), wanted, rtol=0.1)


def test_a_band_of_drawn_values_alone_holds_nine_of_ten():
    drawn = np.exp(0.1 * np.random.default_rng(0).standard_normal(2000))
    low, high = spread_of(drawn, 0.0, np.inf).band
    assert_allclose(np.log([low, high]), [-0.1645, 0.1645], rtol=0.06)


@pytest.mark.parametrize("count", [16, 27, 60])
def test_a_band_of_calibration_holds_nine_of_ten_whatever_is_drawn(count):
    """Of the input, drawn for each simulated test, and of a sensor."""
    for seed in range(10):
        errors = even_normals(count, 2, np.random.default_rng([seed, 2]))
        parts = np.sort(np.floor(count * scipy.stats.norm.cdf(errors)), axis=0)
        assert np.all(parts == np.arange(count)[:, None])
        band = spread_of(np.exp(0.01 * errors[:, 0]), 0.0, np.inf, 0.01).band
        ends = np.log(band) / (0.01 * np.sqrt(2.0))
        assert_allclose(ends, scipy.stats.norm.ppf([0.05, 0.95]), atol=0.15)


TOGETHER, APART = np.array([0.0, 1.0, 1.0, -1.0, -1.0]), np.array([0.0, 1.0, -1.0, 1.0, -1.0])


def errors(*rows, draws=TOGETHER):
    """Return errors of levels: distance, error, standard deviation of its draws [dB]."""
    return [
        LevelError(str(i), RMS, 1.0, distance, error + spread * draws, error + spread * draws)
        for i, (distance, error, spread) in enumerate(rows)
    ]


def test_the_model_error_grows_as_that_of_levels_that_were_run():
    found = error_of(errors((0.0, 0.3, 0.0), (6.0, 1.2, 0.0), (12.0, -2.4, 0.0)))
    assert_allclose(found.fitted_db, 0.3, rtol=1e-9)
    assert_allclose(found.growth, 0.2, rtol=1e-9)
    assert_allclose(found.at(6.0), np.hypot(0.3, 1.2), rtol=1e-9)
    assert_allclose(found.freedom, (36.0 + 144.0) ** 2 / (36.0**2 + 144.0**2), rtol=1e-9)


def test_what_the_numbers_leave_open_is_no_model_error():
    found = error_of(errors((0.0, 0.1, 0.2), (6.0, 1.0, 1.5)))
    assert (found.fitted_db, found.growth) == (0.0, 0.0)


def test_a_model_that_lacks_an_effect_goes_on_from_the_nearest_level():
    """A linear model that is 3 dB low everywhere is then exactly linear scaling."""
    low = errors((0.0, -3.0, 0.0), (6.0, -3.0, 0.0))
    (next_level,) = freed(low[1:], low[:1])
    assert_allclose(next_level.error_db, -3.0 * 0.1**2 / 3.0**2, rtol=1e-9)  # calibration
    assert_allclose(next_level.carried_db, -3.0 - next_level.error_db, rtol=1e-9)
    assert_allclose(next_level.of_model.error_db, -3.0, rtol=1e-9)
    assert_allclose(error_of([next_level.of_model]).growth, 0.5, rtol=1e-9)  # of joints
    (otherwise,) = freed(low[1:], low[:1], same_drive=False)
    assert otherwise.error_db == -3.0


def test_what_no_test_tells_is_no_error_of_the_next_level_if_it_is_the_same_there():
    """A damping that nothing tells: 10 dB open at both levels, next to nothing between them."""
    (near,), (ahead,) = errors((0.0, -4.0, 10.0)), errors((6.0, -5.0, 10.0))
    (found,) = freed([ahead], [near])
    assert_allclose(found.error_db, -1.0, atol=0.01)
    assert_allclose(found.spread_db, 0.0, atol=0.01)


def test_what_a_model_lacks_is_not_taken_for_its_numbers_in_another_kind_of_test():
    (near,), (ahead,) = errors((0.0, -10.0, 1.0)), errors((6.0, 3.0, 1.0))
    (alike,), (other,) = (freed([ahead], [near], same_drive=one) for one in (True, False))
    assert_allclose(alike.error_db, 13.0, atol=0.01)
    assert_allclose(other.error_db, 3.0, atol=0.11)


def test_an_error_that_chance_explains_is_not_carried_on():
    near = errors((0.0, 0.4, 0.5), (0.0, -0.3, 0.5))
    (next_level,) = freed(errors((6.0, 1.0, 0.2), draws=APART), near)
    assert_allclose(next_level.error_db, 1.0, rtol=1e-9)


def test_a_peak_that_changes_places_with_another_is_not_carried_on():
    """Of two resonances as high as each other, draws of the numbers have both largest."""
    above = errors((6.0, 0.0, 3.0), draws=APART)
    (carried,) = freed(above, errors((0.0, 7.4, 3.2)))
    (chance,) = freed(above, errors((0.0, 7.4, 7.5)))
    assert carried.carried_db > 5.0
    assert chance.carried_db == 0.0


@pytest.mark.parametrize("slope", [0.4, 1.0, 2.5])
@pytest.mark.parametrize("wanted", [-11.0, -7.3, -1.2, 0.0, 4.4])
def test_the_level_of_five_per_cent_is_where_the_quantile_crosses_the_limit(wanted, slope):
    asked = []

    def beyond(level):
        asked.append(level)
        return slope * (level - wanted)

    assert_allclose(level_of(beyond), wanted, atol=1e-9)
    assert len(asked) <= 6
    assert max(map(abs, asked)) <= 12.0


def test_the_level_of_a_response_that_bends_lies_within_the_step_that_encloses_it():
    """A stop: the response grows by 3 dB per dB once it is reached at -4 dB."""
    found = level_of(lambda level: 0.5 * (level + 4.0) if level < -4.0 else 3.0 * (level + 4.0))
    assert -6.0 < found < -3.0


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_level_beyond_twelve_decibels_is_not_told(sign):
    assert level_of(lambda level: level + sign * 20.0) is None


def made(draws, level):
    """Return an ensemble whose values scatter by 30 % and grow by 1.4 dB a decibel."""
    scatter = np.exp(0.3 * np.random.default_rng(5).standard_normal(40))[draws]
    return Ensemble(np.array(draws), {RMS: scatter * 10.0 ** (1.4 * level / 20.0)},
                    np.zeros(0), {}, 0)  # fmt: skip


def test_a_few_draws_of_another_level_move_all_by_what_they_differ_from_their_twins():
    all_draws = [i for i in range(40) if i != 2]  # one ran away
    found = made(all_draws, 0.0).changed_as(made([0, 1, 2, 3], -9.0)).values
    assert_allclose(found[RMS], made(all_draws, -9.0).values[RMS], rtol=1e-12)
