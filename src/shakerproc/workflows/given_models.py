"""A model as a caller hands it over: from a file, from a result, or made in Python."""

from dataclasses import dataclass
from typing import Any

from shakerproc.errors import ArgumentError
from shakerproc.model_files import ModelFile
from shakerproc.models import Model
from shakerproc.workflows.arguments import told


@dataclass(frozen=True, slots=True, eq=False)
class GivenModel:
    """A model, and the file it is from, if it is from one.

    Attributes
    ----------
    model : Model
        The model.
    file : ModelFile, optional
        Where it stands.
    """

    model: Model
    file: ModelFile | None = None


def model_of(given: Any, name: str = "model") -> GivenModel:
    """Return a model: as read from a file, as a result holds it, or as made in Python.

    Raises
    ------
    ArgumentError
        If it is none.
    """
    if isinstance(given, ModelFile):
        return GivenModel(given.model, given)
    if isinstance(given, Model):
        return GivenModel(given)
    raise ArgumentError(
        name, f"expected a model, as read_model(path) returns it, got {told(given)}"
    )
