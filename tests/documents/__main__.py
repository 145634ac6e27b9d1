"""``python -m tests.documents [KIND...]``: traps, bombs and mistakes, each in its own process.

Prints how many there are, how many are refused with line and column, the slowest and the one
that takes most memory. Exit status 1 if one takes half a second or 100 MB.
"""

import json
import os
import re
import sys
import tempfile
import time
from pathlib import Path

from tests.documents.test_bombs import BOMBS, write
from tests.documents.test_yaml_traps import READ, REFUSED, Anything
from tests.testlog.test_mistakes import GOOD, MISTAKES

from shakerproc.documents import read_document
from shakerproc.errors import DocumentError
from shakerproc.testlog import read_testlog

SECONDS, MEGABYTES = 0.5, 100.0


def without_mark(text):
    return text.replace(b"\xa7", b"") if isinstance(text, bytes) else text.replace("§", "")


def traps():
    """The traps; what is refused, and what is read as YAML 1.2 has it."""
    refused = [without_mark(text) for text, _ in REFUSED.values()]
    return [*refused, *(text for text, _ in READ.values())]


def bombs():
    """The bombs; None is a file of 300 MB."""
    return [text for text, _ in BOMBS.values()]


def mistakes():
    """The good log with one mistake each."""
    return [without_mark(GOOD.replace(old, new, 1)) for old, new, _ in MISTAKES]


def read_trap(path):
    read_document(path, Anything)


KINDS = {
    "traps": (traps, read_trap),
    "bombs": (bombs, read_testlog),
    "mistakes": (mistakes, read_testlog),
}


def peak():
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


def attempt(read, path):
    """What a process of its own says: seconds, megabytes, message."""
    mine, theirs = os.pipe()
    if os.fork() == 0:
        before, start, message = peak(), time.process_time(), ""
        try:
            read(path)
        except DocumentError as error:
            message = str(error)
        told = json.dumps([time.process_time() - start, peak() - before, message])
        os.write(theirs, told.encode())
        os._exit(0)
    os.close(theirs)
    with os.fdopen(mine, "rb") as stream:
        found = json.loads(stream.read())
    os.wait()
    return found


def figures(kind, folder):
    """How many, how many refused, how many of these with line and column, slowest, largest."""
    texts, read = KINDS[kind]
    found = []
    for number, text in enumerate(texts()):
        path = folder / f"{kind}_{number}.yaml"
        if isinstance(text, bytes):
            path.write_bytes(text)
        else:
            write(path, text)
        found.append(attempt(read, path))
    refused = [message for _, _, message in found if message]
    at = re.compile(r"\S+\.yaml:\d+:\d+: [^\n]+")
    placed = sum(at.fullmatch(message) is not None for message in refused)
    return (
        len(found),
        len(refused),
        placed,
        max(s for s, _, _ in found),
        max(m for _, m, _ in found),
    )


def main():
    good = True
    sys.stdout.write("| kind | n | refused | with line and column | slowest s | most MB |\n")
    sys.stdout.write("|------|---|---------|----------------------|-----------|---------|\n")
    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "good.yaml").write_text(GOOD, encoding="utf-8")
        read_testlog(Path(name) / "good.yaml")  # so that imports are not counted to the first
        for kind in sys.argv[1:] or KINDS:
            n, refused, placed, seconds, megabytes = figures(kind, Path(name))
            good &= seconds < SECONDS and megabytes < MEGABYTES and placed == refused
            row = f"| {kind} | {n} | {refused} | {placed} | {seconds:.3f} | {megabytes:.1f} |\n"
            sys.stdout.write(row)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
