"""The frequency response of a model with every branch that the curve runs through."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, NoReturn, final

import numpy as np

from shakerproc import checks
from shakerproc.data import FloatArray
from shakerproc.errors import ModelError, SimulationError
from shakerproc.models import Model
from shakerproc.simulation.harmonic_balance.balance import HarmonicBalance
from shakerproc.simulation.harmonic_balance.branch import (
    Branch,
    branch_of_trace,
    is_linear,
    joined,
    linear_branch,
    samples_of_branch,
)
from shakerproc.simulation.harmonic_balance.continuation import StepSizes, follow
from shakerproc.simulation.harmonic_balance.curves import (
    CLOSED,
    LOST,
    ForcedCurve,
    end_of_trace,
    floats,
    held,
    limits,
    solve_at,
)
from shakerproc.simulation.harmonic_balance.shooting import one_round, polished, state_of
from shakerproc.simulation.harmonic_balance.system import PeriodicSystem, system_of_model

MOST_UNKNOWNS = 2000
"""Of harmonic balance: what a few minutes solve for a whole curve."""

WITHIN = (0.95, 0.8, 0.6)
"""Where to look for further branches, over each natural frequency."""

CLOSE: Final = 256
"""Samples of a round that is compared with the exact stepper's."""


@final
@dataclass(frozen=True, eq=False)
class Response:
    """The response of a model to a harmonic excitation of one level.

    Attributes
    ----------
    model : Model
        What is shaken.
    level : float
        Amplitude of the excitation [m/s²] or [N].
    band : tuple of float
        Frequencies of the excitation, from and to [Hz].
    branches : tuple of Branch
        The curve from the lower frequency, that from the upper one where it is another, and,
        where neither runs from end to end, those from between.
    """

    model: Model
    level: float
    band: tuple[float, float]
    branches: tuple[Branch, ...]

    @property
    def not_followed(self) -> tuple[str, ...]:
        """Curves that may or must exist besides, a sentence each.

        Motions of a mass that something holds come in odd numbers at every frequency but the
        folds, so that an even number at an end of the band lacks one.
        """
        if all(is_linear(branch.balance.system) for branch in self.branches):
            return ()  # there is one motion at every frequency
        sentences = []
        if not any(_cut_short(branch) for branch in self.branches):
            for edge in self.band:
                count = sum(_crossings(branch, edge) for branch in self.branches)
                if count % 2 == 0:
                    sentences.append(
                        f"at {edge:g} Hz {count} motions were found, an even number: at least "
                        f"one more goes on there and was not followed; widen the band"
                    )
        beyond = [
            f"{edge:g} Hz"
            for edge in self.band
            if any(_crossings(branch, edge) for branch in self.branches)
        ]
        if beyond:
            sentences.append(f"the curves beyond {' and '.join(beyond)}")
        starts = "at the ends of the band"
        if not any(_whole(branch, self.band) for branch in self.branches):
            starts += " and near the resonances"
        sentences.append(
            f"isolated branches, and others that are not reached from where the curves begin "
            f"({starts}); a wider band may join them"
        )
        return tuple(sentences)


def frequency_response(
    model: Model,
    level: float,
    *,
    from_hz: float,
    to_hz: float,
    harmonics: int = 31,
) -> Response:
    """Return the periodic motions of a model against frequency, stable and unstable.

    With dry friction every motion is made exact by shooting, which takes about 0.03 s each.

    Parameters
    ----------
    model : Model
        What is shaken.
    level : float
        Amplitude of the excitation [m/s²] or [N].
    from_hz, to_hz : float
        Band of the excitation [Hz].
    harmonics : int
        Highest harmonic. Where the forces are odd, only odd harmonics are carried: the motion
        has no others, and a loss of that symmetry shows as a branch point.

    Returns
    -------
    Response
        With one branch, or several where the curve from above is another than that from below.

    Raises
    ------
    ValueError
        If the band or the level is not above 0.
    ModelError
        If dry friction bears the whole load, or the model is too large for harmonic balance.
    SimulationError
        If no periodic motion is found, or the numbers are beyond what can be computed.
    """
    checks.positive("level", level, "of the excitation")
    checks.positive("from_hz", from_hz, "Hz")
    checks.positive("to_hz", to_hz, "Hz")
    if not to_hz > from_hz:
        raise ValueError(f"to_hz must be above from_hz {from_hz:g} Hz, not {to_hz:g} Hz")
    if harmonics < 1:
        raise ValueError(f"harmonics must be at least 1, not {harmonics}")
    balance = balance_of_system(system_of_model(model, level), harmonics)
    _check_size(balance, model.title)
    if held(balance):
        raise ModelError(
            f"{model.title}: the friction holds the masses still at this level. Raise it."
        )
    band = (from_hz, to_hz)
    try:
        branches = _branches(balance, band, _steps(balance))
        if not branches:
            _complain(balance, model.title, band)
    except (np.linalg.LinAlgError, OverflowError) as error:
        raise SimulationError(
            f"{model.title}: harmonic balance met numbers beyond what can be computed "
            f"({error}) between {from_hz:g} and {to_hz:g} Hz at a level of {level:g}. Check "
            f"the sizes of the parameters against the band and the level."
        ) from error
    if balance.system.frictions and not balance.system.remembers:
        branches = [polished(model, level, branch) for branch in branches]
    return Response(model, level, band, tuple(branches))


