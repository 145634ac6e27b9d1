"""The command line within the process of the tests."""

import sys

from shakerproc.cli import main


def run(*arguments):
    """Run a command; return its exit status."""
    before = sys.argv
    sys.argv = ["shakerproc", *map(str, arguments)]
    try:
        main()
    except SystemExit as left:
        return left.code or 0
    finally:
        sys.argv = before
    return 0
