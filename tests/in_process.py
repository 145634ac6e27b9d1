"""The command line within the process of the tests."""

import contextlib
import os
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path
from unittest import mock

from shakerproc.cli import main
from shakerproc.model_files import effect_files


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


def completed(*arguments, cwd=None, env=None, merged=False):
    """Run a command; return what a process of its own would, without the seconds of its start.

    What is printed goes through descriptors of its own, as a pipe's would, that of worker
    processes included; `merged` has stderr in stdout.
    """
    kept, streams = [os.dup(number) for number in (1, 2)], (sys.stdout, sys.stderr)
    with (
        tempfile.TemporaryFile() as out,
        tempfile.TemporaryFile() as errors,
        contextlib.chdir(cwd or Path.cwd()),
        mock.patch.dict(os.environ, env or {}),
        warnings.catch_warnings(),
    ):
        targets = (out, out) if merged else (out, errors)
        # pyuff leaves to the collector what it has read and written
        warnings.filterwarnings("ignore", r"unclosed file .*\.uff", ResourceWarning)
        try:
            for number, (file, stream) in enumerate(zip(targets, streams, strict=True), 1):
                stream.flush()
                os.dup2(file.fileno(), number)
            sys.stdout, sys.stderr = (
                open(number, "w", 1, encoding="utf-8", closefd=False)  # noqa: SIM115
                for number in (1, 2)
            )
            status = run(*arguments)
            sys.stdout.flush()
            sys.stderr.flush()
        finally:
            effect_files.forget_effects()  # of --effects, which end with a process
            sys.stdout, sys.stderr = streams
            for number, descriptor in enumerate(kept, 1):
                os.dup2(descriptor, number)
                os.close(descriptor)
        texts = []
        for file in (out, errors):
            file.seek(0)
            texts.append(file.read().decode("utf-8"))
    return subprocess.CompletedProcess(list(arguments), status, *texts)
