"""Blows into a structure that still rings: how often the intervals of damping hold the truth.

python -m benchmarks.ringing_blows [--draws 25] [--seed 0]

The structure of `tests/modal/test_ringing_blows.py`: two modes of 0.1 and 0.2 %, six blows
1.2 s apart, evenly or not; the loud mode falls to 59 % between them.
"""

import argparse
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from tests.modal.test_ringing_blows import DAMPING, modes_of, ringing


def main(arguments: Sequence[str] | None = None) -> None:
    """Print coverage, and the mean and largest error of damping."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=25)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    print(f"{options.draws} draws, seed {options.seed}")
    for uneven in (False, True):
        held, errors = [], []
        for seed in range(options.seed, options.seed + options.draws):
            with tempfile.TemporaryDirectory() as place:
                modes = modes_of(Path(place), ringing(seed, uneven=uneven))
            low, high = modes.damping_bounds
            held.append((low <= DAMPING) & (high >= DAMPING))
            errors.append(modes.damping / DAMPING - 1.0)
        print(
            f"{'uneven' if uneven else 'even':6s} blows: truth in the 95 % interval "
            f"{np.mean(held):.1%}; damping off by {np.mean(errors):+.2%} in the mean, "
            f"{np.max(np.abs(errors)):.2%} at most"
        )


if __name__ == "__main__":
    main()
