"""YAML model files in and out, comments and order kept."""

from shakerproc.model_files.editing import NewNumbers, add_element, change_parameters
from shakerproc.model_files.effect_files import (
    Conditions,
    EffectSource,
    effect_hashes,
    load_effects,
    used_effects,
)
from shakerproc.model_files.reading import ModelFile, read_model, read_model_file
from shakerproc.model_files.writing import (
    Provenance,
    element_text,
    model_text,
    structure_text,
    write_model,
)

__all__ = [
    "Conditions",
    "EffectSource",
    "ModelFile",
    "NewNumbers",
    "Provenance",
    "add_element",
    "change_parameters",
    "effect_hashes",
    "element_text",
    "load_effects",
    "model_text",
    "read_model",
    "read_model_file",
    "structure_text",
    "used_effects",
    "write_model",
]
