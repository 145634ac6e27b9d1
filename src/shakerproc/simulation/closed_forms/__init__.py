"""Formulas of one mass, exact or as the thesis prints them, printed errors put right."""

from shakerproc.simulation.closed_forms.linear import (
    coulomb_amplitude,
    coulomb_harmonic_amplitude,
    critical_damping,
    damped_frequency,
    equivalent_viscous_damping,
    equivalent_viscous_damping_ratio,
    forced_motion,
    magnification,
    natural_frequency,
    phase_lag,
    steady_amplitude,
    steady_phase,
)
from shakerproc.simulation.closed_forms.nonlinear import (
    bilinear_frequency_ratio,
    displacement_amplitude,
    duffing_amplitudes,
    duffing_free_frequency,
    duffing_free_motion,
    duffing_harmonic_force,
    duffing_harmonic_free_frequency,
    duffing_harmonic_frequency,
    duffing_perturbation_motion,
    duffing_response_frequencies,
    gap_backbone,
    gap_describing_function,
    gap_harmonic_backbone,
    power_law_frequency,
)
