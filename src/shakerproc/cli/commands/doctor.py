"""``shakerproc doctor``."""

import os
import platform
import re
import shutil
import sys
import time
from dataclasses import asdict, dataclass
from importlib.metadata import EntryPoint, entry_points
from typing import Any, final

from shakerproc import __version__
from shakerproc.cli import output
from shakerproc.errors import ShakerprocError
from shakerproc.numerals import numeral


@final
@dataclass(frozen=True, slots=True)
class PlugIn:
    """One entry point of an installed package.

    Attributes
    ----------
    group, name, value : str
        As the package declares it.
    package : str
        Name and version of the package.
    brings : tuple of str
        Kinds of effects, or endings of files.
    problem : str
        Why it cannot be used, in a line; empty where it can.
    """

    group: str
    name: str
    value: str
    package: str
    brings: tuple[str, ...] = ()
    problem: str = ""

    def as_json(self) -> dict[str, Any]:
        """Return the part of a document."""
        return asdict(self)


def plug_ins() -> list[PlugIn]:
    """Return every effect and every reader of installed packages, broken ones included."""
    return [*_effects(), *_readers()]


def _effects() -> list[PlugIn]:
    from shakerproc.models import EFFECTS
    from shakerproc.models import own_effects as effects

    plug_ins, known = [], dict(EFFECTS.known)
    for entry in entry_points(group=effects.GROUP):
        try:
            kinds = effects.loaded(entry, known)
        except ShakerprocError as error:
            plug_ins.append(_plug_in(entry, problem=str(error)))
            continue
        known |= kinds
        plug_ins.append(_plug_in(entry, tuple(kinds)))
    return plug_ins


def _readers() -> list[PlugIn]:
    from shakerproc.recordings import READERS, opening

    readers = []
    taken = dict.fromkeys(READERS.known, "shakerproc itself")
    for entry in entry_points(group=opening.GROUP):
        ending = f".{entry.name.lower()}"
        problem = f"{ending} is read by {taken[ending]}" if ending in taken else ""
        try:
            opening.of_entry(entry)
        except ShakerprocError as error:
            problem = problem or str(error)
        taken.setdefault(ending, f"the package {_package(entry)}")
        readers.append(_plug_in(entry, () if problem else (ending,), problem))
    return readers


def _plug_in(entry: EntryPoint, brings: tuple[str, ...] = (), problem: str = "") -> PlugIn:
    return PlugIn(entry.group, entry.name, entry.value, _package(entry), brings, problem)


def _package(entry: EntryPoint) -> str:
    return "" if entry.dist is None else f"{entry.dist.name} {entry.dist.version}"


EXTRAS = {
    "cluster": "batch, study and diagnose on several machines (--scheduler)",
    "parquet": "recordings and tables in Parquet (.parquet), recordings in Feather",
    "xlsx": "recordings and a calibration sheet in XLSX",
    "recorders": "recordings in MDF (.mf4, .mdf), enDAQ IDE (.ide) and imc FAMOS (.raw)",
    "docs": "building the manual",
    "dev": "the tests and the checks of the code",
}
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome", "msedge")


@dataclass(frozen=True, slots=True)
class Package:
    """One package that shakerproc uses.

    Attributes
    ----------
    name, wanted : str
        Name and the versions that will do.
    installed : str or None
        Version that is here.
    extra : str
        Extra that brings it; empty for the core.
    """

    name: str
    wanted: str
    installed: str | None
    extra: str


