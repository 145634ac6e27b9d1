"""The quick tests on the oldest versions that pyproject.toml allows, in a venv of its own.

The wheel is built and installed with the lowest allowed version of each run-time dependency,
under the lowest allowed Python. What those need in turn, and what the tests need, may be any.
"""

import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "build" / "oldest"
EXTRAS = ("cluster",)
"""What belongs to running the program, beside its dependencies."""

TOOLS = ("docs", "test")
"""What the tests need; of these any version will do."""

_BOUND = re.compile(r"(?P<name>[\w.-]+)\s*>=\s*(?P<lowest>[\w.]+)")
_OTHERS_WARNINGS = ("DeprecationWarning", "PendingDeprecationWarning", "FutureWarning")


def project():
    """Return the table [project] of pyproject.toml."""
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def lowest(requirements):
    """Return requirements ("numpy>=2.0") as pins of their lower bounds ("numpy==2.0").

    Raises
    ------
    ValueError
        If a requirement is anything but a name and a lower bound.
    """
    pins = []
    for requirement in requirements:
        found = _BOUND.fullmatch(requirement)
        if found is None:
            raise ValueError(f"pyproject.toml: {requirement!r} has no plain lower bound, a>=b")
        pins.append(f"{found['name']}=={found['lowest']}")
    return pins


def pins():
    """Return the lowest allowed version of every run-time dependency."""
    table = project()
    extras = [one for extra in EXTRAS for one in table["optional-dependencies"][extra]]
    return lowest([*table["dependencies"], *extras])


def interpreter():
    """Return the oldest Python that is allowed, as a command.

    Raises
    ------
    SystemExit
        If this machine does not have it.
    """
    (pin,) = lowest(["python" + project()["requires-python"]])
    name = pin.replace("==", "")
    command = shutil.which(name)
    if command is None:
        raise SystemExit(f"{name} is not on the path: the oldest Python that is allowed")
    return command


def install(folder):
    """Make the venv anew, with the wheel of this checkout and the oldest it allows."""
    shutil.rmtree(folder, ignore_errors=True)
    subprocess.run([interpreter(), "-m", "venv", folder], check=True)
    constraints = folder / "oldest.txt"
    constraints.write_text("\n".join(pins()) + "\n", encoding="utf-8")
    leftovers = ROOT / "build" / "lib"  # setuptools would pack what an earlier build left there
    shutil.rmtree(leftovers, ignore_errors=True)
    pip = [folder / "bin" / "python", "-m", "pip", "--disable-pip-version-check", "install"]
    wanted = f"{ROOT}[{','.join((*EXTRAS, *TOOLS))}]"
    subprocess.run([*pip, "--quiet", "--constraint", constraints, wanted], check=True)
    shutil.rmtree(leftovers, ignore_errors=True)


def main(arguments):
    """Install, and run the quick tests; further arguments go to pytest."""
    sys.stdout.write("\n".join(pins()) + "\n")
    sys.stdout.flush()
    install(FOLDER)
    # what old packages call of newer ones may be deprecated: no fault of this project
    quiet = [word for kind in _OTHERS_WARNINGS for word in ("-W", f"ignore::{kind}")]
    tests = [FOLDER / "bin" / "python", "-m", "pytest", "-m", "not slow", *quiet, *arguments]
    return subprocess.run(tests, cwd=ROOT, check=False).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
