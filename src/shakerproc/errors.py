"""Errors of the input: one class for each kind, all children of ShakerprocError."""

from pathlib import Path


class ShakerprocError(Exception):
    """Something in the input cannot be used; the message is one line for the user."""


class RecordingError(ShakerprocError):
    """A recording cannot be used."""


class SpectraError(RecordingError):
    """A file holds spectra and no samples over time.

    Attributes
    ----------
    holds : str
        What it holds, such as ``frequency response functions (3)``.
    """

    def __init__(self, message: str, holds: str) -> None:
        self.holds = holds
        super().__init__(message)


class DocumentError(ShakerprocError):
    """A YAML file (test log, model, study, coupon) cannot be used.

    Attributes
    ----------
    path : Path
        The file.
    line, column : int
        Where in the file, both from 1.
    says : str
        The message without the place.
    """

    def __init__(self, path: Path, line: int, column: int, message: str) -> None:
        self.path = path
        self.line = line
        self.column = column
        self.says = message
        super().__init__(f"{path}:{line}:{column}: {message}")


class LogError(ShakerprocError):
    """A test of the log cannot be processed as it is described."""


class ModelError(ShakerprocError):
    """A model cannot be used for a task."""


class SimulationError(ShakerprocError):
    """A simulation cannot be carried out to the accuracy that was asked."""


class SpectrumError(ShakerprocError):
    """Samples do not allow the spectrum, crop or filter that was asked."""


class DiagnosisError(ShakerprocError):
    """A model and a log do not fit together, or the log holds too little for a diagnosis."""


class ExchangeError(ShakerprocError):
    """A file of another program cannot be used."""


class TableError(ShakerprocError):
    """A table of results cannot be used."""


class PrintingError(ShakerprocError):
    """A report cannot be printed."""


class OutputError(ShakerprocError):
    """A place for results cannot be written to."""


class ClusterError(ShakerprocError):
    """The cluster that was asked for cannot be used, or is lost."""


class LockedError(ShakerprocError):
    """Another shakerproc works in this folder (exit status 75)."""


class ArgumentError(ShakerprocError, ValueError):
    """An option of a command, or an argument of a function, cannot be used.

    Attributes
    ----------
    name : str
        Name of the argument.
    says : str
        The message without the name.
    """

    def __init__(self, name: str, says: str) -> None:
        self.name = name
        self.says = says
        super().__init__(f"{name}: {says}")

    def __reduce__(self) -> tuple[type["ArgumentError"], tuple[str, str]]:
        """Return how it is pickled: by its parts."""
        return type(self), (self.name, self.says)