def doctor(json: output.JsonOption = None) -> None:
    """List installed and missing packages, and the speed.

    Of missing packages the use is told. On its first run it compiles the simulation for this
    machine, so that later commands need not.
    """
    from shakerproc.cli.messages import announce

    announce()
    packages = _packages()
    brought = plug_ins()
    speed = _speed()
    missing = [p for p in packages if p.installed is None and not p.extra]
    extras = {
        name: [p.name for p in packages if p.extra == name and p.installed is None]
        for name in EXTRAS
    }
    browser = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    output.write_json(
        {
            "schema": "shakerproc-doctor/1",
            "shakerproc": __version__,
            "python": platform.python_version(),
            "system": platform.platform(),
            "processors": os.cpu_count(),
            "packages": {p.name: p.installed for p in packages},
            "missing": [p.name for p in missing],
            "missing_extras": extras,
            "browser": browser,
            "plug_ins": [one.as_json() for one in brought],
            "speed": speed,
        },
        json,
    )
    _print(packages, speed, extras, browser)
    for one in brought:
        what = f"{one.name} ({one.value}) of {one.package}"
        if one.problem:
            output.warning(f"plug-in {what}: {one.problem}")
        else:
            output.data(
                f"plug-in {what}: {one.group.rpartition('.')[2]} {', '.join(one.brings)}"
            )
    if missing:
        names = ", ".join(p.name for p in missing)
        output.message(f"error: {names} missing; install again: pip install shakerproc")
        output.finish(1)


def _packages() -> list[Package]:
    from importlib import metadata

    packages = []
    for line in metadata.requires("shakerproc") or []:
        requirement, _, marker = line.partition(";")
        match = re.match(r"([A-Za-z0-9._-]+)\s*(.*)", requirement.strip())
        extra = re.search(r"extra == ['\"](\w+)", marker)
        if match is not None:
            name, wanted = match.groups()
            packages.append(Package(name, wanted, _version(name), extra[1] if extra else ""))
    return packages


def _version(name: str) -> str | None:
    from importlib import metadata

    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def _speed() -> dict[str, float]:
    """Return the speed of the steps that dominate long batches and studies."""
    import hashlib

    import numpy as np
    from scipy import fft

    samples = np.random.default_rng(1).standard_normal((2048, 1024))
    fft.rfft(samples)
    start = time.perf_counter()
    fft.rfft(samples)
    transform = samples.size / (time.perf_counter() - start)
    start = time.perf_counter()
    hashlib.sha256(samples.tobytes()).hexdigest()
    return {
        "fft_samples_per_s": transform,
        "hash_bytes_per_s": samples.nbytes / (time.perf_counter() - start),
        "simulation_s": _simulation(),
    }


def _simulation() -> float:
    """Return how long 30 s of a joint with play take, once it is compiled [s]."""
    import numpy as np

    from shakerproc.simulation import first_calls, simulate

    first_calls.call_free_runs()
    model = first_calls.joint_with_play()
    shaking = np.random.default_rng(1).standard_normal(15_001)
    start = time.perf_counter()
    simulate(model, shaking, first_calls.RATE, growth=False)
    return time.perf_counter() - start


def _print(
    packages: list[Package],
    speed: dict[str, float],
    extras: dict[str, list[str]],
    browser: str | None,
) -> None:
    output.data(
        f"shakerproc {__version__}, Python {platform.python_version()} ({sys.executable}), "
        f"{platform.platform()}, {os.cpu_count()} processors"
    )
    rows = [(p.name, p.wanted, p.installed or "MISSING") for p in packages if not p.extra]
    output.print_table(("package", "wanted", "installed"), rows)
    output.data(
        f"speed: FFT {speed['fft_samples_per_s'] / 1e6:.0f} million samples/s, SHA-256 "
        f"{speed['hash_bytes_per_s'] / 1e6:.0f} MB/s, 30 s of a joint with play simulated in "
        f"{numeral(1e3 * speed['simulation_s'], 2)} ms"
    )
    for name, purpose in EXTRAS.items():
        state = f"missing {', '.join(extras[name])}" if extras[name] else "installed"
        output.data(
            f"extra {name}: {state}; for {purpose}"
            + (f"; pip install 'shakerproc[{name}]'" if extras[name] else "")
        )
    output.data(f"browser: {browser or 'none found'}; for a PDF of the report")
