"""Modes of the tests of a log, with their response functions, shapes and remarks."""

from dataclasses import dataclass
from typing import Final, final

from shakerproc.data import Channel, ComplexArray, FloatArray
from shakerproc.geometry import Place, Wireframe
from shakerproc.modal.geometry import Geometry, geometry_of
from shakerproc.modal.modal_model import ModeSet
from shakerproc.modal.tracking import Track
from shakerproc.numerals import numeral
from shakerproc.testlog import Test

ALIKE: Final = 0.95
"""Least correlation of two functions that are one [-]: a shift of a resonance by a third of its
half-power width, as a sensor's mass makes it, leaves as much."""

LEVEL: Final = 0.1
"""Largest difference of their sizes [-]: sensitivities of a hammer and of a sensor are known to
some per cent each."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Functions:
    """Response functions of a test, measured and synthesised alike.

    Attributes
    ----------
    frequency : (n_frequencies,) array
        Within the band [Hz].
    measured, synthesis : (n_responses, n_inputs, n_frequencies) complex array
        H1 of the measurement, and of what the model answers to the same input, both through
        the same window, so that leakage is the same in both [response unit/input unit].
    coherence : (n_responses, n_frequencies) array
        Multiple coherence of the measurement [-].
    """

    frequency: FloatArray
    measured: ComplexArray
    synthesis: ComplexArray
    coherence: FloatArray


@final
@dataclass(frozen=True, slots=True, eq=False)
class TestModes:
    """Modes of one test.

    Attributes
    ----------
    name : str
        Its id, with the name of the log in front where there are two; of several tests that are
        fitted together, the ids.
    test : Test
        What the log says, of the first where several are fitted together.
    sensors : tuple of Channel
        Rows of the shapes.
    positions, directions : tuple
        Where they sit [m] and measure [-]; None where the log does not say it.
    inputs, input_units : tuple of str
        Names and units of the inputs.
    input_places : tuple
        Position and direction of each force, None where the log does not say them, or where
        the input is the mean of controls.
    band : (float, float)
        Where modes were looked for [Hz].
    modes : ModeSet
        What was found.
    functions : Functions, optional
        None where no input was measured.
    density : (n_responses + 1, n_frequencies) array
        Frequencies of the band [Hz] first, then densities of the responses [unit²/Hz].
    unexplained : (n_responses,) array
        Rms of what the model leaves over the rms measured, in the band [-].
    notes : tuple of str
        What the user should know, a sentence each.
    recordings : tuple of (str, str, str)
        Id of the test, name and SHA-256 of each recording that went in.
    wireframe : Wireframe, optional
        Lines and surfaces on which the shapes are drawn.
    """

    __test__ = False

    name: str
    test: Test
    sensors: tuple[Channel, ...]
    positions: tuple[Place | None, ...]
    directions: tuple[Place | None, ...]
    inputs: tuple[str, ...]
    input_units: tuple[str, ...]
    input_places: tuple[tuple[Place | None, Place | None], ...]
    band: tuple[float, float]
    modes: ModeSet
    functions: Functions | None
    density: FloatArray
    unexplained: FloatArray
    notes: tuple[str, ...]
    recordings: tuple[tuple[str, str, str], ...]
    wireframe: Wireframe | None = None

    @property
    def sensor_names(self) -> list[str]:
        """Names of the sensors, in the order of the shapes."""
        return [channel.name for channel in self.sensors]

    @property
    def geometry(self) -> Geometry:
        """The sensors and the structure that they sit on, projected for a drawing."""
        return geometry_of(self.positions, self.directions, self.wireframe)


@final
@dataclass(frozen=True, slots=True, eq=False)
class Reciprocal:
    """Two response functions between the same two places, one there and one back.

    Attributes
    ----------
    names : (str, str)
        Test, response and input of each.
    units : (str, str)
        Of response and input.
    frequency : (n_frequencies,) array
        Lines that both have [Hz].
    functions : (2, n_frequencies) complex array
        Both, turned the same way round.
    correlation : float
        Real part of their correlation over the lines, -1 to 1 [-].
    ratio : float
        Rms of the second over that of the first [-].
    """

    names: tuple[str, str]
    units: tuple[str, str]
    frequency: FloatArray
    functions: ComplexArray
    correlation: float
    ratio: float

    @property
    def problem(self) -> str:
        """The disagreement; empty where both agree."""
        first, second = self.names
        if self.correlation <= -ALIKE:
            return (
                f"{first} and {second} are reciprocal with the opposite sign: one of their "
                "sensors or forces is the wrong way round"
            )
        if self.correlation < ALIKE:
            return (
                f"{first} and {second} should be reciprocal, but correlate by "
                f"{self.correlation:.2f} only: places or directions in the log are wrong, the "
                "structure is not linear, or a sensor that was moved shifts its resonances"
            )
        if abs(self.ratio - 1.0) > LEVEL:
            return (
                f"{second} is {numeral(self.ratio)} times its reciprocal {first}: check the "
                "sensitivities of forces and sensors"
            )
        return ""


@final
@dataclass(frozen=True, slots=True, eq=False)
class ModalAnalysis:
    """Modes of the tests of a log, or of two.

    Attributes
    ----------
    title : str
        Of the log.
    tests : tuple of TestModes
        Those that could be analysed.
    tracks : tuple of Track
        Each mode through the tests.
    failed : tuple of (str, str)
        Names of those that could not, and why.
    notes : tuple of str
        What concerns several tests.
    reciprocals : tuple of Reciprocal
        Response functions between the same two places, there and back.
    """

    title: str
    tests: tuple[TestModes, ...]
    tracks: tuple[Track, ...]
    failed: tuple[tuple[str, str], ...]
    notes: tuple[str, ...]
    reciprocals: tuple[Reciprocal, ...] = ()


def file_name(test: str) -> str:
    """Return how files of a test begin, by its name: letters and digits alone."""
    return "test_" + "".join(c if c.isascii() and c.isalnum() else "_" for c in test)
