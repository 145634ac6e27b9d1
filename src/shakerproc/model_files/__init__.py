"""YAML model files in and out, comments and order kept."""

from shakerproc.model_files.editing import NewNumbers, add_element, change_parameters
from shakerproc.model_files.effect_files import EffectSource, load_effects, used_effects
from shakerproc.model_files.reading import ModelFile, read_model, read_model_file
from shakerproc.model_files.writing import (
    Provenance,
    element_text,
    model_text,
    structure_text,
    write_model,
)
