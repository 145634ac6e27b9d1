"""Ctrl-C while the program is still being loaded."""

import signal
import subprocess
import sys
import time

import pytest


def _heeding():
    """Heed the signal: what a shell starts in the background ignores it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


SLOW = """\
import sys, time
class Slow:
    def find_spec(self, name, path, target=None):
        if name == "shakerproc.model_files" or name == "shakerproc.testlog":
            print("at work", flush=True)
            time.sleep(30)
sys.meta_path.insert(0, Slow())
from shakerproc.__main__ import main
main()
"""


def _interrupted(folder, *arguments):
    """Interrupt a command at work; return its status and what it said."""
    program = subprocess.Popen(
        [sys.executable, "-c", SLOW, *arguments],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=_heeding,  # noqa: PLW1509
    )
    assert program.stdout.readline() == "at work\n"
    time.sleep(0.05)
    program.send_signal(signal.SIGINT)
    _, said = program.communicate(timeout=20)
    return program.returncode, [line for line in said.splitlines() if line]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT for one process")
@pytest.mark.parametrize("command", ["compare", "batch"])
def test_an_interrupt_of_a_command_at_work_is_one_line_and_130(tmp_path, command):
    (tmp_path / "model.yaml").touch()
    (tmp_path / "log.yaml").touch()
    files = ["log.yaml"] if command == "batch" else ["model.yaml", "log.yaml"]
    status, said = _interrupted(tmp_path, command, *files)
    assert (status, said) == (130, ["stopped by the user; nothing was written"])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["log.yaml", "model.yaml"]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT for one process")
def test_an_interrupt_while_the_program_is_loaded_is_one_word_and_130():
    """A module of the command line that takes its time: the signal comes while it loads."""
    slow = (
        "import sys, time, types\n"
        "class Slow:\n"
        "    def find_spec(self, name, path, target=None):\n"
        "        if name == 'shakerproc.cli':\n"
        "            print('loading', flush=True)\n"
        "            time.sleep(30)\n"
        "sys.meta_path.insert(0, Slow())\n"
        "from shakerproc.__main__ import main\n"
        "main()\n"
    )
    program = subprocess.Popen(
        [sys.executable, "-c", slow],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=_heeding,  # noqa: PLW1509
    )
    assert program.stdout.readline() == "loading\n"
    time.sleep(0.05)
    program.send_signal(signal.SIGINT)
    _, said = program.communicate(timeout=20)
    assert (program.returncode, said) == (130, "stopped by the user; nothing was written\n")
