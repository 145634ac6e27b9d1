"""Modal analysis, arrays in and arrays out: poles, stabilisation, residues, shapes, MAC."""

from shakerproc.modal.identification import identify_functions, identify_samples
from shakerproc.modal.modal_model import ModeSet, Settings, response_functions
from shakerproc.modal.output_only import identify_output_only
from shakerproc.modal.shapes import mac, normalised, phase_collinearity
