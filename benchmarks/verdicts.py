"""Every ready-made study and every statement of the thesis: do both judge a figure alike.

python -m benchmarks.verdicts
"""

import re
import sys
from pathlib import Path

from shakerproc.studies import read_study, run_study
from shakerproc.verification import thesis_claims

STUDIES = Path(__file__).parents[1] / "configs" / "studies"
BOTH = {
    "figure_3_01": "fig. 3.1",
    "figure_3_10": "eq. 3.42",
    "figure_4_02": "fig. 4.2",
    "figure_4_02_literal": "eq. 3.14",
    "figure_4_03": "fig. 4.3",
    "figure_4_04": "fig. 4.4",
    "figure_4_05": "fig. 4.5",
    "figure_4_09": "fig. 4.9|rest",
    "figure_4_09_listing": "fig. 4.9|listing",
    "figure_4_12": "fig. 4.12",
    "figure_4_16": "fig. 4.16|begun at 0",
    "figure_4_16_cosine": "fig. 4.16|cosine",
    "figure_4_19": "fig. 4.19",
    "figure_5_14": "eq. 5.5",
    "figure_6_10": "fig. 6.10",
    "gap_response": "sec. 6.3",
}
"""Studies, and phrases that only the statement about the same figure has."""


def main() -> int:
    """Print every verdict; return how many figures are judged in two ways."""
    claims = {f"{c.where} {c.says}": c.outcome().held for c in thesis_claims()}
    differing = 0
    for path in sorted(STUDIES.glob("*.yaml")):
        verdict = run_study(read_study(path), workers=2).outcome
        words = BOTH.get(path.stem, "").split("|")
        other = [
            held for says, held in claims.items() if all(_in(word, says) for word in words)
        ]
        known = path.stem in BOTH
        differs = known and other != [verdict]
        differing += differs
        note = f"  thesis: {', '.join(other)}" if known else ""
        print(f"{path.stem:24s} {verdict}{note}{'  DIFFERS' if differs else ''}", flush=True)
    print(f"{differing} of {len(BOTH)} figures are judged in two ways")
    return differing


def _in(word: str, text: str) -> bool:
    return re.search(rf"(?<![\w.]){re.escape(word)}(?![\w])", text) is not None


if __name__ == "__main__":
    sys.exit(min(main(), 1))
