"""Formulas of one mass, exact or as the thesis prints them, printed errors put right."""

from shakerproc.simulation.closed_forms.duffing import (
    duffing_amplitudes,
    duffing_free_frequency,
    duffing_free_motion,
    duffing_harmonic_force,
    duffing_harmonic_free_frequency,
    duffing_harmonic_frequency,
    duffing_perturbation_motion,
    duffing_response_frequencies,
)
from shakerproc.simulation.closed_forms.friction import (
    coulomb_amplitude,
    coulomb_harmonic_amplitude,
    coulomb_sliding_bound,
    equivalent_viscous_damping,
    equivalent_viscous_damping_ratio,
)
from shakerproc.simulation.closed_forms.gap import (
    bilinear_frequency_ratio,
    displacement_amplitude,
    gap_backbone,
    gap_describing_function,
    gap_harmonic_backbone,
    power_law_frequency,
)
from shakerproc.simulation.closed_forms.linear import (
    critical_damping,
    damped_frequency,
    forced_motion,
    magnification,
    natural_frequency,
    phase_lag,
    steady_amplitude,
    steady_phase,
)

__all__ = [
    "bilinear_frequency_ratio",
    "coulomb_amplitude",
    "coulomb_harmonic_amplitude",
    "coulomb_sliding_bound",
    "critical_damping",
    "damped_frequency",
    "displacement_amplitude",
    "duffing_amplitudes",
    "duffing_free_frequency",
    "duffing_free_motion",
    "duffing_harmonic_force",
    "duffing_harmonic_free_frequency",
    "duffing_harmonic_frequency",
    "duffing_perturbation_motion",
    "duffing_response_frequencies",
    "equivalent_viscous_damping",
    "equivalent_viscous_damping_ratio",
    "forced_motion",
    "gap_backbone",
    "gap_describing_function",
    "gap_harmonic_backbone",
    "magnification",
    "natural_frequency",
    "phase_lag",
    "power_law_frequency",
    "steady_amplitude",
    "steady_phase",
]
