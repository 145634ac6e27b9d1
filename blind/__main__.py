"""python -m blind: draw hidden campaigns, diagnose them, print the score."""

import argparse
import functools
import json
import os
import sys
import time
from pathlib import Path

from blind import classes, folder, next_test, runner, score
from blind.campaigns import TUNING_SEEDS_END, draw
from blind.judging import exact, first_named, tied
from blind.trial import Trial, append_trial, read_trials, remaining_tasks


def arguments(words: list[str] | None = None) -> argparse.Namespace:
    """Return the options."""
    parser = argparse.ArgumentParser(prog="python -m blind", description=__doc__)
    add = parser.add_argument
    add("--seed", type=int, default=0, help="first seed; 100000 and on: looked at once")
    add("--each", type=int, default=2, help="campaigns of a class without *COUNT")
    add("--jobs", type=int, default=os.cpu_count() or 1, help="processes")
    add("--nice", type=int, default=0, help="niceness of the processes")
    add("--limit-s", type=float, default=180.0, help="processor seconds of one campaign")
    add(
        "--classes", default="standard",
        help=f"classes or groups ({', '.join(classes.GROUPS)}), commas between; `frozen`: all"
        " that a frozen commit is asked",
    )  # fmt: skip
    add("--json", type=Path, help="append every trial here, and leave out those it holds")
    add("--score", type=Path, help="only score the trials of this file")
    add("--against", type=Path, help="with --score: class by class beside these trials")
    add("--summary", type=Path, help="write the figures of the score here (JSON)")
    add("--next-test", type=Path, help="carry out what the open trials of this file propose")
    add("--write", type=Path, help="only write the campaigns into this folder")
    return parser.parse_args(words)


def _progress(trial: Trial, done: int, total: int) -> None:
    mark = "ok  " if exact(trial) else ("tie " if tied(trial) else "MISS")
    print(
        f"{done:4d}/{total} {mark} {trial.kind} {trial.seed}: {first_named(trial)}"
        f" ({trial.cpu_seconds:.0f} s) {trial.problem}",
        file=sys.stderr, flush=True,
    )  # fmt: skip


def write(tasks: list[tuple[int, str]], target: Path) -> None:
    """Write campaigns with their truths, and print where."""
    for seed, kind in tasks:
        place = target / f"{kind.translate(str.maketrans(':+@', '___'))}_{seed}"
        folder.write(campaign := draw(seed, kind), place)
        (place / "truth.json").write_text(json.dumps(campaign.truth, indent=1), "utf-8")
        print(place)


def trials_of(options: argparse.Namespace, tasks: list[tuple[int, str]]) -> list[Trial]:
    """Return the trials, those of an earlier run too; Ctrl-C ends early, with what there is."""
    done = read_trials(options.json) if options.json else []
    work = runner.first
    if options.next_test:
        work = functools.partial(runner.retest, path=options.next_test)
    left = remaining_tasks(tasks, done)
    running = runner.run(left, work, options.jobs, options.limit_s, options.nice)
    try:
        for trial in running:
            done.append(trial)
            _progress(trial, len(done), len(tasks))
            if options.json:
                append_trial(options.json, trial)
    except KeyboardInterrupt:
        running.close()
        print(f"stopped after {len(done)} of {len(tasks)}", file=sys.stderr)
    return done


def tell(trials: list[Trial], options: argparse.Namespace) -> None:
    """Print the score, and keep its figures where that is asked."""
    print(score.report(trials))
    if options.against:
        print("\n" + score.tables.against(trials, read_trials(options.against)))
    if options.summary:
        options.summary.write_text(json.dumps(score.summary(trials), indent=1), "utf-8")


def main() -> None:
    """Draw, diagnose, score."""
    options = arguments()
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    if options.score:
        tell(read_trials(options.score), options)
        return
    wanted = classes.FROZEN if options.classes == "frozen" else options.classes
    tasks = classes.tasks(classes.expand(wanted, options.each), options.seed)
    if options.next_test:
        open_ends = next_test.open_ends(read_trials(options.next_test))
        tasks = [(trial.seed, trial.kind) for trial in open_ends]
    if options.write:
        write(tasks, options.write)
        return
    start = time.perf_counter()
    trials = trials_of(options, tasks)
    use = "tuning" if options.seed < TUNING_SEEDS_END else "looked at once"
    print(f"blind trials from seed {options.seed} ({use})")
    tell(trials, options)
    print(f"\n{len(trials)} campaigns in {time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main()
