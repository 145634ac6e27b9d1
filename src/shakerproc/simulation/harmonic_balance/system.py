"""A model as harmonic balance sees it: matrices, a harmonic load, forces along directions."""

from dataclasses import dataclass
from typing import final

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.simulation.harmonic_balance.friction import DryFrictionLaw
from shakerproc.simulation.harmonic_balance.laws import AbstractLaw


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
