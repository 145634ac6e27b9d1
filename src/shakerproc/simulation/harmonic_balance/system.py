"""A model as harmonic balance sees it: matrices, a harmonic load, forces along directions.

Under dry friction the corner of the velocity at each reversal is resolved worst: the amplitude
errs by about 1 % at 31 harmonics, and by half as much with twice as many.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Final, cast, final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import ModelError
from shakerproc.models import AbstractMemorylessEffect, Element, Model
from shakerproc.models.coordinates import Coordinates, coordinates_of, resolved
from shakerproc.models.laws import WITH_STATE, Law, Row
from shakerproc.models.validation import check_unscaled
from shakerproc.simulation.harmonic_balance import fourier
from shakerproc.simulation.harmonic_balance.laws import (
    AbstractLaw,
    ContactDampingLaw,
    HarmonicMotion,
    HystereticLaw,
    PiecewiseLinearLaw,
    SmoothLaw,
)
from shakerproc.simulation.kernels import harmonic as contact


@final
@dataclass(frozen=True)
class Limited:
    """A friction force in the real form, with its derivatives.

    Attributes
    ----------
    force : (n_real,) array
        Coefficients [N].
    by_wish : (n_real, n_real) array
        Derivative by the coefficients of the force that is asked for [-].
    by_velocity : (n_real, n_real) array
        Derivative by the coefficients of the velocity, the wish held [N s/m].
    """

    force: FloatArray
    by_wish: FloatArray
    by_velocity: FloatArray


@final
@dataclass(frozen=True, eq=False)
class DryFrictionLaw:
    r"""Friction that falls from breaking away to sliding, with exact rest.

    The force is what the rest of the system asks for plus :math:`\varepsilon v`, held to what
    friction can bear. At a solution it is what is asked for, so either the velocity is 0 or the
    force is at its limit with the sign of the velocity, whatever the :math:`\varepsilon`.

    Attributes
    ----------
    sliding_force : float
        Force at high velocity [N].
    breakaway_force : float
        The most the joint holds at rest [N].
    stribeck_velocity : float
        Velocity over which the force falls [m/s].

    References
    ----------
    .. [1] S. Nacivet, C. Pierre, F. Thouverez and L. Jezequel, "A dynamic Lagrangian
       frequency-time method for the vibration of dry-friction-damped systems", Journal of
       Sound and Vibration 265, 201-219, 2003.
    """

    sliding_force: float
    breakaway_force: float
    stribeck_velocity: float

    def limited(self, wish: ComplexArray, motion: HarmonicMotion) -> Limited:
        """Return the force where another is wished for.

        Parameters
        ----------
        wish : (n_harmonics,) array
            Coefficients of the force asked for and the push of the velocity [N].
        motion : HarmonicMotion
            Motion of the joint.
        """
        asked = HarmonicMotion(wish, motion.harmonics, motion.omega)
        if self.breakaway_force > self.sliding_force:
            return self._falling(asked, motion)
        force, by_wish = contact.piecewise_linear_balance(
            wish, motion.harmonics, asked.samples, self._saturation
        )
        return Limited(force, by_wish, np.zeros_like(by_wish))

    @cached_property
    def _saturation(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        limit = np.array([-1.0, 1.0]) * self.sliding_force
        return limit, np.array([0.0, 1.0, 0.0]), np.array([limit[0], 0.0, limit[1]])

    def _falling(self, asked: HarmonicMotion, motion: HarmonicMotion) -> Limited:
        n_samples = 2 ** int(np.ceil(np.log2(max(512, 16 * int(motion.harmonics[-1])))))
        wish = asked.sampled(n_samples)[0]
        velocity = motion.omega * motion.sampled(n_samples)[1]
        excess = self.breakaway_force - self.sliding_force
        fall = excess * np.exp(-((velocity / self.stribeck_velocity) ** 2))
        limit = self.sliding_force + fall
        held = np.abs(wish) < limit
        force = np.where(held, wish, limit * np.sign(wish))
        steepness = -2.0 * velocity / self.stribeck_velocity**2 * fall * np.sign(wish)
        coefficients = fourier.coefficients_of_values(force, motion.harmonics)
        return Limited(
            fourier.real_of_complex(coefficients, motion.harmonics),
            _product(held.astype(np.float64), motion),
            _product(np.where(held, 0.0, steepness), motion),
        )


def _product(factor: FloatArray, motion: HarmonicMotion) -> FloatArray:
    return fourier.multiplication(np.fft.rfft(factor) / factor.size, motion.harmonics)


SHARPNESS: Final = 15
"""Degree that laws which are no polynomials are sampled for."""

DEGREES: Final[Mapping[Law, Callable[[Row], float]]] = MappingProxyType({
    Law.ODD_POWER: lambda row: row.values[2] + (0.5 if row.values[2] % 2.0 == 0.0 else 0.0),
    Law.EVEN_POWER: lambda row: row.values[2] + (0.5 if row.values[2] % 2.0 == 1.0 else 0.0),
    Law.POWER_DAMPING: lambda row: row.values[2] + (1.5 if row.values[2] % 2.0 else 1.0),
    Law.QUADRATIC_DAMPING: lambda _: 2.5,
    Law.CONSTANT: lambda _: 1.0,
    Law.HERTZ: lambda _: 4 * SHARPNESS + 0.5,  # d^1.5 bends at the wall: missed by 1e-5
})
"""Degree of a law in the motion, by its numbers; of others it is `SHARPNESS` and a half."""


@final
@dataclass(frozen=True, eq=False)
class Coupling:
    """A force law along one relative displacement.

    Attributes
    ----------
    direction : (n_dofs,) array
        Displacement of the law as a sum of degrees of freedom [-].
    law : AbstractLaw
        The force that resists it.
    name : str
        What it is called in messages.
    """

    direction: FloatArray
    law: AbstractLaw
    name: str


@final
@dataclass(frozen=True, eq=False)
class Friction:
    """Dry friction along one relative displacement.

    Attributes
    ----------
    direction : (n_dofs,) array
        Displacement of the joint as a sum of degrees of freedom [-].
    law : DryFrictionLaw
        The friction.
    name : str
        What it is called in messages.
    """

    direction: FloatArray
    law: DryFrictionLaw
    name: str


@final
@dataclass(frozen=True, eq=False)
class PeriodicSystem:
    r"""Masses under a harmonic load, relative to the base.

    .. math:: M \ddot q + C \dot q + K q + \sum_e d_e f_e(d_e^T q, d_e^T \dot q)
        = \mathrm{Re}(p \, e^{i \Omega t})

    Attributes
    ----------
    mass, damping, stiffness : (n_dofs, n_dofs) array
        Matrices [kg], [N s/m], [N/m].
    load : (n_dofs,) array
        Complex amplitude of the load [N].
    couplings : tuple of Coupling
        What is not linear, but for dry friction.
    frictions : tuple of Friction
        Joints with dry friction.
    """

    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    load: ComplexArray
    couplings: tuple[Coupling, ...]
    frictions: tuple[Friction, ...] = ()

    @property
    def n_dofs(self) -> int:
        """Number of degrees of freedom."""
        return int(self.mass.shape[0])

    @property
    def remembers(self) -> bool:
        """Whether a force depends on the motion before."""
        return any(coupling.law.remembers for coupling in self.couplings)

    @property
    def odd(self) -> bool:
        """Whether the opposite of every motion is a motion half a period later."""
        return all(coupling.law.odd for coupling in self.couplings)


def system_of_model(model: Model, level: float) -> PeriodicSystem:
    """Return a model under a harmonic excitation.

    Parameters
    ----------
    model : Model
        What is shaken.
    level : float
        Amplitude of the excitation [m/s²] or [N].

    Returns
    -------
    PeriodicSystem
        Its degrees of freedom are the coordinates of the model.

    Raises
    ------
    ModelError
        If the model has no periodic motion, as its properties change with time.
    """
    check_unscaled(model, "a periodic motion")
    elements = resolved(model)
    linear = coordinates_of(model, elements)
    placed = [(linear.across(element.between), element) for element in elements]
    return PeriodicSystem(
        np.diag(linear.mass),
        linear.damping,
        linear.stiffness,
        _load(model, linear, level),
        couplings=tuple(
            Coupling(direction, _law(model, element), _name(element))
            for direction, element in placed
            if not _laws(element) <= {Law.LINEAR, Law.ATTACHED, Law.FRICTION}
        ),
        frictions=tuple(
            Friction(direction, DryFrictionLaw(*row.values), _name(element))
            for direction, element in placed
            for row in _rows(element, Law.FRICTION)
        ),
    )


def _load(model: Model, linear: Coordinates, level: float) -> ComplexArray:
    if model.excitation.kind not in {"base acceleration", "force"}:
        raise ModelError(
            f"{model.title}: harmonic balance needs a base or a force that drives the model, "
            f"not {model.excitation.kind}. Use simulate."
        )
    return np.asarray(level * linear.load, np.complex128)


def _rows(element: Element, law: Law) -> list[Row]:
    return [row for row in element.effect.rows() if row.law == law]


def _laws(element: Element) -> set[Law]:
    return {row.law for row in element.effect.rows()}


def _name(element: Element) -> str:
    return f"{element.effect.kind} between {' and '.join(element.between)}"


def _law(model: Model, element: Element) -> AbstractLaw:
    """Return the law of an element that is not linear.

    Raises
    ------
    ModelError
        If harmonic balance knows no law for it.
    """
    for known, build in LAWS.items():
        if _laws(element) <= known:
            return build(element)
    raise ModelError(
        f"{model.title}: the {_name(element)} changes with time, so there is no steady "
        f"response. Leave it out, or simulate the test in time."
    )


def _stops(element: Element) -> AbstractLaw:
    """Return stops and jumps as straight lines between their walls."""
    rows = element.effect.rows()
    walls = np.unique([row.values[1] for row in rows])
    middles = _between(walls)
    slopes, intercepts = np.zeros(middles.size), np.zeros(middles.size)
    for row in rows:
        stiffness, wall, side = row.values
        beyond = side * (middles - wall) > 0.0
        slopes += stiffness * beyond
        intercepts -= stiffness * wall * beyond * (row.law == Law.STOP)
    return PiecewiseLinearLaw(walls, slopes, intercepts)


def _contact_damping(element: Element) -> AbstractLaw:
    rows = element.effect.rows()
    walls = np.unique([row.values[1] for row in rows])
    middles = _between(walls)
    damping = np.zeros(middles.size)
    for row in rows:
        coefficient, wall, side = row.values
        damping += coefficient * (side * (middles - wall) > 0.0)
    return ContactDampingLaw(walls, damping)


def _between(walls: FloatArray) -> FloatArray:
    """Return a displacement on each stretch between walls."""
    reach = 1.0 + 2.0 * float(np.max(np.abs(walls)))
    ends = np.concatenate([[-reach], walls, [reach]])
    return np.asarray(0.5 * (ends[1:] + ends[:-1]))


def _smooth(element: Element) -> AbstractLaw:
    effect = cast("AbstractMemorylessEffect", element.effect)
    degrees = [_degree(row) for row in effect.rows()]
    whole = all(degree == int(degree) for degree in degrees)
    probe = np.array([0.7, -0.3]), np.array([0.2, 0.9])
    there, back = effect.force_at(*probe), effect.force_at(-probe[0], -probe[1])
    return SmoothLaw(
        force=effect.force_at,
        slopes=effect.slopes,
        degree=int(max(degrees)) if whole else max(SHARPNESS, int(max(degrees)) + 1),
        is_odd=bool(np.allclose(there, -back, rtol=1e-12, atol=0.0)),
        stiffness=0.0,
    )


def _degree(row: Row) -> float:
    return DEGREES[row.law](row) if row.law in DEGREES else SHARPNESS + 0.5


def _hysteretic(element: Element) -> AbstractLaw:
    (row,) = element.effect.rows()
    stiffness = row.values[3] if row.law == Law.LUGRE else row.values[0]
    return HystereticLaw(element.effect.force_along, stiffness)


LAWS: Final[Mapping[frozenset[Law], Callable[[Element], AbstractLaw]]] = MappingProxyType({
    frozenset({Law.STOP, Law.JUMP}): _stops,
    frozenset({Law.CONTACT_DAMPING}): _contact_damping,
    WITH_STATE: _hysteretic,
    frozenset(Law) - WITH_STATE - {Law.STOP, Law.JUMP, Law.CONTACT_DAMPING, Law.DRIFT}: _smooth,
})
"""How the laws of an element are taken; what changes with time has none."""
