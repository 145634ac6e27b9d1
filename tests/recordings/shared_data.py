"""``python -m tests.recordings.shared_data [FOLDER]``: each file read, or refused in one line.

Prints a table of all recordings below a folder, by default those that the tests read.
"""

import sys
from pathlib import Path

from shakerproc.errors import RecordingError
from shakerproc.recordings import health, open_recording

FOLDER = Path(__file__).parents[3] / "shared" / "data"


def outcome(path):
    """What becomes of a file as it is, without a log."""
    try:
        with open_recording(path) as recording:
            recording.samples()
            flags = ", ".join(sorted({flag.kind for flag in health(recording)}))
            n, rate = len(recording.channels), recording.sample_rate
            return f"read: {n} channels at {rate:g} Hz" + (f"; {flags}" if flags else "")
    except RecordingError as error:
        return f"refused: {error}"


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER
    told = {path: outcome(path) for path in sorted(folder.glob("*/*")) if path.is_file()}
    for path, text in told.items():
        sys.stdout.write(f"{path.relative_to(folder)}: {text}\n")
    read = sum(text.startswith("read") for text in told.values())
    sys.stdout.write(f"{len(told)} files: {read} read, {len(told) - read} refused\n")


if __name__ == "__main__":
    main()
