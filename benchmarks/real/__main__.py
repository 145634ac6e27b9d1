"""Judge real and published sets: python -m benchmarks.real [SET...] [--json FILE]."""

import argparse
import json
import sys
import tempfile
from pathlib import Path

from configs.benchmarks import convert

from benchmarks.real import loop, steps


def main() -> int:
    """Print a line for each set; return 1 where one failed."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.real")
    parser.add_argument("sets", nargs="*", metavar="SET", help=", ".join(convert.SETS))
    parser.add_argument("--rounds", type=int, default=2, help="turns of the loop")
    parser.add_argument("--limit-s", type=int, default=steps.LIMIT_S, help="of each diagnosis")
    parser.add_argument("--folder", type=Path, help="keep models and results here")
    parser.add_argument("--json", type=Path, metavar="FILE")
    given = parser.parse_args()
    unknown = set(given.sets) - set(convert.SETS)
    if unknown:
        parser.error(
            f"no set {', '.join(sorted(unknown))}; there are {', '.join(convert.SETS)}"
        )
    found = {}
    with tempfile.TemporaryDirectory() as temporary:
        place = given.folder or Path(temporary)
        for name in given.sets or convert.SETS:
            try:
                folder = convert.folder_of(name, place)
            except FileNotFoundError as error:
                print(f"{name:16s} left out: {error}", flush=True)
                continue
            found[name] = loop.judge(folder, rounds=given.rounds, limit=given.limit_s)
            print("\n".join(loop.lines_of(name, found[name])), flush=True)
    if given.json:
        given.json.write_text(json.dumps(loop.as_json(found), indent=1), encoding="utf-8")
    return int(any(turn.failure for turns in found.values() for turn in turns))


if __name__ == "__main__":
    sys.exit(main())
