"""The statements of the thesis, each with the number that the program finds for it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, final

from shakerproc.studies.results import VERDICTS, Checked, Verdict
from shakerproc.verification import nonlinear, theory
from shakerproc.verification.base import ClaimFinding


@final
@dataclass(frozen=True, slots=True)
class ClaimOutcome:
    """One line of the table.

    Attributes
    ----------
    where : str
        Place in the thesis.
    says : str
        What it states.
    number : str
        What we find.
    checks : tuple of Checked
        What was checked, with the tolerance, and how it came out.
    held : str
        Whether it held: what the checks come to.
    """

    where: str
    says: str
    number: str
    checks: tuple[Checked, ...]
    held: Verdict


@final
@dataclass(frozen=True, slots=True)
class ThesisClaim:
    """A statement of the thesis and how to put it to the test.

    Attributes
    ----------
    where : str
        Place in the thesis.
    says : str
        What it states.
    find : function
        Computes our number and checks the statement against it.
    """

    where: str
    says: str
    find: Callable[[], ClaimFinding]

    def outcome(self) -> ClaimOutcome:
        """Return our number and whether the statement held."""
        finding = self.find()
        return ClaimOutcome(self.where, self.says, finding.number, finding.checks, finding.held)


_CLAIMS: Final[tuple[ThesisClaim, ...]] = tuple(
    ThesisClaim(*row)
    for table in (theory.CLAIMS, nonlinear.CLAIMS, theory.INPUT_CLAIMS)
    for row in table
)


def thesis_claims() -> tuple[ThesisClaim, ...]:
    """Return every statement that is put to the test, in the order of the thesis' chapters."""
    return _CLAIMS


def claims_page(outcomes: Sequence[ClaimOutcome]) -> str:
    """Return the table as a page of the manual (Markdown)."""
    lines = [
        "# What the thesis claims, recomputed",
        "",
        "A. H. Hauglid, *Nonlinear Mechanical Vibrations: The Effect of Gaps*, NTNU, 2018.",
        "Every number below is computed by `shakerproc study --thesis`, which also writes",
        "this page (`--out docs`). omega_e is the tallest peak of the acceleration periodogram",
        "of the whole run unless another estimator is named; its bins are 1/30 Hz wide for the",
        "sweeps over 30 s and 1/20 Hz for the runs of 20 s. Sweeps run upwards from 0 to 30 Hz",
        "over 30 s with 5 N, m = 1 kg, k = 1000 N/m, zeta = 0.01, unless said otherwise.",
        "",
        "What is checked stands with its value and what was wanted of it; the last column is",
        "the outcome of these checks. A trend may stray by the resolution that is named, and",
        "must exceed it in all. A remark that no check backs is not in the table: that the",
        "model of one mass needs 600 s of computing (sec. 6.3, 7.2) speaks of the author's",
        "computer, not of the physics.",
        "",
        "| where | thesis | our number | checked | held? |",
        "|---|---|---|---|---|",
    ]
    for o in outcomes:
        checked = "; ".join(str(check) for check in o.checks)
        texts = (o.where, o.says, o.number, checked, o.held)
        cells = (text.replace("|", "\\|") for text in texts)
        lines.append(f"| {' | '.join(cells)} |")
    totals = {verdict: sum(o.held == verdict for o in outcomes) for verdict in VERDICTS}
    counts = ", ".join(f"{count} {verdict}" for verdict, count in totals.items() if count)
    return "\n".join([*lines, "", f"Of {len(outcomes)} statements: {counts}.", ""])
