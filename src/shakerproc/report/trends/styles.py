"""Which colour and mark the series of trends have: the same thing the same in all trends."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, final

from shakerproc.campaign.trend import Trend

STYLES: Final = 6
"""How many colours with marks of their own there are."""


@final
@dataclass(frozen=True, slots=True)
class _Series:
    """Facts that distinguish a series from the others of its trend, and its runs."""

    name: str
    facts: frozenset[str]
    runs: frozenset[str]

    def likeness(self, other: "_Series") -> tuple[float, int]:
        """Return the share of facts that both have, then how many runs both have."""
        both = len(self.facts & other.facts) / len(self.facts | other.facts)
        return both, len(self.runs & other.runs)


def series_styles(trends: Sequence[Trend]) -> list[Mapping[str, int]]:
    """Return the number of colour and mark of every series, trend by trend.

    A series has the style of the most alike series of an earlier trend: by the facts of its
    name that not all series of its trend share, then by its runs. Those without one have styles
    that no trend has yet, then any that their trend has not.
    """
    seen: list[tuple[int, _Series]] = []
    found: list[Mapping[str, int]] = []
    for trend in trends:
        series = list(_series(trend))
        styles = _kept(series, seen)
        fresh = set(range(STYLES)) - {style for style, _ in seen}
        for one in series:
            if one.name not in styles:
                free = [s for s in (*fresh, *range(STYLES)) if s not in styles.values()]
                styles[one.name] = free[0] if free else len(styles) % STYLES
        seen += [(styles[one.name], one) for one in series]
        found.append(styles)
    return found


def _series(trend: Trend) -> Iterator[_Series]:
    facts = {name: frozenset(name.split(", ")) for name in trend.series}
    shared = frozenset.intersection(*facts.values()) if len(facts) > 1 else frozenset()
    for name, points in trend.series.items():
        runs = frozenset(point.test for point in points)
        yield _Series(name, (facts[name] - shared) or facts[name], runs)


def _kept(series: Sequence[_Series], seen: Sequence[tuple[int, _Series]]) -> dict[str, int]:
    """Return the styles that series keep of earlier trends, the most alike first."""
    pairs = [(one.likeness(other), one.name, s) for one in series for s, other in seen]
    kept: dict[str, int] = {}
    for likeness, name, style in sorted(pairs, key=lambda pair: pair[0], reverse=True):
        if any(likeness) and name not in kept and style not in kept.values():
            kept[name] = style
    return kept
