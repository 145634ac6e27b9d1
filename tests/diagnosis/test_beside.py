"""Which laws a second effect is sought beside in a decay."""

from types import SimpleNamespace

from shakerproc.diagnosis.beside import _worth_their_numbers


def law(size, level, effects=1):
    """Return what is looked at of a fit: how many numbers it has, and what it leaves."""
    return SimpleNamespace(
        hypothesis=SimpleNamespace(size=size, added=("an effect",) * effects), level=level
    )


def test_a_law_of_more_numbers_is_worth_them_where_it_leaves_less():
    coulomb, drag = law(3, 0.76), law(3, 3.9)
    jenkins, gap = law(4, 0.53), law(4, 3.8)
    lugre, pair = law(7, 0.54), law(4, 0.49, effects=2)
    worth = _worth_their_numbers([lugre, gap, jenkins, drag, coulomb, pair])
    assert worth == [coulomb, jenkins]


def test_one_that_leaves_more_with_more_numbers_is_not():
    assert _worth_their_numbers([law(5, 1.0), best := law(3, 0.9)]) == [best]
