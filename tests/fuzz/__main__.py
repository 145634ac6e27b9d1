"""``make fuzz``: what becomes of a hundred thousand damaged recordings.

Prints a table: one line for each way of damage, one column for each outcome. Exit status 1 if
anything hung, blew up, raised anything but one line, or lost or renamed something silently.
"""

import argparse
import multiprocessing
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor

from tests.fuzz.campaign import share, table


def say(text: str) -> None:
    sys.stdout.write(f"{text}\n")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--every", type=int, default=1, help="take every n-th mutant only")
    options = parser.parse_args()
    start = time.perf_counter()
    jobs = [(number, options.workers, options.every) for number in range(options.workers)]
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(options.workers, mp_context=spawn) as pool:
        shares = list(pool.map(share, *zip(*jobs, strict=True)))
    counts = sum((counts for counts, _, _ in shares), Counter())
    bad = [line for _, lines, _ in shares for line in lines]
    peak = max(peak for _, _, peak in shares)
    say(table(counts))
    say(
        f"\n{sum(counts.values())} mutants in {time.perf_counter() - start:.0f} s, "
        f"peak memory of a worker {peak:.0f} MB"
    )
    say("\n".join(bad))
    return 1 if bad or peak > 300.0 else 0


if __name__ == "__main__":
    sys.exit(main())
