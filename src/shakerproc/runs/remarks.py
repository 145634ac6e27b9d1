"""Remarks on a recording beside its numbers: notes, and unused channels."""

from collections.abc import Iterable, Sequence
from typing import Final

from shakerproc.data import UnusedChannel

MOST_NAMES: Final = 40
"""Channels that are named in a line; summary.json names all."""

MOST_TESTS: Final = 12


def unused_lines(unused: Sequence[UnusedChannel]) -> tuple[str, ...]:
    """Return a line for each reason why channels are not used, which names them.

    Examples
    --------
    >>> unused_lines([UnusedChannel("T1", "it holds text"), UnusedChannel("T2", "no samples")])
    ('not used: T1 (it holds text)', 'not used: T2 (no samples)')
    """
    names: dict[str, list[str]] = {}
    for channel in unused:
        names.setdefault(channel.why, []).append(channel.name)
    return tuple(f"not used: {_listed(found)} ({why})" for why, found in names.items())


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
    return ", ".join(names[:MOST_NAMES]) + more


def by_tests(told: Iterable[tuple[str, Sequence[str]]]) -> list[str]:
    """Return the messages on tests, each line once with the tests that it is true of.

    Parameters
    ----------
    told : iterable of (str, sequence of str)
        Name of a test, and the lines about it.

    Examples
    --------
    >>> by_tests([("1", ["not used: T1 (it holds text)"]), ("2", []), ("3", ["a", "b"])])
    ['test 1: not used: T1 (it holds text)', 'test 3: a', 'test 3: b']
    >>> by_tests([("1", ["a"]), ("2", ["a"])])
    ['every test: a']
    """
    tests: dict[str, list[str]] = {}
    names = []
    for name, lines in told:
        names.append(name)
        for line in lines:
            tests.setdefault(line, []).append(name)
    return [f"{_whose(found, names)}: {line}" for line, found in tests.items()]


def _whose(found: Sequence[str], names: Sequence[str]) -> str:
    if len(found) == len(names) > 1:
        return "every test"
    more = f" and {len(found) - MOST_TESTS} more" if len(found) > MOST_TESTS else ""
    plural = "s" if len(found) > 1 else ""
    return f"test{plural} {', '.join(found[:MOST_TESTS])}{more}"
