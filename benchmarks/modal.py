"""Modes of simulated structures found blind, and the same signals given to neighbours.

python -m benchmarks.modal [--draws 100] [--seed 0] [--verbose]
python -m benchmarks.modal --speed

3 to 12 modes, 20 s at 512 Hz, 8 accelerometers, 1 or 2 random forces, two pairs of modes 1 to
3 % apart (one pair of 3), damping 0.2 to 5 %, white noise 30 to 60 dB below the responses.
The signals are closed-form modal superposition (benchmarks/modal_signals.py), none of the
program's own code. sdypy-EMA and pyOMA-2 take part where they can be imported; they are told
the true frequencies and take the poles nearest to them, which spares them the choice.
"""

import argparse
import contextlib
import importlib.util
import io
import logging
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from benchmarks.modal_bounds import bound_of
from benchmarks.modal_signals import Structure, draw
from shakerproc.modal import Settings, identify_functions, identify_samples
from shakerproc.modal.output_only import identify_output_only
from shakerproc.modal.stabilisation import lagged_sums, stabilisation

BAND = (3.0, 205.0)
SEGMENT = 2560  # of the response functions for sdypy-EMA: 5 s, Hann, half overlapping


@dataclass
class Found:
    """What a method says: frequencies [Hz], damping [-], errors of their logarithms, shapes."""

    frequency: np.ndarray
    damping: np.ndarray
    shapes: np.ndarray
    errors: np.ndarray | None = None  # (2, n): of ln frequency and of ln damping


@dataclass
class Score:
    """What became of the modes of all draws."""

    modes: int = 0
    found: int = 0
    close: int = 0  # within 0.1 % and 5 %
    loose: int = 0  # within 1 % and 10 %
    frequency_covered: int = 0
    damping_covered: int = 0
    alike: int = 0
    with_errors: int = 0
    draws: int = 0
    spurious: int = 0
    complete: int = 0
    seconds: list[float] = field(default_factory=list)


def ours(structure: Structure) -> Found:
    """Return what shakerproc finds from forces and responses."""
    modes = identify_samples(
        structure.force, structure.response, structure.sample_rate, Settings(BAND)
    )
    errors = np.stack([modes.frequency_error, modes.damping_error])
    return Found(modes.frequency, modes.damping, modes.shapes, errors)


def ours_output_only(structure: Structure) -> Found:
    """Return what shakerproc finds from the responses alone."""
    modes = identify_output_only(structure.response, structure.sample_rate, Settings(BAND))
    errors = np.stack([modes.frequency_error, modes.damping_error])
    return Found(modes.frequency, modes.damping, modes.shapes, errors)


def h1(structure: Structure) -> tuple[np.ndarray, np.ndarray]:
    """Return frequency and response functions to the first force, by plain numpy."""
    step, window = SEGMENT // 2, np.hanning(SEGMENT + 1)[:-1]
    starts = range(0, structure.force.shape[1] - SEGMENT + 1, step)
    x, y = (
        np.stack([np.fft.rfft(window * one[:, s : s + SEGMENT]) for s in starts])
        for one in (structure.force, structure.response)
    )
    s_xx = np.einsum("kif,kjf->fij", x.conj(), x)
    s_xy = np.einsum("kif,kjf->fij", x.conj(), y)
    functions = np.linalg.solve(s_xx, s_xy)[:, 0]
    return np.fft.rfftfreq(SEGMENT, 1.0 / structure.sample_rate), functions.T


def sdypy_ema(structure: Structure) -> Found:
    """Return what sdypy-EMA's LSCF finds near the true frequencies."""
    from sdypy import EMA

    frequency, functions = h1(structure)
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        model = EMA.Model(
            functions[:, 1:], frequency[1:], lower=BAND[0], upper=BAND[1], pol_order_high=60
        )
        model.get_poles(show_progress=False)
        model.select_closest_poles(list(structure.frequency), f_window=2)
        model.get_constants(whose_poles="own", least_squares_type="new")
    return Found(np.array(model.nat_freq), np.array(model.nat_xi), np.array(model.A).T)


