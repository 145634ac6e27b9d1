"""The files that a command goes through, in the order in which it first enters them.

python -m benchmarks.walk -- process sample_data/recordings/Test_1/Acceleration.tdms --out OUT
python -m benchmarks.walk -- diagnose model.yaml testlog.yaml --out OUT

The command runs in this process; what its worker processes do is not seen. Left out is what is
called while a module is imported.
"""

import argparse
import sys
import threading
from inspect import CO_OPTIMIZED
from pathlib import Path
from types import FrameType

import shakerproc
from shakerproc.cli import main as run_command

ROOT = str(Path(shakerproc.__file__).parent) + "/"


class Walk:
    """What has been entered: a file and the first function of it that was called."""

    def __init__(self) -> None:
        self.first: dict[str, str] = {}

    def __call__(self, frame: FrameType, event: str, _argument: object) -> None:
        """Take note of a call."""
        code = frame.f_code
        place = code.co_filename
        if event != "call" or not place.startswith(ROOT) or not code.co_flags & CO_OPTIMIZED:
            return
        if place.removeprefix(ROOT) not in self.first and not is_importing(frame):
            self.first[place.removeprefix(ROOT)] = code.co_qualname


def is_importing(frame: FrameType | None) -> bool:
    """Return whether a module is being imported further up."""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


def main() -> None:
    """Run the command, and print the files."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "--functions", action="store_true", help="how many each file has called"
    )
    parser.add_argument("command", nargs="+")
    options = parser.parse_args()
    sys.argv = ["shakerproc", *options.command]
    walk = Walk()
    threading.setprofile(walk)
    sys.setprofile(walk)
    try:
        run_command()
    except SystemExit as end:
        print(f"exit status {end.code}")
    finally:
        sys.setprofile(None)
    for place, name in walk.first.items():
        print(f"{place}: {name}")
    print(f"{len(walk.first)} files")


if __name__ == "__main__":
    main()
