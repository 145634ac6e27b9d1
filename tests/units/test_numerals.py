"""Numbers for people: in full where that is short."""

from decimal import Context, Decimal

import pytest

from shakerproc.numerals import numeral


@pytest.mark.parametrize(
    ("value", "digits", "shown"),
    [
        (123.4, 2, "120"), (1240.4, 3, "1240"), (5e4, 4, "50000"), (-99_999.0, 3, "-100000"),
        (51_200.0, 4, "51200"), (0.0552, 3, "0.0552"), (3.05e8, 3, "3.05e+08"),
        (2e-5, 3, "2e-05"), (0.0, 3, "0"), (float("inf"), 3, "inf"), (float("nan"), 3, "nan"),
    ],
)  # fmt: skip
def test_a_number_for_people_is_in_full_where_that_is_short(value, digits, shown):
    assert numeral(value, digits) == shown


@pytest.mark.parametrize("digits", [2, 3, 4])
def test_it_is_the_number_rounded_to_so_many_digits(digits):
    """As decimal arithmetic rounds it."""
    for power in range(-4, 10):
        value = 9.87654321 * 10.0**power
        rounded = Context(prec=digits).create_decimal(Decimal(value))
        assert Decimal(numeral(value, digits)) == rounded
        assert ("e" in numeral(value, digits)) == (value >= 1e7)
