"""How far a joint moves before its play is used up: exactly linear until the first contact."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias, final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import ModelError
from shakerproc.finite_elements.coupon import ThermalFit, clearances_at
from shakerproc.models import BASE, AbstractMemorylessEffect, Element, Model
from shakerproc.models.coordinates import coordinates_of, resolved
from shakerproc.models.laws import Law
from shakerproc.models.validation import check_unscaled
from shakerproc.simulation.harmonic_balance.system import system_of_model
from shakerproc.testlog import Test

Which: TypeAlias = Literal["actual", "nominal"]

TINY: Final = 1e-15
"""Where slopes at rest are taken, on either side, for joints without play [m]."""


@final
@dataclass(frozen=True, slots=True)
class Play:
    """Total way of the part from one stop to the other.

    Attributes
    ----------
    total : float
        Hole less bushing, or length of the bushing less thickness; not below 0 [m].
    says : str
        Where it comes from.
    """

    total: float
    says: str

    @property
    def half(self) -> float:
        """Free play to each side of the middle, the `clearance` of a gap [m]."""
        return 0.5 * self.total


@final
@dataclass(frozen=True, slots=True)
class Warming:
    """How the coupon's joint expands.

    Attributes
    ----------
    fit : ThermalFit
        Hole and insert with their materials, in plane.
    thickness : float
        Of the coupon, for the play out of plane [m].
    change : float
        Temperature less that of the measured sizes [K].
    """

    fit: ThermalFit
    thickness: float
    change: float


def play_of_test(
    test: Test, which: Which = "actual", warming: Warming | None = None
) -> Play | None:
    """Return the play along the shaken axis, None where the log does not say it.

    As measured where it was measured: in plane that of hole and bushing, out of plane that of
    the bushing's length and the coupon's thickness. Else the nominal clearance.
    """
    axial = test.orientation.lower().replace("-", " ").startswith("out of plane")
    play = _play_as_measured(test, axial=axial) if which == "actual" else None
    if play is None:
        if test.clearance is None:
            return None
        play, axial = Play(test.clearance, "nominal"), False
    return play if warming is None else _warmed(play, warming, axial=axial)


def _play_as_measured(test: Test, *, axial: bool) -> Play | None:
    if axial and test.actual_axial_clearance is not None:
        return Play(test.actual_axial_clearance, "measured out of plane")
    if test.actual_clearance is not None:
        return Play(test.actual_clearance, "measured")
    return None


def _warmed(play: Play, warming: Warming, *, axial: bool) -> Play:
    """Return the play at another temperature.

    Out of plane the bushing is the opening and the coupon the insert.
    """
    fit = warming.fit
    if axial:
        size = warming.thickness
        fit = ThermalFit(size + play.total, size, fit.insert_expansion, fit.opening_expansion)
    else:
        fit = replace(fit, opening=fit.insert + play.total)
    total = clearances_at(fit, warming.change).play
    return Play(max(0.0, total), f"{play.says}, {warming.change:+.4g} K")


@final
@dataclass(frozen=True, slots=True)
class Walls:
    """Free play to either side of where the joint rests [m]; infinite where nothing stands."""

    positive: float
    negative: float

    @property
    def near(self) -> float:
        """The smaller one: contact on one side [m]."""
        return min(self.positive, self.negative)

    @property
    def far(self) -> float:
        """The larger one: contact on both sides [m]."""
        return max(self.positive, self.negative)


@final
@dataclass(frozen=True, slots=True)
class JointMode:
    """A natural frequency [Hz] and its damping ratio [-]."""

    frequency: float
    damping_ratio: float


class AbstractJoint(ABC):
    """Joint whose parts move against each other in a test."""

    __slots__ = ()

    @abstractmethod
    def gain(self, frequency: FloatArray) -> ComplexArray:
        """Return relative displacement over input at frequencies [Hz], complex array [s²]."""

    @abstractmethod
    def modes(self) -> tuple[JointMode, ...]:
        """Return the modes as long as nothing touches, lowest first."""

    @abstractmethod
    def walls(self) -> Walls | None:
        """Return the walls that the joint itself knows; None where only the log says them."""


@final
@dataclass(frozen=True, slots=True)
class FreeJoint(AbstractJoint):
    """A part that nothing holds inside its play: it keeps still while the table moves.

    Its relative displacement is that of the table, eq. 5.5.
    """

    def gain(self, frequency: FloatArray) -> ComplexArray:
        return np.asarray(1.0 / (2.0 * np.pi * frequency) ** 2, np.complex128)

    def modes(self) -> tuple[JointMode, ...]:
        return ()

    def walls(self) -> Walls | None:
        return None


@final
@dataclass(frozen=True, slots=True, eq=False)
class ModelJoint(AbstractJoint):
    """A joint of a model whose gaps are open and whose other laws are those of rest.

    Attributes
    ----------
    between : (str, str)
        Its two places.
    mass, damping, stiffness : (n, n) arrays
        Matrices [kg], [N s/m], [N/m].
    load : (n,) array
        Forces for an input of 1 [kg] or [-].
    direction : (n,) array
        Relative displacement as a sum of the degrees of freedom [-].
    own_walls : Walls, optional
        Of the gaps and stops between the two places.
    notes : tuple of str
        What was left out, a sentence each.
    """

    between: tuple[str, str]
    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    load: ComplexArray
    direction: FloatArray
    own_walls: Walls | None
    notes: tuple[str, ...] = ()

    def gain(self, frequency: FloatArray) -> ComplexArray:
        omega = 2.0 * np.pi * np.atleast_1d(np.asarray(frequency, float))[:, None, None]
        dynamic = self.stiffness + 1j * omega * self.damping - omega**2 * self.mass
        load = np.broadcast_to(self.load[:, None], (len(omega), self.load.size, 1))
        values: ComplexArray = np.linalg.solve(dynamic, load)[..., 0] @ self.direction
        return values.reshape(np.shape(frequency))

    def modes(self) -> tuple[JointMode, ...]:
        n = self.load.size
        state = np.zeros((2 * n, 2 * n))
        state[:n, n:] = np.eye(n)
        state[n:, :n] = -np.linalg.solve(self.mass, self.stiffness)
        state[n:, n:] = -np.linalg.solve(self.mass, self.damping)
        roots = np.linalg.eigvals(state)
        roots = roots[roots.imag > 1e-9 * np.max(np.abs(roots))]
        joint_modes = [
            JointMode(float(abs(r)) / (2.0 * np.pi), float(-r.real / abs(r))) for r in roots
        ]
        return tuple(sorted(joint_modes, key=lambda mode: mode.frequency))

    def walls(self) -> Walls | None:
        return self.own_walls


def joint_of_model(model: Model, between: tuple[str, str] | None = None) -> ModelJoint:
    """Return a joint of a model.

    Parameters
    ----------
    model : Model
        What is shaken.
    between : (str, str), optional
        Its two places; by default those of the first gap or stop, else of the first element
        on the base, else of the first element.

    Raises
    ------
    ModelError
        If no element stands between the places, or the model changes with time.
    """
    check_unscaled(model, "a plan")
    elements = resolved(model)
    chosen = _chosen(model, elements, between)
    system, linear = system_of_model(model, 1.0), coordinates_of(model, elements)
    reference = {c.name: c.law.reference_stiffness for c in system.couplings}
    damping, stiffness, notes = system.damping.copy(), system.stiffness.copy(), []
    for element in elements:
        square = np.outer(*2 * [linear.across(element.between)])
        laws = {row.law for row in element.effect.rows()}
        if laws <= {Law.LINEAR, Law.ATTACHED}:
            continue
        if Law.FRICTION in laws:
            name = f"{element.effect.kind} between {' and '.join(element.between)}"
            notes.append(f"The {name} is left out: the joint is taken to slide without it.")
        elif isinstance(element.effect, AbstractMemorylessEffect):
            at_rest = element.effect.slopes(np.array([-TINY, TINY]), np.zeros(2))
            stiffness += float(np.mean(at_rest[0])) * square
            damping += float(np.mean(at_rest[1])) * square
        else:
            name = f"{element.effect.kind} between {' and '.join(element.between)}"
            stiffness += reference[name] * square
    direction, walls = linear.across(chosen), _walls(elements, chosen)
    return ModelJoint(
        chosen, system.mass, damping, stiffness, system.load, direction, walls, tuple(notes)
    )


def _chosen(
    model: Model, elements: tuple[Element, ...], between: tuple[str, str] | None
) -> tuple[str, str]:
    """Return the places of the joint.

    Raises
    ------
    ModelError
        If no element stands between them.
    """
    pairs = [element.between for element in elements]
    if between is not None:
        for pair in pairs:
            if set(pair) == set(between):
                return pair
        known = ", ".join(dict.fromkeys(f"{a},{b}" for a, b in pairs))
        raise ModelError(
            f"{model.title}: nothing stands between {between[0]} and {between[1]}; "
            f"the joints are {known}"
        )
    played = [pair for pair in pairs if _walls(elements, pair) is not None]
    on_base = [pair for pair in pairs if BASE in pair]
    return (played or on_base or pairs)[0]


def _walls(elements: tuple[Element, ...], between: tuple[str, str]) -> Walls | None:
    """Return where the nearest contacts of gaps and stops stand, from their switchings."""
    positive, negative = np.inf, np.inf
    for element in elements:
        if set(element.between) != set(between):
            continue
        if not isinstance(element.effect, AbstractMemorylessEffect):
            continue
        sign = 1.0 if element.between == between else -1.0
        for switch in element.effect.switches():
            if switch.variable == "displacement" and switch.at != 0.0:
                if sign * switch.at > 0.0:
                    positive = min(positive, abs(switch.at))
                else:
                    negative = min(negative, abs(switch.at))
    if positive == negative == np.inf:
        return None
    return Walls(positive, negative)
