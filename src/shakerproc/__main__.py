"""``python -m shakerproc``."""

from shakerproc.cli import main

if __name__ == "__main__":  # worker processes import this module too
    main()
