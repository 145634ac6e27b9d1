"""python -m blind: draw hidden campaigns, diagnose them, print the score."""

import argparse
import json
import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path

from blind import folder, ranges, score
from blind.campaigns import TUNING_SEEDS_END, classes, draw
from blind.trial import Trial, attempt, first_named, hit

MORE = (
    "chain:gap",
    "chain3:gap",
    "chain:cubic_stiffness",
    "force:gap",
    "force:cubic_stiffness",
)


def arguments(words: list[str] | None = None) -> argparse.Namespace:
    """Return the options."""
    parser = argparse.ArgumentParser(prog="python -m blind", description=__doc__)
    parser.add_argument("--seed", type=int, default=0, help="first seed; 100000 and on: once")
    parser.add_argument("--each", type=int, default=2, help="campaigns of every class")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes")
    parser.add_argument(
        "--classes", default="", help="comma between; 'more': chains and forces too;"
        " 'effects', 'faults', 'others' or class names (default: all of the standard score)",
    )  # fmt: skip
    parser.add_argument("--json", type=Path, help="write every trial here")
    parser.add_argument("--write", type=Path, help="only write the campaigns into this folder")
    return parser.parse_args(words)


def chosen(text: str) -> list[str]:
    """Return the classes that a --classes text means."""
    groups = {
        "": list(classes()),
        "more": [*classes(), *MORE],
        "effects": list(ranges.EFFECTS),
        "faults": list(ranges.FAULTS),
        "others": ["none", "unexercised", "outside", "pair"],
        "chains": list(MORE),
    }
    if text in groups:
        return groups[text]
    return [
        kind for name in text.split(",") for kind in groups.get(name.strip(), [name.strip()])
    ]


def run(tasks: list[tuple[int, str]], jobs: int) -> list[Trial]:
    """Return the trials, in the order of the tasks; progress goes to stderr."""
    trials: dict[tuple[int, str], Trial] = {}
    if jobs <= 1:
        for task in tasks:
            trials[task] = attempt(*task)
            _progress(trials[task], len(trials), len(tasks))
        return [trials[task] for task in tasks]
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        futures = {pool.submit(attempt, *task): task for task in tasks}
        for future in as_completed(futures):
            trials[futures[future]] = future.result()
            _progress(future.result(), len(trials), len(tasks))
    return [trials[task] for task in tasks]


def _progress(trial: Trial, done: int, total: int) -> None:
    mark = "ok  " if hit(trial) else "MISS"
    print(
        f"{done:4d}/{total} {mark} {trial.kind} {trial.seed}: {first_named(trial)}"
        f" ({trial.seconds:.0f} s) {trial.problem}",
        file=sys.stderr, flush=True,
    )  # fmt: skip


def main() -> None:
    """Draw, diagnose, score."""
    options = arguments()
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    kinds = chosen(options.classes)
    tasks = [(options.seed + i, kind) for kind in kinds for i in range(options.each)]
    if options.write:
        for seed, kind in tasks:
            place = options.write / f"{kind.replace(':', '_').replace('+', '_')}_{seed}"
            folder.write(campaign := draw(seed, kind), place)
            (place / "truth.json").write_text(json.dumps(campaign.truth, indent=1), "utf-8")
            print(place)
        return
    start = time.perf_counter()
    trials = run(tasks, options.jobs)
    use = "tuning" if options.seed < TUNING_SEEDS_END else "looked at once"
    print(f"blind trials, seeds {options.seed} to {options.seed + options.each - 1} ({use})")
    print(score.report(trials))
    print(
        f"\n{len(trials)} campaigns in {time.perf_counter() - start:.0f} s, {options.jobs} jobs"
    )
    if options.json:
        document = {"summary": score.summary(trials), "trials": [t.as_json() for t in trials]}
        options.json.write_text(json.dumps(document, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