def _branches(
    balance: HarmonicBalance, band: tuple[float, float], steps: StepSizes
) -> list[Branch]:
    """Return the branches of a band."""
    if is_linear(balance.system):
        return [linear_branch(balance, band)]
    branches: list[Branch] = []
    for frequency in _starts(balance, band):
        if frequency not in band and any(_whole(branch, band) for branch in branches):
            break  # both ends are begun at whatever the first curve did: a fold may lie beyond
        branch = _branch_through(balance, frequency, band, steps, branches)
        branches += [] if branch is None else [branch]
    return branches


def _check_size(balance: HarmonicBalance, title: str) -> None:
    """Pass equations of a size that can be solved some hundred times.

    Raises
    ------
    ModelError
        If there are too many of them.
    """
    n_dofs, n_unknowns = balance.system.n_dofs, balance.load.size
    if n_unknowns > MOST_UNKNOWNS:
        fits = int(balance.harmonics[-1] * MOST_UNKNOWNS / n_unknowns)
        advice = f"Take at most {fits} harmonics." if fits >= 1 else "Take fewer masses."
        raise ModelError(
            f"{title}: {n_dofs} masses with harmonics up to {balance.harmonics[-1]} are "
            f"{n_unknowns} unknowns; harmonic balance takes at most {MOST_UNKNOWNS}. {advice}"
        )


def _steps(balance: HarmonicBalance) -> StepSizes:
    """Return how a curve is followed: less strictly where the force is only sampled."""
    sampled = balance.system.remembers or bool(balance.system.frictions)
    return StepSizes(tolerance=1e-6, shortest=1e-4) if sampled else StepSizes()


def balance_of_system(
    system: PeriodicSystem, harmonics: int, order: int = 1
) -> HarmonicBalance:
    """Return the balance over harmonics up to a highest, the odd ones where they suffice."""
    if is_linear(system):
        harmonics = 1  # a linear system answers a sine with a sine
    symmetric = system.odd and order % 2 == 1
    first, step = (1, 2) if symmetric else (0, 1)
    return HarmonicBalance(system, np.arange(first, harmonics * order + 1, step), order)


def natural_frequencies(system: PeriodicSystem) -> FloatArray:
    """Return the natural frequencies with every coupling a linear spring, (n_dofs,) [Hz]."""
    stiffness = system.stiffness.copy()
    for coupling in system.couplings:
        square = np.outer(coupling.direction, coupling.direction)
        stiffness += coupling.law.reference_stiffness * square
    values = np.linalg.eigvals(np.linalg.solve(system.mass, stiffness)).real
    return np.sort(np.sqrt(np.maximum(values, 0.0))) / (2.0 * np.pi)


def follow_branch(
    balance: HarmonicBalance,
    start: FloatArray,
    towards: FloatArray,
    band: tuple[float, float],
    steps: StepSizes,
) -> Branch:
    """Return the branch from a solution on until it leaves a band or touches nothing.

    Parameters
    ----------
    balance : HarmonicBalance
        The equations.
    start : (n_unknowns + 1,) array
        Coefficients [m] and base rate [rad/s] of a solution.
    towards : (n_unknowns + 1,) array
        Direction to set out in [m, rad/s].
    band : tuple of float
        Frequencies of the excitation [Hz].
    steps : StepSizes
        How the curve is followed.
    """
    curve = ForcedCurve(balance)
    trace = follow(curve, start, towards, limits(curve, start, band), steps)
    trace, ended = end_of_trace(curve, trace, band)
    return branch_of_trace(balance, curve, trace, ended)


def _starts(balance: HarmonicBalance, band: tuple[float, float]) -> Iterator[float]:
    """Yield frequencies to begin at: the ends of the band, then near the resonances."""
    yield from band
    for natural in natural_frequencies(balance.system):
        for share in WITHIN:
            if band[0] < share * natural < band[1]:
                yield float(share * natural)