def pyoma2(structure: Structure) -> Found:
    """Return what pyOMA-2's covariance-driven SSI finds near the true frequencies."""
    from pyoma2.algorithms import SSI
    from pyoma2.setup import SingleSetup

    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        setup = SingleSetup(structure.response.T, fs=structure.sample_rate)
        setup.add_algorithms(SSI(name="ssi", method="cov", br=60, ordmax=60))
        setup.run_by_name("ssi")
        setup.mpe("ssi", sel_freq=list(structure.frequency), order_in=60)
    result = setup["ssi"].result
    return Found(np.array(result.Fn), np.array(result.Xi), np.array(result.Phi).T)


def methods() -> dict[str, Callable[[Structure], Found]]:
    """Return what takes part: ours, and neighbours that are installed."""
    every: dict[str, Callable[[Structure], Found]] = {
        "shakerproc": ours,
        "shakerproc, output only": ours_output_only,
    }
    if importlib.util.find_spec("sdypy") is not None:
        every["sdypy-EMA LSCF (told where)"] = sdypy_ema
    if importlib.util.find_spec("pyoma2") is not None:
        every["pyOMA-2 SSI-cov (told where)"] = pyoma2
    return every


def take_in(score: Score, structure: Structure, found: Found | None, seconds: float) -> None:
    """Add one draw to a score; None where the method failed."""
    score.draws += 1
    score.seconds.append(seconds)
    score.modes += structure.frequency.size
    if found is None:
        return
    free, hits = set(range(found.frequency.size)), 0
    for i, (frequency, damping) in enumerate(
        zip(structure.frequency, structure.damping, strict=True)
    ):
        near = [j for j in free if abs(found.frequency[j] / frequency - 1.0) < 0.02]
        if not near:
            continue
        likeness = [mac(found.shapes[j], structure.shapes[i]) for j in near]
        j = near[int(np.argmax(likeness))]
        free.discard(j)
        hits += 1
        shift = found.frequency[j] / frequency - 1.0
        change = found.damping[j] / damping - 1.0
        score.close += abs(shift) < 1e-3 and abs(change) < 0.05
        score.loose += abs(shift) < 1e-2 and abs(change) < 0.10
        score.alike += max(likeness) > 0.99
        if found.errors is not None:
            score.with_errors += 1
            reach = 1.96 * found.errors[:, j]
            score.frequency_covered += abs(np.log1p(shift)) < reach[0]
            score.damping_covered += abs(np.log(max(1.0 + change, 1e-9))) < reach[1]
    score.found += hits
    score.complete += hits == structure.frequency.size
    score.spurious += bool(free)


def mac(first: np.ndarray, second: np.ndarray) -> float:
    """Return the modal assurance criterion of two shapes."""
    power = np.vdot(first, first).real * np.vdot(second, second).real
    return float(abs(np.vdot(first, second)) ** 2 / power) if power > 0.0 else 0.0


def study(n_draws: int, seed: int, *, verbose: bool = False) -> dict[str, Score]:
    """Return the score of every method on the same draws."""
    every = methods()
    scores = {name: Score() for name in every}
    for number in range(seed, seed + n_draws):
        structure = structure_of(number)
        n_modes = structure.frequency.size
        for name, method in every.items():
            before = scores[name].close, scores[name].spurious
            began = time.perf_counter()
            found = attempt(method, structure)
            take_in(scores[name], structure, found, time.perf_counter() - began)
            after = scores[name].close, scores[name].spurious
            if verbose and name == "shakerproc":
                missed = n_modes - (after[0] - before[0])
                if missed or after[1] > before[1]:
                    print(f"draw {number}: {missed} of {n_modes} modes not within 0.1 %/5 %, "
                          f"spurious: {after[1] > before[1]}", flush=True)  # fmt: skip
    return scores


def bounds(n_draws: int, seed: int) -> tuple[float, float, float]:
    """Return the shares of modes that output only cannot pass.

    Within 0.1 % and 5 %, within 1 % and 10 %, and with a MAC above 0.99.
    """
    structures = [structure_of(number) for number in range(seed, seed + n_draws)]
    every = [bound_of(structure, BAND) for structure in structures]
    n = sum(structure.frequency.size for structure in structures)
    return (
        sum(one.close for one in every) / n,
        sum(one.loose for one in every) / n,
        sum(one.alike for one in every) / n,
    )


