"""python -m blind.elastic: hidden effects in the feet of elastic bodies, diagnosed and counted.

The truth is a free beam by finite elements of its own on two to five feet, with more modes than
the model gets, whose frequencies are 1 % off, damping ratios 30 %, feet 20 %. Each seed draws
beam, feet, sensors (three to eight; feet without one among them), levels, and noise of 40 to 60
dB. Modes with the linear feet are turned exactly over each step; what is not linear kicks them
between (Strang splitting, of order 2).
"""

import argparse
import itertools
import json
import signal
import time
import zlib
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from blind.bodies import ELEMENTS, MODES, Body, beam, march
from blind.draws import Rng, log_uniform, sign

if TYPE_CHECKING:
    from shakerproc.models import Model

RATE, SECONDS, SUBSTEPS = 2048.0, 5.0, 14
CLASSES = ("gap", "cubic_stiffness", "jenkins", "coulomb_friction", "none", "softer")
CODES = {"gap": 1, "cubic_stiffness": 2, "jenkins": 3, "coulomb_friction": 4}
KEPT = 8  # modes of the model, two of them rigid; the truth has more
LEAST = 0.1  # share of the force of a foot that no spring and damper makes of the effect


@dataclass(frozen=True)
class Drawn:
    """What a seed and a class draw."""

    seed: int
    kind: str
    body: Body
    feet: tuple[int, ...]
    sensors: tuple[int, ...]
    stiffness: np.ndarray
    damping: np.ndarray
    at: int
    numbers: tuple[float, float]
    levels: tuple[float, ...]
    band: tuple[float, float]
    sweep: bool
    snr: float


@dataclass(frozen=True)
class Outcome:
    """What came out of one diagnosis; `within` counts numbers in their intervals, and all."""

    seed: int
    kind: str
    hidden: str
    feet: int
    sensors: int
    seen: bool
    said: str
    confidence: float | None
    right: bool
    wrong_joint: bool
    seconds: float
    sentence: str
    notes: tuple[str, ...] = ()
    numbers: dict[str, Any] | None = None
    problem: str = ""
    within: tuple[int, int] = (0, 0)


def _drive(drawn: Drawn, test: int) -> np.ndarray:
    """Return the base acceleration at the middles of the steps."""
    n = int(SECONDS * RATE) * SUBSTEPS
    t, rng = np.arange(n) / (RATE * SUBSTEPS), np.random.default_rng([drawn.seed, 7, test])
    low, high = drawn.band
    if drawn.sweep:
        growth = np.log(high / low) / (SECONDS - 1.0)
        wave = np.sqrt(2.0) * np.sin(2.0 * np.pi * low * np.expm1(growth * (t - 0.5)) / growth)
    else:
        f = np.fft.rfftfreq(n, 1.0 / (RATE * SUBSTEPS))
        spectrum = np.where((f >= low) & (f <= high), 1.0, 0.0) * np.exp(
            2j * np.pi * rng.random(f.size)
        )
        wave = np.fft.irfft(spectrum, n)
        wave /= wave.std()
    ends = np.minimum(
        np.clip((t - 0.5) / 0.1, 0.0, 1.0), np.clip((SECONDS - 0.3 - t) / 0.1, 0.0, 1.0)
    )
    return np.asarray(drawn.levels[test] * wave * 0.5 * (1.0 - np.cos(np.pi * ends)))


