"""``shakerproc nastran write`` and ``shakerproc nastran read``."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from shakerproc.cli import options, output
from shakerproc.cli.commands import GroupedCommand

if TYPE_CHECKING:
    from shakerproc.data import FloatArray
    from shakerproc.models import Model

MANY = 200_000
"""Points of a force table from which on the deck is large."""

nastran = typer.Typer(
    no_args_is_help=True,
    rich_markup_mode=None,
    help="Write decks for Nastran, and read its punch files.",
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)


@dataclass(frozen=True, slots=True)
class DeckVariation:
    """One parameter of the study: its place, and its values as text and in SI."""

    place: str
    texts: tuple[str, ...]
    values: tuple[float, ...]


@nastran.command("write", cls=GroupedCommand)
def write(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="MODEL|STUDY|COUPON",
            help="Model, study or coupon (YAML).",
            exists=True,
            dir_okay=False,
        ),
    ],
    out: Annotated[Path, typer.Option(metavar="FOLDER", file_okay=False, help="For decks.")],
    level: Annotated[
        str | None, typer.Option(metavar="LEVEL", help='Amplitude, such as "5 N" or "0.5 g".')
    ] = None,
    from_hz: Annotated[float, typer.Option(help="Sweep from [Hz].", min=0.0)] = 0.0,
    to_hz: Annotated[float, typer.Option(help="Sweep to [Hz].", min=0.0)] = 30.0,
    length_s: Annotated[float, typer.Option(help="Length of the sweep [s].", min=0.0)] = 30.0,
    sample_rate_hz: Annotated[float, typer.Option(help="Of the sweep [Hz].", min=0.0)] = 1000.0,
    spacing: Annotated[
        Literal["linear", "octaves"], typer.Option(help="How the frequency rises.")
    ] = "linear",
    log: Annotated[
        Path | None,
        typer.Option(
            metavar="TESTLOG", help="Shake with a test of this log instead.", exists=True
        ),
    ] = None,
    test: Annotated[str | None, typer.Option(metavar="ID", help="Test of the log.")] = None,
    velocity: Annotated[
        list[str] | None,
        typer.Option(metavar='"MASS=4 m/s"', help="Initial velocity; may be repeated."),
    ] = None,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PLACE=VALUES",
            help='A deck for each, as "gap.clearance=0.1 mm,0.25 mm"; may be repeated.',
        ),
    ] = None,
    reach: Annotated[
        str | None,
        typer.Option(metavar="LENGTH", help='Range of the tables of curved laws, as "1 mm".'),
    ] = None,
    steps: Annotated[
        int | None, typer.Option(help="Steps of output.", min=2, show_default="all")
    ] = None,
    modes: Annotated[int, typer.Option(help="Modes of a coupon's deck.", min=1)] = 10,
    json: output.JsonOption = None,
) -> None:
    """Write a SOL 400 deck of a model, one for each point of a study, or SOL 103 of a coupon.

    Displacements are relative to the base, which is held: its acceleration becomes forces on
    the masses. Units are SI. MSC Nastran runs both; MYSTRAN runs the coupon (SOL 3).
    """
    if _says(source, "coupon"):
        written = _write_coupon(source, out, modes)
    elif _says(source, "study"):
        written = _write_study(source, out, reach=_length(reach), steps=steps)
    else:
        from shakerproc.model_files import read_model
        from shakerproc.models.validation import check_unscaled

        model = read_model(source)
        check_unscaled(model, "nastran")
        time, excitation = (
            _measured(model, log, test)
            if log is not None
            else _sweep(model, level, from_hz, to_hz, length_s, sample_rate_hz, spacing)
        )
        if time.size > MANY:
            output.warning(f"the table of the force has {time.size} points")
        variations = [_variation(model, text) for text in vary or []]
        written = _write_models(
            source,
            model,
            variations,
            (time, excitation),
            out,
            velocity=_velocities(model, velocity or []),
            reach=_length(reach),
            steps=steps,
        )
    output.write_json(written, json)
    for row in written:
        output.data(str(out / str(row["deck"])))
    output.message(f"{len(written)} deck{'s' * (len(written) != 1)} in {out}")


@nastran.command("read", cls=GroupedCommand)
def read(
    punch: Annotated[
        Path,
        typer.Argument(metavar="FILE.pch", help="Punch file.", exists=True, dir_okay=False),
    ],
    out: Annotated[
        Path,
        typer.Argument(
            metavar="OUT", help="New file: .tdms, .csv, .mat, .uff or .parquet.", dir_okay=False
        ),
    ],
    deck: Annotated[
        Path | None,
        typer.Option(
            metavar="DECK",
            help="Deck that made it: adds force over mass as control.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
) -> None:
    """Write the results of a punch file as a recording, which process takes like any other."""
    from shakerproc.exchange.nastran_punch import recording_of_punch

    write_recording = output.writer_of(out)
    recording = recording_of_punch(punch, deck)
    write_recording(out, recording)
    output.tell_written(out, recording)


def _says(path: Path, key: str) -> bool:
    """Return whether a YAML file says coupon, or study, as its first key, and not model."""
    with path.open(encoding="utf-8", errors="replace") as lines:
        first = next((line for line in lines if re.match(r"\w", line)), "")
    return re.match(rf"{key}\s*:", first) is not None


def _write_study(
    source: Path, out: Path, *, reach: float | None, steps: int | None
) -> list[dict[str, object]]:
    """Write a deck for each point of a study, shaken as the study says.

    Raises
    ------
    ModelError
        If the study has no model or no run.
    """
    import numpy as np

    from shakerproc.errors import ModelError
    from shakerproc.exchange.nastran_decks import transient_deck
    from shakerproc.model_files.exchanged import deck_of_model
    from shakerproc.studies import read_study
    from shakerproc.studies.kinds.base import jobs_of
    from shakerproc.studies.readings import excitation_of

    study = read_study(source)
    if study.model is None or study.run is None:
        raise ModelError(f"{source}: a deck needs a model and a run; add what is missing")
    rows: list[dict[str, object]] = []
    decks: dict[str, str] = {}
    for job in jobs_of(study):
        model, run = job.require()
        samples = excitation_of(run)
        pairs = dict(zip([v.name for v in study.vary], job.texts, strict=True))
        parts = [f"{name}_{text}" for name, text in pairs.items()]
        name = _deck_name(source, parts)
        contents = deck_of_model(
            model,
            np.arange(samples.size) / run.sample_rate,
            samples,
            initial_velocity={next(iter(model.masses)): run.initial_velocity},
            reach=reach,
            steps=steps,
        )
        decks[name] = transient_deck(contents)
        rows.append({"deck": name, **pairs})
    return _written(out, rows, decks)


def _deck_name(source: Path, parts: Sequence[str]) -> str:
    """Return the name of the file of one deck of a study."""
    return re.sub(r"[^A-Za-z0-9.+-]+", "_", "_".join([source.stem, *parts])) + ".dat"


def _written(
    out: Path, rows: list[dict[str, object]], decks: dict[str, str]
) -> list[dict[str, object]]:
    """Write decks and the table of them; return its rows."""
    from shakerproc import files

    for name, text in decks.items():
        files.write_text(out / name, text)
    files.write_csv(out / "decks.csv", {key: [row[key] for row in rows] for key in rows[0]})
    return rows


def _write_coupon(source: Path, out: Path, modes: int) -> list[dict[str, object]]:
    from shakerproc import files
    from shakerproc.exchange.nastran_decks import PlateDeck, plate_deck
    from shakerproc.model_files.coupon_files import read_coupon

    described = read_coupon(source)
    coupon, name = described.coupon, f"{source.stem}.dat"
    plate = PlateDeck(
        title=described.title,
        clamped_radius=coupon.clamped_radius,
        outer_radius=coupon.outer_radius,
        thickness=coupon.thickness,
        youngs_modulus=coupon.material.youngs_modulus,
        poissons_ratio=coupon.material.poissons_ratio,
        density=coupon.material.density,
        modes=modes,
    )
    files.write_text(out / name, plate_deck(plate))
    return [{"deck": name}]


def _write_models(
    source: Path,
    model: "Model",
    variations: list[DeckVariation],
    excitation: "tuple[FloatArray, FloatArray]",
    out: Path,
    *,
    velocity: dict[str, float],
    reach: float | None,
    steps: int | None,
) -> list[dict[str, object]]:
    from shakerproc.exchange.nastran_decks import transient_deck
    from shakerproc.model_files.exchanged import deck_of_model
    from shakerproc.studies.study import placed

    time, samples = excitation
    rows: list[dict[str, object]] = []
    decks: dict[str, str] = {}
    for point in product(*(range(len(v.values)) for v in variations)):
        chosen = model
        for index, variation in zip(point, variations, strict=True):
            chosen = placed(chosen, None, [variation.place], variation.values[index])[0]
        texts = [v.texts[i] for i, v in zip(point, variations, strict=True)]
        pairs = list(zip([v.place for v in variations], texts, strict=True))
        parts = [f"{place.split('.', 1)[1]}_{text}" for place, text in pairs]
        name = _deck_name(source, parts)
        contents = deck_of_model(
            chosen, time, samples, initial_velocity=velocity, reach=reach, steps=steps
        )
        decks[name] = transient_deck(contents)
        rows.append({"deck": name, **dict(pairs)})
    return _written(out, rows, decks)


def _sweep(
    model: "Model",
    level: str | None,
    from_hz: float,
    to_hz: float,
    length_s: float,
    sample_rate_hz: float,
    spacing: str,
) -> "tuple[FloatArray, FloatArray]":
    """Return time and a sweep that begins with a cosine, as the thesis' does.

    Raises
    ------
    typer.BadParameter
        If a number is missing or does not fit.
    """
    import numpy as np

    from shakerproc.simulation.excitations import linear_sweep, logarithmic_sweep
    from shakerproc.units import to_si

    unit = model.excitation.unit
    if level is None:
        raise typer.BadParameter(
            f"give an amplitude [{unit}], or a test of a log", param_hint="--level"
        )
    with options.refused("--level"):
        amplitude = to_si(level, unit)
    if not (length_s > 0.0 and sample_rate_hz > 2.0 * max(from_hz, to_hz)):
        raise typer.BadParameter(
            f"must be more than twice {max(from_hz, to_hz):g} Hz, and --length-s above 0",
            param_hint="--sample-rate-hz",
        )
    if spacing == "octaves" and not (min(from_hz, to_hz) > 0.0 and from_hz != to_hz):
        raise typer.BadParameter(
            "octaves need two frequencies above 0 Hz that differ", param_hint="--from-hz"
        )
    time = np.arange(round(length_s * sample_rate_hz) + 1) / sample_rate_hz
    cosine = 0.5 * np.pi
    if spacing == "linear":
        return time, linear_sweep(from_hz, to_hz, length_s, amplitude, cosine)(time)
    rate = 60.0 * abs(float(np.log2(to_hz / from_hz))) / length_s
    return time, logarithmic_sweep(from_hz, to_hz, rate, amplitude, cosine)(time)


def _measured(
    model: "Model", log_path: Path, test_id: str | None
) -> "tuple[FloatArray, FloatArray]":
    """Return time and excitation of a test, between the ends of its crop.

    That is the mean of the controls, or the force where a force drives the model.

    Raises
    ------
    typer.BadParameter
        If no test is named.
    """
    import numpy as np

    from shakerproc.errors import LogError
    from shakerproc.runs import find_crop, open_test
    from shakerproc.testlog import read_testlog

    if test_id is None:
        raise typer.BadParameter("name a test of the log", param_hint="--test")
    log = read_testlog(log_path)
    chosen = log.find(test_id)
    with open_test(log, chosen) as recording:
        role = model.excitation.role
        controls = [i for i, c in enumerate(recording.channels) if c.role == role]
        if not controls:
            raise LogError(
                f"{chosen.source}: test {test_id} has no channel with the role {role} to shake "
                f"the model with; say in the log which it is"
            )
        crop = find_crop(recording, chosen)
        start, stop = (at / recording.sample_rate for at in (crop.start, crop.stop))
        output.tell_faults(recording, role, start, stop)
        samples = recording.select(controls).samples(crop.start, crop.stop)
        return np.arange(samples.shape[1]) / recording.sample_rate, samples.mean(axis=0)


def _variation(model: "Model", text: str) -> DeckVariation:
    """Return a parameter and its values.

    Raises
    ------
    typer.BadParameter
        If it is not written as PLACE=VALUE,VALUE or the model has no such place.
    """
    from shakerproc.studies.study import unit_of_place
    from shakerproc.units import to_si

    place, equals, values = text.partition("=")
    place = place.strip()
    if not (equals and values.strip()):
        raise typer.BadParameter(
            f'expected a place and values such as "gap.clearance=0.1 mm,0.25 mm", got {text!r}',
            param_hint="--vary",
        )
    if not place.startswith(("elements.", "masses.")):
        place = f"elements.{place}"
    texts = tuple(value.strip() for value in values.split(","))
    with options.refused("--vary"):
        unit = unit_of_place(model, place)
        numbers = tuple(to_si(value, unit) for value in texts)
    return DeckVariation(place, texts, numbers)


def _velocities(model: "Model", texts: Sequence[str]) -> dict[str, float]:
    """Return the initial velocity of masses [m/s].

    Raises
    ------
    typer.BadParameter
        If one is not written as MASS=VELOCITY.
    """
    from shakerproc.model_files.exchanged import check_places
    from shakerproc.units import to_si

    values: dict[str, float] = {}
    for text in texts:
        place, _, value = text.partition("=")
        with options.refused("--velocity"):
            values[place.strip()] = to_si(value.strip(), "m/s")
    check_places(model, list(values))
    return values


def _length(text: str | None) -> float | None:
    """Return a length [m].

    Raises
    ------
    typer.BadParameter
        If it is none above 0.
    """
    from shakerproc.units import to_si

    if text is None:
        return None
    with options.refused("--reach"):
        value = to_si(text, "m")
    if not value > 0.0:
        raise typer.BadParameter(f"must be above 0 m, not {text}", param_hint="--reach")
    return value
