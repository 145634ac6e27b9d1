"""``python -m shakerproc``, and the command of that name."""

import sys


def main() -> None:
    """Run the command line; Ctrl-C while it is being loaded ends it as at any other time."""
    try:
        from shakerproc import cli
    except KeyboardInterrupt:
        sys.stderr.write("stopped by the user; nothing was written\n")
        sys.exit(130)
    cli.main()


if __name__ == "__main__":  # worker processes import this module too
    main()
