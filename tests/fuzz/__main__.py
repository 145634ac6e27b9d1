"""``make fuzz``: what becomes of some 850,000 damaged recordings.

Works in parts and says of each what was bad in it; then prints a table: one line for each way
of damage, one column for each outcome. ``--share 2/7`` takes the second of seven disjoint
shares, each of every kind. Exit status 1 if anything hung, blew up, raised anything but one
line, or lost or renamed something silently.
"""

import argparse
import multiprocessing
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor

from tests.fuzz.campaign import drawn, share, table
from tests.fuzz.recorder_seeds import CORE, EXTRAS

PARTS = 10


def say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def one_of(text: str) -> tuple[int, int]:
    """Return which share of how many, counted from 1.

    Raises
    ------
    argparse.ArgumentTypeError
        If there is none of that number.
    """
    number, _, count = text.partition("/")
    if not (number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count)):
        raise argparse.ArgumentTypeError(f"expected a share such as 2/7, got {text!r}")
    return int(number), int(count)


def recorders(count: int, only: list[str]) -> int:
    """Print what became of so many damaged files of each recorder; return how many are bad."""
    found = 0
    for write in (*CORE, *EXTRAS.values()):
        if only and write.__name__ not in only:
            continue
        start = time.perf_counter()
        counts: Counter[tuple[str, str]] = Counter()
        before = found
        for kind, outcome, bad in drawn(write, count):
            counts[kind, outcome] += 1
            if bad:
                found += 1
                say(f"  {bad}")
            if counts.total() % 500 == 0:
                say(f"  {counts.total()} so far")
        spent = time.perf_counter() - start
        say(f"{write.__name__}: {count} mutants, {found - before} bad, {spent:.0f} s")
        say(table(counts))
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--share", type=one_of, default=(1, 1), help="which of how many: 2/7")
    parser.add_argument("--recorders", type=int, default=0, help="mutants of each recorder")
    parser.add_argument(
        "--only",
        nargs="*",
        default=[],
        help="which of these: mts ods rf64 mdf ide famos feather xlsx",
    )
    options = parser.parse_args()
    if options.recorders:
        return 1 if recorders(options.recorders, options.only) else 0
    start = time.perf_counter()
    number, count = options.share
    parts = [number - 1 + count * part for part in range(PARTS)]
    spawn = multiprocessing.get_context("spawn")
    counts: Counter[tuple[str, str]] = Counter()
    found, peak = 0, 0.0
    with ProcessPoolExecutor(options.workers, mp_context=spawn) as pool:
        done = pool.map(share, parts, [count * PARTS] * PARTS)
        for part, (of_part, bad, memory) in enumerate(done, start=1):
            counts += of_part
            found, peak = found + len(bad), max(peak, memory)
            spent = time.perf_counter() - start
            n = of_part.total()
            say(f"part {part} of {PARTS}: {n} mutants, {len(bad)} bad, {spent:.0f} s")
            for line in bad:
                say(f"  {line}")
    say(table(counts))
    say(
        f"\n{counts.total()} mutants in {time.perf_counter() - start:.0f} s, {found} bad, "
        f"peak memory of a worker {peak:.0f} MB"
    )
    return 1 if found or peak > 300.0 else 0


if __name__ == "__main__":
    sys.exit(main())
