"""What a command shows on a terminal."""

import os
import subprocess


def shown_on_terminal(command, **environment):
    """Run a command on a pseudo-terminal; return all that it wrote there."""
    import pty

    master, slave = pty.openpty()
    variables = {k: v for k, v in os.environ.items() if k != "NO_COLOR"}
    variables |= {"TERM": "xterm-256color", "COLUMNS": "120", "PYTHONUTF8": "1", **environment}
    with subprocess.Popen(command, stdout=slave, stderr=slave, env=variables) as process:
        os.close(slave)
        shown = b""
        while True:
            try:
                part = os.read(master, 65536)
            except OSError:
                break
            shown += part
            if not part:
                break
        process.wait(timeout=60)
    os.close(master)
    return shown.decode("utf-8")
