"""Periodic motion of a model: response curves, stability, backbones, by harmonic balance."""

from shakerproc.simulation.harmonic_balance.backbone import Backbone, backbone
from shakerproc.simulation.harmonic_balance.branch import Branch, samples_of_branch, sharpened
from shakerproc.simulation.harmonic_balance.outputs import (
    gap_severity,
    notable_points,
    peaks,
    response_columns,
    sensor_harmonics,
    sensors_of_model,
)
from shakerproc.simulation.harmonic_balance.response import (
    Response,
    difference_from_simulation,
    frequency_response,
    natural_frequencies,
)
from shakerproc.simulation.harmonic_balance.switching import branches_off, subharmonic_branches
