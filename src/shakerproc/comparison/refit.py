"""The model's own numbers fitted first, so that they are not taken for missing physics."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.comparison.free_run_error import relative_residuals
from shakerproc.comparison.held_out import held_out
from shakerproc.comparison.measured import Measured
from shakerproc.comparison.own import own_of
from shakerproc.comparison.prediction import free_run
from shakerproc.data import FloatArray
from shakerproc.errors import DiagnosisError, SimulationError
from shakerproc.models import Model
from shakerproc.numerals import numeral

REACH: Final = {"damping": 10.0, "damping_ratio": 10.0}
"""Factor either way within which a parameter is sought; 3 for all others."""

_STEP: Final = 1e-4  # of a logarithm, for slopes
_ROUNDS: Final = 25
_DONE: Final = 1e-5  # change of every logarithm
_BLOCK_S: Final = 0.25  # within which residuals may be correlated
_SCAN: Final = tuple(np.linspace(-0.21, 0.21, 15))  # of the logarithm of all stiffnesses
_LARGEST: Final = 3  # tests that are fitted
_STIFF: Final = ("N/m",)
_STIFFEST: Final = 1e6  # damping of a step that is as good as none


@final
@dataclass(frozen=True, slots=True)
class FittedParameter:
    """One number of the model, fitted.

    Attributes
    ----------
    element : int
        Which element of the model it belongs to, from 0.
    kind : str
        Effect of that element.
    between : (str, str)
        Where it acts.
    name : str
        Name of the parameter.
    before, value : float
        In the model as it was, and fitted [unit].
    low, high : float
        95 % interval [unit].
    unit : str
        SI unit.
    at_bound : bool
        Whether it ran against its bound, so that the value means little.
    """

    element: int
    kind: str
    between: tuple[str, str]
    name: str
    before: float
    value: float
    low: float
    high: float
    unit: str
    at_bound: bool


@final
@dataclass(frozen=True, slots=True)
class Refit:
    """A model with fitted numbers.

    Attributes
    ----------
    model : Model
        The same elements, other numbers.
    parameters : tuple of FittedParameter
        What was fitted.
    tests : tuple of str
        Which tests it was fitted to; never one that is held out.
    error_before, error_after : float
        Unexplained over measured rms on those tests [-].
    converged : bool
        Whether the last step was small enough.
    """

    model: Model
    parameters: tuple[FittedParameter, ...]
    tests: tuple[str, ...]
    error_before: float
    error_after: float
    converged: bool


def refit(
    model: Model, tests: Sequence[Measured], tell: Callable[[str], None] = lambda _: None
) -> Refit:
    """Return the model with its numbers fitted to the response in time.

    What is held out takes no part. All numbers of its elements are sought, as logarithms with
    their sign kept, by damped Gauss-Newton steps. A common factor on all stiffnesses is
    scanned first, since a resonance that is off by more than its width gives no slope to
    follow. Intervals allow for residuals correlated over a quarter of a second and for a model
    that is not all there (sandwich estimate).

    Parameters
    ----------
    model : Model
        Where to start from.
    tests : sequence of Measured
        Tests of a campaign; those held out are left alone.
    tell : callable
        Told what is going on.

    Raises
    ------
    DiagnosisError
        If every test is held out, the motion is chaotic, or there is nothing to fit.
    SimulationError
        If the model runs away as it is.

    References
    ----------
    .. [1] A. C. Cameron and P. K. Trivedi, "Microeconometrics", Cambridge, 2005, sec. 24.5:
       cluster-robust covariances.
    """
    chosen = _chosen(tests)
    wanted = _wanted(model)
    if not wanted:
        raise DiagnosisError(f"{model.title}: no element has a number to fit.")
    problem = _Residuals(model, wanted, chosen)
    start = np.zeros(len(wanted))
    first = problem.residuals(start)
    if first is None:
        for test, own in zip(chosen, problem.own, strict=True):
            free_run(model, test, *own)  # tells which test runs away
        raise DiagnosisError(f"{model.title}: the motion runs away.")
    tell("scan of the stiffness")
    here = _scanned(problem, start)
    here, residual, slopes, converged = _descend(problem, here, tell)
    spread = _spread(slopes, residual, problem.blocks)
    fitted = tuple(
        _parameter(model, *which, float(x), float(s))
        for which, x, s in zip(wanted, here, spread, strict=True)
    )
    return Refit(
        model=problem.model_at(here),
        parameters=fitted,
        tests=tuple(test.name for test in chosen),
        error_before=_rms(first),
        error_after=_rms(residual),
        converged=converged,
    )


def _chosen(tests: Sequence[Measured]) -> list[Measured]:
    """Return up to three tests to fit to, the levels spread out.

    Raises
    ------
    DiagnosisError
        If all are held out.
    """
    free = [test for test in tests if not test.test.hold_out]
    if not free:
        raise DiagnosisError(
            "every test is held out, so none is left to fit to. Take hold_out: true off one of "
            "them in the log."
        )
    free.sort(key=lambda test: float(np.mean(test.input**2)))
    if len(free) <= _LARGEST:
        return free
    return [free[round(i)] for i in np.linspace(0, len(free) - 1, _LARGEST)]


def _wanted(model: Model) -> list[tuple[int, str]]:
    """Return element and name of every number that is not 0, and no reference of another."""
    found = []
    for i, element in enumerate(model.elements):
        for name, parameter in element.effect.parameters.items():
            value = getattr(element.effect, name)
            known = parameter.choices or parameter.reference
            if not known and value is not None and value != 0.0:
                found.append((i, name))
    return found


@final
class _Residuals:
    """Residuals of the chosen tests as a function of the logarithms of the numbers."""

    def __init__(
        self, model: Model, wanted: Sequence[tuple[int, str]], tests: Sequence[Measured]
    ) -> None:
        self.model = model
        self.wanted = wanted
        self.tests = tests
        self.kept, self.own = held_out(tests), [own_of(model, test) for test in tests]
        names = [name for _, name in wanted]
        self.reach = np.log([REACH.get(name, 3.0) for name in names])
        self.stiff = np.array([
            model.elements[i].effect.parameters[name].unit in _STIFF for i, name in wanted
        ])
        sizes = [
            (test.stop - test.start, len(test.sensors), test.sample_rate) for test in tests
        ]
        self.blocks = _blocks(sizes)

    def model_at(self, logarithms: FloatArray) -> Model:
        """Return the model with every number times e to the power of its logarithm."""
        elements = list(self.model.elements)
        for (i, name), x in zip(self.wanted, logarithms, strict=True):
            value = getattr(elements[i].effect, name) * float(np.exp(x))
            effect = replace(elements[i].effect, **{name: value})  # type: ignore[type-var]
            elements[i] = replace(elements[i], effect=effect)
        return replace(self.model, elements=tuple(elements))

    def residuals(self, logarithms: FloatArray, only: int | None = None) -> FloatArray | None:
        """Return the relative residuals of all tests (or one), or None where it runs away."""
        every = list(zip(self.tests, self.own, self.kept, strict=True))
        tests = every if only is None else [every[only]]
        out = []
        try:
            model = self.model_at(logarithms)
            for test, own, kept in tests:
                scaled = relative_residuals(free_run(model, test, *own).within(~kept))
                out.append(scaled[:, test.start : test.stop].ravel() / np.sqrt(len(tests)))
        except (SimulationError, ValueError):  # a number outside what its effect allows
            return None
        return np.concatenate(out)


def _blocks(sizes: Sequence[tuple[int, int, float]]) -> FloatArray:
    """Return the number of the block that each residual belongs to.

    Sensors of a test share their blocks: what one mass does not follow, no other does either.
    """
    numbers, first = [], 0
    for samples, sensors, rate in sizes:
        block = np.arange(samples) // max(1, round(_BLOCK_S * rate))
        numbers.append(np.tile(first + block, sensors))
        first += int(block[-1]) + 1
    out: FloatArray = np.concatenate(numbers)
    return out


def _rms(residual: FloatArray) -> float:
    return float(np.sqrt(np.sum(residual**2)))


def _scanned(problem: _Residuals, start: FloatArray) -> FloatArray:
    """Return the best common factor on all stiffnesses, judged by the middle test."""
    middle = len(problem.tests) // 2
    best, least = start, np.inf
    for factor in _SCAN:
        here = np.where(problem.stiff, factor, 0.0)
        residual = problem.residuals(here, middle)
        if residual is not None and (cost := _rms(residual)) < least:
            best, least = here, cost
    return best


def _descend(
    problem: _Residuals, here: FloatArray, tell: Callable[[str], None]
) -> tuple[FloatArray, FloatArray, FloatArray, bool]:
    """Return the minimum, its residuals and slopes, and whether it was reached.

    Raises
    ------
    DiagnosisError
        If the residuals do not depend on the numbers.
    """
    residual = problem.residuals(here)
    if residual is None:
        here = np.zeros_like(here)
        residual = problem.residuals(here)
    if residual is None:
        raise DiagnosisError(f"{problem.model.title}: the motion runs away.")
    damping, slopes = 1e-3, _slopes(problem, here, residual)
    for round_ in range(_ROUNDS):
        tell(f"fit, round {round_ + 1}, error {numeral(_rms(residual))}")
        step = _step(problem, here, residual, slopes, damping)
        if step is None:  # no step, however short, is better
            return here, residual, slopes, True
        moved = float(np.max(np.abs(step.here - here)))
        here, residual, damping = step.here, step.residual, max(step.damping * 0.1, 1e-9)
        slopes = _slopes(problem, here, residual)
        if moved < _DONE:
            return here, residual, slopes, True
    return here, residual, slopes, False


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Step:
    here: FloatArray
    residual: FloatArray
    damping: float


def _step(
    problem: _Residuals,
    here: FloatArray,
    residual: FloatArray,
    slopes: FloatArray,
    damping: float,
) -> _Step | None:
    """Return the first step that is better, with the damping that took; None without any."""
    normal, gradient = slopes.T @ slopes, slopes.T @ residual
    while damping < _STIFFEST:
        load = np.diag(damping * np.maximum(np.diag(normal), 1e-12))
        moved = here + np.linalg.solve(normal + load, -gradient)
        trial = np.clip(moved, -problem.reach, problem.reach)
        new = problem.residuals(trial)
        if new is not None and _rms(new) <= _rms(residual):
            return _Step(trial, new, damping)
        damping *= 10.0
    return None


def _slopes(problem: _Residuals, here: FloatArray, residual: FloatArray) -> FloatArray:
    columns = []
    for i in range(here.size):
        moved = here.copy()
        moved[i] += _STEP
        other = problem.residuals(moved)
        columns.append(np.zeros_like(residual) if other is None else (other - residual) / _STEP)
    return np.array(columns).T


def _spread(slopes: FloatArray, residual: FloatArray, blocks: FloatArray) -> FloatArray:
    """Return the half width of the 95 % interval of every logarithm."""
    n_blocks, n = int(blocks.max()) + 1, slopes.shape[1]
    pulls = np.array([np.bincount(blocks, slopes[:, i] * residual, n_blocks) for i in range(n)])
    normal = slopes.T @ slopes
    scale = np.sqrt(np.maximum(np.diag(normal), np.finfo(float).tiny))
    inverse = np.linalg.pinv(normal / np.outer(scale, scale)) / np.outer(scale, scale)
    more = n_blocks / max(1, n_blocks - n)
    covariance = inverse @ (pulls @ pulls.T) @ inverse * more
    quantile = float(scipy.special.stdtrit(max(1, n_blocks - n), 0.975))
    half: FloatArray = quantile * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return half


def _parameter(
    model: Model, index: int, name: str, logarithm: float, half: float
) -> FittedParameter:
    element = model.elements[index]
    before = float(getattr(element.effect, name))
    reach = float(np.log(REACH.get(name, 3.0)))
    half = min(half, 50.0)
    return FittedParameter(
        element=index,
        kind=element.effect.kind,
        between=element.between,
        name=name,
        before=before,
        value=before * float(np.exp(logarithm)),
        low=before * float(np.exp(logarithm - half)),
        high=before * float(np.exp(logarithm + half)),
        unit=model.unit_of(element.effect.parameters[name].unit),
        at_bound=abs(logarithm) > 0.999 * reach,
    )