def _branch_through(
    balance: HarmonicBalance,
    frequency: float,
    band: tuple[float, float],
    steps: StepSizes,
    known: list[Branch],
) -> Branch | None:
    """Return the branch through a solution at a frequency; None if there is none, or known."""
    solution = solve_at(balance, frequency)
    omega = 2.0 * np.pi * frequency / balance.order
    if solution is None or floats(balance, solution, omega):
        return None
    if any(_holds(branch, frequency, solution) for branch in known):
        return None
    start = np.append(solution, omega)
    towards = np.zeros(start.size)
    towards[-1] = 1.0
    ways = []
    if frequency < band[1]:
        ways.append(follow_branch(balance, start, towards, band, steps))
    if frequency > band[0] and not (ways and CLOSED in ways[0].ended):
        ways.append(follow_branch(balance, start, -towards, band, steps))
    return ways[0] if len(ways) == 1 else joined(ways[1], ways[0])


def _holds(branch: Branch, frequency: float, solution: FloatArray) -> bool:
    """Return whether a branch runs through a solution."""
    before, after = branch.frequency[:-1], branch.frequency[1:]
    room = 1e-9 * frequency  # the ends of a branch lie at those of the band but for rounding
    between = (np.minimum(before, after) - room <= frequency) & (
        frequency <= np.maximum(before, after) + room
    )
    rise = np.where(after == before, 1.0, after - before)
    shares = np.clip((frequency - before) / rise, 0.0, 1.0)
    for i in np.flatnonzero(between):
        step = branch.unknowns[i + 1] - branch.unknowns[i]
        here = branch.unknowns[i] + shares[i] * step
        size = np.linalg.norm(solution)
        if np.linalg.norm(here - solution) < 0.02 * size + 0.5 * np.linalg.norm(step):
            return True
    return False


def _whole(branch: Branch, band: tuple[float, float]) -> bool:
    """Return whether a branch runs from the lower end of a band to the upper, or floats off."""
    first, last = branch.frequency[0], branch.frequency[-1]
    through = np.isclose(sorted((first, last)), band, rtol=1e-6).all()
    return bool(through) or LOST in branch.ended


def _crossings(branch: Branch, edge: float) -> int:
    """Return how many ends of a branch lie at an end of the band."""
    ends = (branch.frequency[0], branch.frequency[-1])
    return sum(bool(np.isclose(end, edge, rtol=1e-6)) for end in ends)


def _cut_short(branch: Branch) -> bool:
    """Return whether a branch ends elsewhere than at the band's ends or on itself."""
    return any(word in branch.ended for word in (LOST, "too short", "too many"))


def _complain(balance: HarmonicBalance, title: str, band: tuple[float, float]) -> NoReturn:
    """Say why nothing was found.

    Raises
    ------
    ModelError
        If the motion does not touch at either end of the band.
    SimulationError
        If no periodic motion is found at either end of the band.
    """
    starts = [solve_at(balance, frequency) for frequency in band]
    rate = 2.0 * np.pi / balance.order
    afloat = [
        start is not None and floats(balance, start, frequency * rate)
        for start, frequency in zip(starts, band, strict=True)
    ]
    ends = f"{band[0]:g} Hz and at {band[1]:g} Hz"
    if any(afloat):
        raise ModelError(
            f"{title}: contact lost: at {ends} the motion stays inside the clearance and "
            f"nothing holds the mass. Raise the level, or begin at a lower frequency."
        )
    raise SimulationError(
        f"{title}: no periodic motion was found at {ends}. Choose another band or level."
    )


def difference_from_simulation(response: Response) -> float:
    """Return how far the tallest stable motion is from the exact stepper's, over one round.

    The stepper sets out from the state that harmonic balance gives, and is excited alike; the
    largest difference of the first mass over the round counts, as a share of its largest
    displacement [-]. NaN where no motion is stable, or where a law has a memory, whose state
    harmonic balance does not give.
    """
    tallest: tuple[float, Branch, int] | None = None
    for branch in response.branches:
        amplitude = np.max(np.abs(samples_of_branch(branch, 256)[:, 0]), axis=-1)
        steady = np.where(branch.stable, amplitude, 0.0)
        place = int(np.argmax(steady))
        if steady[place] > 0.0 and (tallest is None or steady[place] > tallest[0]):
            tallest = float(steady[place]), branch, place
    if tallest is None or tallest[1].balance.system.remembers:
        return float("nan")
    _, branch, point = tallest
    samples = samples_of_branch(branch, CLOSE)[point, 0]
    frequency = float(branch.frequency[point])
    stepped = one_round(
        response.model,
        response.level,
        frequency,
        state_of(branch, point),
        order=branch.balance.order,
        n_samples=CLOSE // branch.balance.order,
    )
    difference = np.abs(stepped.motion[0, :-1] - samples)
    return float(np.max(difference) / np.max(np.abs(samples)))
