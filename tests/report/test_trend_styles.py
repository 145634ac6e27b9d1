"""The same thing has the same colour in all trends."""

from shakerproc.campaign.trend import Trend, TrendPoint
from shakerproc.report.trends import series_styles


def trend(**series):
    points = {
        name: tuple(
            TrendPoint(test, float(i), 300.0, 1.0) for i, test in enumerate(tests.split())
        )
        for name, tests in series.items()
    }
    return Trend("t", "t", "", "x", "ch3", points)


def test_a_fact_keeps_its_style_in_another_order_and_among_further_facts():
    first, second = series_styles([
        trend(**{"0.00 mm": "1", "0.05 mm": "2", "0.10 mm": "3"}),
        trend(**{"slot, 0.20 mm": "7", "radial, 0.10 mm": "6", "radial, 0.00 mm": "4"}),
    ])
    assert second["radial, 0.10 mm"] == first["0.10 mm"]
    assert second["radial, 0.00 mm"] == first["0.00 mm"]
    assert second["slot, 0.20 mm"] not in first.values()


def test_the_same_runs_keep_their_style_by_another_name():
    first, second = series_styles([trend(low="1 2 3", high="4 5 6"), trend(b="5 4", a="1 2")])
    assert (second["a"], second["b"]) == (first["low"], first["high"])


def test_up_to_six_series_of_a_trend_differ_though_their_runs_shared_a_style():
    many = trend(**{f"s{i}": str(i) for i in range(1, 7)})
    _, second = series_styles([trend(all="1 2 3 4 5 6"), many])
    assert sorted(second.values()) == list(range(6))


def test_more_series_than_styles_have_one_each():
    (only,) = series_styles([trend(**{f"s{i}": str(i) for i in range(9)})])
    assert len(only) == 9
    assert set(only.values()) == set(range(6))
