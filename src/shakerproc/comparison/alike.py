"""Comparisons of several models with the same tests, scored in the same windows."""

from collections.abc import Callable
from dataclasses import replace

from shakerproc.comparison.comparison import Comparison, compare_tests
from shakerproc.comparison.windows import Windows


def scored_alike(
    *comparisons: Comparison, tell: Callable[[str], None] = lambda _: None
) -> tuple[Comparison, ...]:
    """Return comparisons of which each test is scored in the same windows for every model.

    Where the motion of one model cannot be predicted for a whole test, the others are scored in
    its windows too; of several, the shortest count.

    Parameters
    ----------
    comparisons : Comparison
        Of one model each, with the same tests.
    tell : callable
        Told what is going on.
    """
    shared: dict[str, Windows] = {}
    for found in comparisons:
        for name, windows in found.windows.items():
            if name not in shared or windows.n_samples < shared[name].n_samples:
                shared[name] = windows
    return tuple(_in_windows(found, shared, tell) for found in comparisons)


def _in_windows(
    found: Comparison, shared: dict[str, Windows], tell: Callable[[str], None]
) -> Comparison:
    own = found.windows
    if all(own.get(name) is windows for name, windows in shared.items()):
        return found
    again = compare_tests(
        found.model, [test.measured for test in found.tests], left_out=found.left_out,
        windows=shared, tell=tell,
    )  # fmt: skip
    return replace(again, refit=found.refit)
