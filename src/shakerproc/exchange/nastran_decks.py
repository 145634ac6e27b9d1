"""The thesis' decks: masses on nonlinear springs in SOL 400, a clamped coupon in SOL 103."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.errors import ExchangeError

Field = str | int | float | None

_FIRST_TABLE = 101


def card(name: str, *fields: Field) -> str:
    """Return one card in large fields, continued as often as needed.

    Raises
    ------
    ValueError
        If a text does not fit its field.
    """
    columns = [_large(field) for field in fields]
    rows = [columns[i : i + 4] for i in range(0, len(columns), 4)] or [[]]
    if len(rows) % 2:
        rows.append([])  # a large-field card comes in pairs of lines
    lines = [f"{name + '*':<8}{''.join(rows[0])}"]
    lines += [f"{'*':<8}{''.join(row)}" for row in rows[1:]]
    return "\n".join(line.rstrip() for line in lines)


def table(identity: int, points: Iterable[tuple[float, float]]) -> str:
    """Return a TABLED1 card of (x, y) points, closed by ENDT.

    x in [s] or [Hz], y in any unit.
    """
    fields: list[Field] = [identity, None, None, None, None, None, None, None]
    for x, y in points:
        fields += [float(x), float(y)]
    return card("TABLED1", *fields, "ENDT")


def _large(field: Field) -> str:
    if field is None:
        return " " * 16
    if isinstance(field, float):
        return f"{real16(field):>16}"
    text = str(field)
    if len(text) > 16:
        raise ValueError(f"{text!r} does not fit a field of 16 columns")
    return f"{text:<16}" if isinstance(field, str) else f"{text:>16}"


def real16(value: float) -> str:
    """Return a number with as many digits as 16 columns hold, with its decimal point.

    `value` may be in any unit.

    Raises
    ------
    ValueError
        If no form fits, as of infinity.
    """
    for digits in range(13, 5, -1):
        text = f"{value:.{digits}E}"
        if "." in text and len(text) <= 16:
            return text
    raise ValueError(f"{value!r} does not fit a field of 16 columns")


def deck(executive: Iterable[str], case: Iterable[str], bulk: Iterable[str]) -> str:
    """Return a whole deck, from its first line to ENDDATA."""
    return "\n".join(_sections(executive, case, bulk)) + "\n"


def _sections(
    executive: Iterable[str], case: Iterable[str], bulk: Iterable[str]
) -> Iterator[str]:
    yield from executive
    yield "CEND"
    yield from case
    yield "BEGIN BULK"
    yield from bulk
    yield "ENDDATA"


def cards_of(text: str) -> list[list[str]]:
    """Return the large-field cards of a deck, each its name and its fields."""
    rows: list[list[str]] = []
    for line in text.partition("BEGIN BULK\n")[2].splitlines():
        fields = [line[8 + 16 * i : 24 + 16 * i].strip() for i in range(4)]
        if line.startswith("*"):
            rows[-1] += fields
        elif line[:8].rstrip().endswith("*"):
            rows.append([line[:8].rstrip(" *"), *fields])
    return rows


@final
@dataclass(frozen=True, slots=True, eq=False)
class Bush:
    """A spring between two places, linear or by a table of force over displacement.

    Attributes
    ----------
    between : tuple of str
        Names of the two places, ``base`` being the fixed one.
    stiffness : float
        Slope about rest [N/m].
    displacement, force : (n,) array, optional
        The law where it is not linear [m] and [N].
    """

    between: tuple[str, str]
    stiffness: float
    displacement: FloatArray | None = None
    force: FloatArray | None = None


@final
@dataclass(frozen=True, slots=True, eq=False)
class TransientDeck:
    """Masses on a line, the springs and dampers between them, and the forces on them.

    Attributes
    ----------
    title : str
        First line of the deck.
    masses : mapping of str to float
        [kg].
    springs : sequence of Bush
        Springs.
    dampers : sequence of (place, place, damping)
        Viscous dampers [N s/m].
    time : (n,) array
        Of the force [s].
    forces : mapping of str to (n,) array
        Force on each mass that one acts on [N].
    initial_velocity : mapping of str to float
        [m/s].
    steps : int
        Output steps over the length of the force.
    """

    title: str
    masses: Mapping[str, float]
    springs: Sequence[Bush]
    dampers: Sequence[tuple[str, str, float]]
    time: FloatArray
    forces: Mapping[str, FloatArray]
    initial_velocity: Mapping[str, float]
    steps: int


def transient_deck(model: TransientDeck) -> str:
    """Return the SOL 400 deck of a model: CBUSH, PBUSHT, CVISC, CONM2, TLOAD1, TIC, NLSTEP.

    Displacements are relative to the base, which is held; a base that moves comes in as forces
    -m a on the masses.

    References
    ----------
    .. [1] A. H. Hauglid, "Nonlinear Mechanical Vibrations: The Effect of Gaps", NTNU, 2018,
       appendix A.
    """
    case = (
        f"TITLE = {_plain(model.title)}",
        "ECHO = NONE",
        "SUBCASE 1",
        "  STEP 1",
        "    ANALYSIS = NLTRAN",
        "    NLSTEP = 1",
        "    SPC = 2",
        *(["    IC = 1"] if model.initial_velocity else []),
        "    DLOAD = 2",
        *(
            f"    {quantity}(PRINT,PUNCH,SORT1,REAL)=ALL"
            for quantity in ("DISPLACEMENT", "VELOCITY", "ACCELERATION")
        ),
    )
    return deck(("SOL 400",), case, _transient_bulk(model))


def _transient_bulk(model: TransientDeck) -> Iterator[str]:
    nodes = {"base": 1} | {name: i for i, name in enumerate(model.masses, 2)}
    yield "PARAM,POST,1"
    yield "PARAM,LGDISP,1"
    yield card("NLSTEP", 1, float(model.time[-1]), *([None] * 6), "FIXED", model.steps, 1)
    for name, node in nodes.items():
        yield f"$ {_plain(name)}"
        yield card("GRID", node, None, float(node - 1), 0.0, 0.0)
    yield card("SPC1", 2, 123456, 1)
    for node in list(nodes.values())[1:]:
        yield card("SPC1", 2, 23456, node)  # each mass moves along the line only
    element = 1
    for name, mass in model.masses.items():
        yield card("CONM2", element, nodes[name], None, float(mass))
        element += 1
    for number, spring in enumerate(model.springs, 1):
        yield card("PBUSH", number, "K", float(spring.stiffness))
        if spring.displacement is not None and spring.force is not None:
            yield card("PBUSHT", number, "KN", _FIRST_TABLE + number)
            points = zip(spring.displacement, spring.force, strict=True)
            yield table(_FIRST_TABLE + number, points)
        ends = [nodes[place] for place in spring.between]
        yield card("CBUSH", element, number, *ends)  # its axis is the line between the nodes
        element += 1
    for number, (first, second, damping) in enumerate(model.dampers, len(model.springs) + 1):
        yield card("PVISC", number, float(damping))
        yield card("CVISC", element, number, nodes[first], nodes[second])
        element += 1
    for name, velocity in model.initial_velocity.items():
        yield card("TIC", 1, nodes[name], 1, 0.0, float(velocity))
    yield from _loads(model, nodes)


def _loads(model: TransientDeck, nodes: Mapping[str, int]) -> Iterator[str]:
    loads = range(10, 10 + len(model.forces))
    yield card("DLOAD", 2, 1.0, *(part for load in loads for part in (1.0, load)))
    for load, (name, force) in zip(loads, model.forces.items(), strict=True):
        yield card("TLOAD1", load, 100 + load, None, "LOAD", 200 + load)
        yield card("FORCE", 100 + load, nodes[name], 0, 1.0, 1.0, 0.0, 0.0)
        yield table(200 + load, zip(model.time, force, strict=True))


@final
@dataclass(frozen=True, slots=True)
class PlateDeck:
    """An annular plate, held inside, for normal modes.

    Attributes
    ----------
    title : str
        First line of the deck.
    clamped_radius, outer_radius, thickness : float
        [m].
    youngs_modulus, poissons_ratio, density : float
        Material [Pa], [-], [kg/m³].
    radial, around : int
        Elements.
    modes : int
        How many modes.
    """

    title: str
    clamped_radius: float
    outer_radius: float
    thickness: float
    youngs_modulus: float
    poissons_ratio: float
    density: float
    radial: int = 20
    around: int = 80
    modes: int = 10


def plate_deck(plate: PlateDeck) -> str:
    """Return the SOL 103 deck of an annular plate of CQUAD4 elements, clamped at its inside."""
    case = (
        f"TITLE = {_plain(plate.title)}",
        "ECHO = NONE",
        "METHOD = 1",
        "SPC = 1",
        "DISPLACEMENT(PRINT,PUNCH)=ALL",
    )
    return deck(("SOL 103",), case, _plate_bulk(plate))


def _plate_bulk(plate: PlateDeck) -> Iterator[str]:
    around = plate.around
    yield "PARAM,POST,-1"
    yield card("EIGRL", 1, None, None, plate.modes)
    yield card("MAT1", 1, plate.youngs_modulus, None, plate.poissons_ratio, plate.density)
    yield card("PSHELL", 1, 1, plate.thickness, 1, None, 1)
    radii = np.linspace(plate.clamped_radius, plate.outer_radius, plate.radial + 1)
    for ring, radius in enumerate(radii):
        for place in range(around):
            angle = 2.0 * np.pi * place / around
            node = 1 + ring * around + place
            x, y = float(radius * np.cos(angle)), float(radius * np.sin(angle))
            yield card("GRID", node, None, x, y, 0.0)
    for ring in range(plate.radial):
        for place in range(around):
            low, high = 1 + ring * around, 1 + (ring + 1) * around
            after = (place + 1) % around
            corners = (low + place, high + place, high + after, low + after)
            yield card("CQUAD4", 1 + ring * around + place, 1, *corners)
    for node in range(1, around + 1):
        yield card("SPC1", 1, 123456, node)
    for node in range(around + 1, 1 + around * (plate.radial + 1)):
        yield card("SPC1", 1, 6, node)  # a flat shell has no stiffness about its normal


def _plain(text: str) -> str:
    """Return text that cannot end a line of the deck."""
    return " ".join(text.encode("ascii", "replace").decode().split())[:60]


def forces_of_deck(path: Path) -> dict[int, tuple[FloatArray, FloatArray, float]]:
    """Return time [s], force [N] and mass [kg] of each node that a deck written here pushes.

    Raises
    ------
    ExchangeError
        If the file is no such deck.
    """
    try:
        cards = cards_of(path.read_text(encoding="ascii"))
        tables = {
            int(c[1]): np.array([float(f) for f in c[9 : c.index("ENDT")]]).reshape(-1, 2).T
            for c in cards
            if c[0] == "TABLED1"
        }
        nodes = {int(c[1]): int(c[2]) for c in cards if c[0] == "FORCE"}
        masses = {int(c[2]): float(c[4]) for c in cards if c[0] == "CONM2"}
        loads = {int(c[2]): int(c[5]) for c in cards if c[0] == "TLOAD1"}
        found = {
            nodes[load]: (*tables[number], masses[nodes[load]])
            for load, number in loads.items()
        }
    except (ValueError, KeyError, IndexError) as error:
        raise ExchangeError(
            f"{path.name}: not a SOL 400 deck that shakerproc nastran write has written"
        ) from error
    if not found:
        raise ExchangeError(f"{path.name}: the deck has no force over time")
    return found
