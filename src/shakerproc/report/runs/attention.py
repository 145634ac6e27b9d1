"""How the runs went: how many of each kind, and what needs attention."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from shakerproc.report.runs.view import RunView
from shakerproc.runs.summary import RunSummary


@dataclass(frozen=True, slots=True)
class Count:
    """How many runs are of one kind, and how the page colours the number."""

    number: int
    label: str
    kind: str


@dataclass(frozen=True, slots=True)
class Attention:
    """What was seen, and the tests that it was seen in, each with its anchor."""

    kind: str
    what: str
    where: str
    message: str
    tests: Sequence[tuple[str, str]] = ()


def tally(runs: Sequence[RunSummary]) -> str:
    """Return how many runs there are and how they went, in one sentence."""
    number = {c.label: c.number for c in counts(runs)}
    wanted = len(runs) - number.get("discarded", 0)
    parts = [f"{number['processed']} of {wanted} tests processed"]
    parts += [
        f"{number[name]} {name}"
        for name in ("failed", "incomplete", "flagged")
        if number.get(name)
    ]
    return ", ".join(parts) + "."


def counts(runs: Sequence[RunSummary]) -> list[Count]:
    """Return how many runs there are of each kind."""
    done = [run for run in runs if run.status == "done"]
    failed = sum(run.status == "failed" for run in runs)
    incomplete = sum(run.incomplete for run in done)
    flagged = sum(bool(run.flags) for run in done)
    discarded = sum(run.status == "discarded" for run in runs)
    return [
        Count(len(done), "processed", "done"),
        Count(failed, "failed", "failed" if failed else "none"),
        Count(incomplete, "incomplete", "odd" if incomplete else "none"),
        Count(flagged, "flagged", "odd" if flagged else "none"),
        Count(discarded, "discarded", "none"),
    ]


def attention(runs: Sequence[RunSummary], views: Sequence[RunView]) -> list[Attention]:
    """Return failed runs, then incomplete ones, then other flags; the same is told once."""
    found: dict[Attention, list[tuple[str, str]]] = {}
    for run, view in zip(runs, views, strict=True):
        told = [Attention("flag", f.kind, f.channel, f.message) for f in run.flags]
        if run.status == "failed":
            told.insert(0, Attention("status-failed", "failed", "", run.error))
        for item in told:
            found.setdefault(item, []).append((run.test, view.anchor))
    items = [replace(item, tests=tests) for item, tests in found.items()]
    return sorted(items, key=lambda item: (item.what != "failed", item.what != "incomplete"))