def _moved(drawn: Drawn, test: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return absolute accelerations of the sensors, the control, and what the effect does."""
    body, drive = drawn.body, _drive(drawn, test)
    foot = body.shapes[list(drawn.feet)]
    omega = 2.0 * np.pi * body.frequency
    square, turned = np.linalg.eigh(
        np.diag(omega**2) + foot.T @ (drawn.stiffness[:, None] * foot)
    )
    shapes, half = body.shapes @ turned, 0.5 / (RATE * SUBSTEPS)
    w = np.sqrt(square)
    decay = np.exp(-half * (turned**2).T @ (2.0 * body.ratio * omega) / 2.0)
    c, s = np.cos(w * half), np.sin(w * half)
    turn = np.array([c, s / w, -w * s, c]).T * decay[:, None]
    base = np.linalg.lstsq(shapes, np.ones(len(shapes)), rcond=None)[0]
    out = np.zeros((MODES, drive.size // SUBSTEPS))
    force = np.zeros((3, out.shape[1]))
    feet = shapes[list(drawn.feet)]
    on_feet = (turn, base, drawn.damping, feet, drawn.at, 2.0 * half)
    march(on_feet, (CODES.get(drawn.kind, 0), np.array(drawn.numbers)), drive, out, force)
    control = drive.reshape(-1, SUBSTEPS).mean(axis=1)
    seen = shapes[list(drawn.sensors)] @ out + control
    return _sampled(seen), _sampled(control), force


def _sampled(means: np.ndarray) -> np.ndarray:
    """Return samples from means over the intervals that follow, to 0.45 of the rate."""
    n = means.shape[-1]
    fade = means[..., -1:] * (0.5 + 0.5 * np.cos(np.linspace(0.0, np.pi, n)))
    both = np.concatenate([means, fade], axis=-1)  # what ends in motion does not wrap around
    share = np.fft.rfftfreq(2 * n)
    box = np.sinc(share) * np.exp(1j * np.pi * share)
    kept = 1.0 / (1.0 + (share / 0.45) ** 40)
    return np.fft.irfft(np.fft.rfft(both) * kept / box, 2 * n)[..., :n]


def draw(seed: int, kind: str) -> Drawn:
    """Return what a seed and a class draw, the effect exercised."""
    rng = np.random.default_rng([seed, zlib.crc32(kind.encode())])
    while True:
        first = log_uniform(rng, 60.0, 160.0)
        ratios = np.array([
            0.0,
            0.0,
            *(log_uniform(rng, 0.003, 0.01) for _ in range(MODES - 2)),
        ])
        mass = log_uniform(rng, 0.5, 5.0)
        body = beam(first, mass, ratios)
        count = int(rng.integers(2, 6))
        sections = np.linspace(0, ELEMENTS, count + 1)
        feet = tuple(
            int(rng.uniform(a + 0.5, b - 0.5) + 0.5) for a, b in itertools.pairwise(sections)
        )
        n_sensors = int(rng.integers(3, 9))
        sensors = tuple(
            int(i) for i in np.sort(rng.choice(ELEMENTS + 1, n_sensors, replace=False))
        )
        omega = 2.0 * np.pi * first * rng.uniform(0.5, 1.2)
        stiffness = mass / count * omega**2 * np.exp(rng.uniform(-0.4, 0.4, count))
        damping = (
            2.0
            * np.array([log_uniform(rng, 0.005, 0.03) for _ in range(count)])
            * stiffness
            / omega
        )
        level = log_uniform(rng, 1.0, 10.0)
        ratio = rng.uniform(1.7, 3.0)
        drawn = Drawn(
            seed, "none", body, feet, sensors, stiffness, damping, int(rng.integers(count)),
            (0.0, 0.0), tuple(level * s for s in (1.0 / ratio, 1.0, ratio, np.sqrt(ratio))),
            (20.0, min(first * rng.uniform(4.0, 6.0), 700.0)), bool(rng.random() < 0.4),
            rng.uniform(40.0, 60.0),
        )  # fmt: skip
        drawn = _hidden(rng, drawn, kind)
        if kind in {"none", "softer"} or _exercised(drawn):
            return drawn


def _hidden(rng: Rng, drawn: Drawn, kind: str) -> Drawn:
    """Return a draw with the effect in its foot, in units of how that moves without any."""
    if kind == "none":
        return drawn
    k, at = drawn.stiffness.copy(), drawn.at
    own = k[at]
    if kind in {"gap", "jenkins", "softer"}:
        k[at] *= rng.uniform(0.25, 0.45) if kind == "softer" else rng.uniform(0.3, 0.8)
    drawn = replace(drawn, stiffness=k)
    if kind == "softer":
        return replace(drawn, kind=kind)
    _, _, force = _moved(drawn, 2)
    z = float(np.sqrt(force[1].std() * np.max(np.abs(force[1]))))
    numbers = {
        "gap": lambda: (own * rng.uniform(0.5, 1.5), z * rng.uniform(0.2, 0.7)),
        "cubic_stiffness": lambda: (own * log_uniform(rng, 0.1, 1.0) / z**2, 0.0),
        "jenkins": lambda: (own * rng.uniform(0.3, 1.0), z * rng.uniform(0.1, 0.5)),
        "coulomb_friction": lambda: (k[at] * z * log_uniform(rng, 0.05, 0.4), 0.0),
    }[kind]()
    return replace(drawn, kind=kind, numbers=numbers)


def _exercised(drawn: Drawn) -> bool:
    """Whether no spring and damper makes of the effect what it does."""
    _, _, (force, z, w) = _moved(drawn, 2)
    beside = np.array([z / z.std(), w / w.std()])
    left = force - np.linalg.lstsq(beside.T, force, rcond=None)[0] @ beside
    foot = drawn.stiffness[drawn.at] * z + force
    return bool(np.isfinite(left).all() and left.std() > LEAST * foot.std())


def place(drawn: Drawn, node: int) -> str:
    """Return what a node is called."""
    return f"foot {drawn.feet.index(node) + 1}" if node in drawn.feet else f"node {node}"


def model_of(drawn: Drawn, rng: Rng) -> "Model":
    """Return what the laboratory has: modes and feet that are off, and no effect."""
    from shakerproc.models import Element, Excitation, Model, Sensor
    from shakerproc.models.effects import Damper, Spring
    from shakerproc.models.structure import Structure, StructureMode

    nodes = sorted({*drawn.feet, *drawn.sensors})
    frequency = drawn.body.frequency[:KEPT] * (1.0 + 0.01 * rng.standard_normal(KEPT))
    ratio = drawn.body.ratio[:KEPT] * np.exp(0.3 * rng.standard_normal(KEPT))
    modes = tuple(
        StructureMode(float(f), float(r), tuple(shape))
        for f, r, shape in zip(frequency, ratio, drawn.body.shapes[nodes].T, strict=False)
    )
    k = drawn.stiffness * (1.0 + 0.2 * rng.uniform(-1.0, 1.0, len(drawn.feet)))
    if drawn.kind == "softer":
        k[drawn.at] = drawn.stiffness[drawn.at] / rng.uniform(0.25, 0.45)
    c = drawn.damping * np.exp(0.3 * np.array([sign(rng) for _ in drawn.feet]))
    elements = [
        Element(law, ("base", f"foot {i + 1}"))
        for i in range(len(drawn.feet))
        for law in (Spring(stiffness=float(k[i])), Damper(damping=float(c[i])))
    ]
    names = tuple(place(drawn, node) for node in nodes)
    sensors = {f"s{i}": Sensor(place(drawn, node)) for i, node in enumerate(drawn.sensors)}
    return Model(
        f"elastic {drawn.seed}", {}, tuple(elements), Excitation("base acceleration"), sensors,
        structures={"body": Structure(names, modes)},
    )  # fmt: skip


def true_numbers(drawn: Drawn) -> dict[str, float]:
    """Return the numbers of the effect that is hidden, as the library names them."""
    first, second = (float(one) for one in drawn.numbers)
    return {
        "gap": {"stiffness": first, "clearance": second},
        "cubic_stiffness": {"coefficient": first},
        "jenkins": {"stiffness": first, "slip_force": first * second},
        "coulomb_friction": {"sliding_force": first},
    }.get(drawn.kind, {})


def _held(drawn: Drawn, found: dict[str, Any]) -> tuple[int, int]:
    """Return how many numbers of an effect that was found right lie in their intervals."""
    true = true_numbers(drawn)
    told = [(true[name], *found[name][1:]) for name in true if name in found]
    held = sum(
        (low is None or low <= x) and (high is None or x <= high) for x, low, high in told
    )
    return held, len(told)


def _late(*_: object) -> None:
    raise TimeoutError("no verdict within the limit")


def judge(seed: int, kind: str, limit_s: float = 0.0) -> Outcome:
    """Return what a diagnosis makes of a draw, given so many seconds of processor (0: any)."""
    from shakerproc.diagnosis.api import diagnose_arrays
    from shakerproc.diagnosis.data import TestArrays

    drawn = draw(seed, kind)
    rng = np.random.default_rng([seed, 11])
    model = model_of(drawn, rng)
    tests = []
    share = 10.0 ** (-drawn.snr / 20.0)
    moved = [_moved(drawn, i) for i in range(4)]
    for i, (seen, control, _) in enumerate(moved):
        noise = share * moved[1][0].std(axis=1, keepdims=True)
        both = control + share * moved[1][1].std() * rng.standard_normal((2, control.size))
        tests.append(TestArrays(
            f"test {i + 1}", RATE, both, seen + noise * rng.standard_normal(seen.shape), i == 3,
            excitation="sine sweep" if drawn.sweep else "random", band=drawn.band,
        ))  # fmt: skip
    begun = time.process_time()
    signal.signal(signal.SIGPROF, _late)
    signal.setitimer(signal.ITIMER_PROF, limit_s)
    try:
        found = diagnose_arrays(model, tests)
    except Exception as error:  # noqa: BLE001 - any failure is a miss, and is told
        return _outcome(
            drawn, "failed", None, [], begun, problem=f"{type(error).__name__}: {error}"
        )
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
    named = [(one.kind, one.between[-1]) for one in found.effects]
    out = _outcome(drawn, found.verdict, found.confidence, named, begun)
    numbers = {
        name: [n.value, n.low, n.high]
        for one in found.effects
        for name, n in one.parameters.items()
    }
    return replace(
        out, sentence=found.sentence, notes=tuple(found.notes), numbers=numbers,
        within=_held(drawn, numbers) if out.right else (0, 0),
    )  # fmt: skip


def _outcome(
    drawn: Drawn, verdict: str, confidence: float | None, named: list[tuple[str, str]],
    begun: float, *, problem: str = "",
) -> Outcome:  # fmt: skip
    kind, foot = drawn.kind, f"foot {drawn.at + 1}"
    linear = kind in {"none", "softer"}
    right = verdict == "nothing missing" if linear else named == [(kind, foot)]
    wrong = any(where != foot or linear for _, where in named)
    said = " + ".join(f"{what}@{where}" for what, where in named) or verdict
    seen = drawn.feet[drawn.at] in drawn.sensors
    return Outcome(
        drawn.seed, kind, foot, len(drawn.feet), len(drawn.sensors), seen, said, confidence,
        right, wrong, time.process_time() - begun, "", problem=problem,
    )  # fmt: skip


def main() -> None:
    """Judge draws of all classes, one after the other."""
    parser = argparse.ArgumentParser(prog="python -m blind.elastic", description=__doc__)
    parser.add_argument("--seed", type=int, default=600000, help="first seed")
    parser.add_argument("--each", type=int, default=1, help="draws of a class")
    parser.add_argument("--classes", default=",".join(CLASSES), help="commas between")
    parser.add_argument("--limit-s", type=float, default=0.0, help="processor of each; 0: any")
    parser.add_argument("--json", type=Path, help="append every outcome here")
    options = parser.parse_args()
    outcomes = []
    for seed in range(options.seed, options.seed + options.each):
        for kind in options.classes.split(","):
            one = judge(seed, kind, options.limit_s)
            outcomes.append(one)
            mark = "right" if one.right else "WRONG JOINT" if one.wrong_joint else "not right"
            seen = "seen" if one.seen else "unseen"
            print(f"{mark:11s} {kind} {seed} in {one.hidden} of {one.feet} ({one.sensors} "
                  f"sensors, {seen}): {one.said}, {one.confidence}, {one.seconds:.0f} s "
                  f"{one.problem}", flush=True)  # fmt: skip
            if options.json:
                with options.json.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(asdict(one)) + "\n")
    right, wrong = sum(o.right for o in outcomes), sum(o.wrong_joint for o in outcomes)
    sure = sum(o.wrong_joint and (o.confidence or 0.0) > 0.9 for o in outcomes)
    held, told = (sum(o.within[i] for o in outcomes) for i in range(2))
    print(f"{right} of {len(outcomes)} right; a wrong joint, or an effect where there is none, "
          f"in {wrong}, above 0.9 in {sure}; {held} of {told} numbers within their intervals; "
          f"{np.median([o.seconds for o in outcomes]):.0f} s of processor in the median, "
          f"{max(o.seconds for o in outcomes):.0f} at most")  # fmt: skip


if __name__ == "__main__":
    main()
