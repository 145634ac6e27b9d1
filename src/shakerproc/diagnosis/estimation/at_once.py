"""Predictions made at once: compiled kernels leave Python to other threads."""

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from typing import Final, TypeVar

Given = TypeVar("Given")
Made = TypeVar("Made")

THREADS: Final = os.cpu_count() or 1
"""How many are made at once [-]."""


WORTH: Final = 30_000
"""Samples of a prediction from which on it is made at once with others: handing over takes as
long as a gap of some 20,000 [-]."""


def at_once(
    make: Callable[[Given], Made], given: Iterable[Given], n_samples: int
) -> Iterator[Made]:
    """Yield what is made of each, in order; of no more than `THREADS` at once, and kept.

    `n_samples` is how many samples each takes [-].
    """
    if n_samples < WORTH:
        yield from map(make, given)
        return
    waiting = iter(given)
    with ThreadPoolExecutor(THREADS) as pool:
        while some := list(islice(waiting, THREADS)):
            yield from pool.map(make, some)