def structure_of(number: int) -> Structure:
    """Return the structure of one draw."""
    rng = np.random.default_rng(number)
    n_modes, n_inputs = int(rng.integers(3, 13)), int(rng.integers(1, 3))
    return draw(rng, n_modes, n_inputs=n_inputs, noise_db=float(rng.uniform(30, 60)))


def attempt(method: Callable[[Structure], Found], structure: Structure) -> Found | None:
    """Return what a method finds, None where it fails."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return method(structure)
        except Exception as error:  # noqa: BLE001 - a neighbour may fail in any way
            print(f"failed: {type(error).__name__}: {error}"[:200], flush=True)
            return None


def print_scores(scores: dict[str, Score]) -> None:
    """Print the table."""
    heads = ("modes", "found", ".1%/5%", "1%/10%", "cov f", "cov z", "MAC.99", "all")
    print(f"{'method':<30}" + "".join(f"{head:>8}" for head in heads), end="")
    print(f"{'spurious':>9}{'s mean':>8}{'s max':>7}")
    for name, score in scores.items():
        n, known = max(score.modes, 1), score.with_errors
        covered = (
            f"{score.frequency_covered / known:8.3f}{score.damping_covered / known:8.3f}"
            if known
            else f"{'-':>8}{'-':>8}"
        )
        print(f"{name:<30}{score.modes:>8}{score.found / n:8.3f}{score.close / n:8.3f}"
              f"{score.loose / n:8.3f}{covered}{score.alike / n:8.3f}"
              f"{score.complete / score.draws:8.2f}{score.spurious / score.draws:9.2f}"
              f"{np.mean(score.seconds):8.2f}{np.max(score.seconds):7.2f}")  # fmt: skip


def speed() -> tuple[float, float]:
    """Return how long 8 responses x 20,000 lines take: the diagram to order 60, all [s]."""
    structure = draw(np.random.default_rng(1), 8, noise_db=40.0, duration=50.0)
    rate, frequency = structure.sample_rate, np.linspace(0.0, 256.0, 20_001)[1:]
    s = 2j * np.pi * frequency
    functions = np.zeros((8, 1, frequency.size), dtype=complex)
    for f, zeta, shape in zip(
        structure.frequency, structure.damping, structure.shapes, strict=True
    ):
        omega = 2.0 * np.pi * f
        one = shape[structure.driven[0]] * s**2 / (s**2 + 2 * zeta * omega * s + omega**2)
        functions[:, 0] += np.outer(shape, one)
    rng = np.random.default_rng(2)
    size = 1e-3 * np.abs(functions).mean()
    functions += size * (
        rng.standard_normal(functions.shape) + 1j * rng.standard_normal(functions.shape)
    )
    began = time.perf_counter()
    ones, band = np.ones((1, frequency.size), dtype=complex), (1.0, 0.5 * rate)
    stabilisation(lagged_sums(frequency, ones, functions, 60), range(2, 61, 2), band)
    diagram = time.perf_counter() - began
    began = time.perf_counter()
    identify_functions(frequency, functions, Settings(band, order=60))
    return diagram, time.perf_counter() - began


def main() -> None:
    """Run the study."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--verbose", action="store_true")
    parser.add_argument("--speed", action="store_true", help="time one large case instead")
    options = parser.parse_args()
    if options.speed:
        diagram, whole = speed()
        print(f"8 x 20,000 lines, order 60: diagram {diagram:.2f} s, modes {whole:.2f} s")
        return
    logging.disable(logging.WARNING)
    print_scores(study(options.draws, options.seed, verbose=options.verbose))
    close, loose, alike = bounds(options.draws, options.seed)
    print(f"{'output only, information bound':<30}{'':>16}{close:8.3f}{loose:8.3f}{'':>16}"
          f"{alike:8.3f}")  # fmt: skip


if __name__ == "__main__":
    main()
