"""``shakerproc coupon``."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from shakerproc.cli import options, output
from shakerproc.numerals import numeral

if TYPE_CHECKING:
    from shakerproc.finite_elements.annular_meshes import NamedMode
    from shakerproc.finite_elements.coupon import Coupon
    from shakerproc.finite_elements.hole_stiffness import Axis, LoadedHole
    from shakerproc.model_files.coupon_files import CouponFile, StiffnessSection


SCHEMA = "shakerproc-modes/1"
COLUMN_OF_CLAMP = {
    "shell nodes": "shell mesh",
    "all nodes": "solid, all nodes",
    "faces": "solid, faces",
}
"""Which model of a plate the clamp of a coupon file belongs to."""


@dataclass(frozen=True, slots=True)
class Static:
    """The hole along one axis: under the law that was chosen, under all, on three meshes."""

    axis: str
    chosen: "LoadedHole"
    published: float | None
    published_frequency: float | None
    spread: "tuple[LoadedHole, ...]"
    convergence: dict[int, float]


def axes_of(described: "CouponFile") -> "tuple[Axis, ...]":
    """Return the axes of the hole: one where it is round."""
    hole = described.coupon.hole
    return ("length",) if hole.length == hole.width else ("length", "width")


def published_of(described: "CouponFile") -> dict[tuple[int, int], float]:
    """Return the published frequencies by diameters and circles [Hz]."""
    if described.modes is None:
        return {}
    return {(m.diameters, m.circles): m.frequency for m in described.modes.frequencies}


def _deviation(value: float, published: float | None) -> float | None:
    return None if published is None else 100.0 * (value / published - 1.0)


def document_of(
    described: "CouponFile",
    modes: "tuple[NamedMode, ...]",
    stated: "tuple[NamedMode, ...]",
    holes: list[Static],
    plays: list[tuple[float, float]],
) -> dict[str, Any]:
    """Return the JSON document."""
    import hashlib

    from shakerproc import __version__
    from shakerproc.model_files.coupon_files import modal_equivalent

    return {
        "schema": SCHEMA,
        "version": __version__,
        "coupon": described.path.name,
        "coupon_sha256": hashlib.sha256(described.path.read_bytes()).hexdigest(),
        "title": described.title,
        "material": described.coupon.material,
        "mass_kg": described.coupon.mass,
        "clamp": {
            "held": described.clamp,
            "radius_m": described.coupon.clamped_radius,
            "inferred": described.inferred,
            "stated_radius_m": described.stated_radius,
        },
        "modes": _rows(described, modes),
        "modes_at_stated_radius": _rows(described, stated),
        "shell_mesh_convergence": _shell_convergence(described.coupon),
        "modal_equivalent": modal_equivalent(described.coupon, 3),
        "stiffness": [_hole_document(described.stiffness, hole) for hole in holes],
        "play": [{"temperature_c": t, "play_m": play} for t, play in plays],
    }


def _rows(described: "CouponFile", modes: "tuple[NamedMode, ...]") -> list[dict[str, Any]]:
    published = published_of(described)
    return [
        {
            "diameters": mode.diameters,
            "circles": mode.circles,
            "published_hz": published.get((mode.diameters, mode.circles)),
            "frequency_hz": mode.frequencies,
            "deviation_percent": {
                model: _deviation(f, published.get((mode.diameters, mode.circles)))
                for model, f in mode.frequencies.items()
            },
        }
        for mode in modes
    ]


def _shell_convergence(coupon: "Coupon") -> list[dict[str, Any]]:
    from shakerproc.finite_elements.annular_meshes import shell_modes

    rows = []
    for radial in (10, 20, 30):
        modes = shell_modes(coupon, 6, radial=radial, around=4 * radial)
        named = {
            (int(n), int(s)): float(f)
            for n, s, f in zip(modes.diameters, modes.circles, modes.frequencies, strict=True)
        }
        rows.append({
            "elements": 4 * radial**2,
            "frequency_hz": [named.get((n, 0)) for n in range(3)],
        })
    return rows


def _hole_document(said: "StiffnessSection", hole: Static) -> dict[str, Any]:
    return {
        "axis": hole.axis,
        "law": said.law,
        "half_angle_rad": said.half_angle,
        "plane": said.plane,
        "stiffness_n_per_m": hole.chosen.stiffness,
        "frequency_hz": hole.chosen.frequency,
        "published_n_per_m": hole.published,
        "published_frequency_hz": hole.published_frequency,
        "deviation_percent": _deviation(hole.chosen.stiffness, hole.published),
        "spread": hole.spread,
        "mesh_convergence": [
            {"elements": n, "stiffness_n_per_m": k} for n, k in hole.convergence.items()
        ],
    }


def print_modes(
    described: "CouponFile", modes: "tuple[NamedMode, ...]", stated: "tuple[NamedMode, ...]"
) -> None:
    """Print the table of modes, and the one at the stated radius."""
    coupon = described.coupon
    output.data(
        f"{described.title}: {coupon.material.name}, outer radius "
        f"{1e3 * coupon.outer_radius:g} mm, {1e3 * coupon.thickness:g} mm thick, "
        f"{numeral(1e3 * coupon.mass, 4)} g"
    )
    radius = f"{1e3 * coupon.clamped_radius:.2f} mm"
    how = "inferred: it was fitted to the published frequencies" if described.inferred else ""
    output.data(f"clamped radius {radius}{f' ({how})' if how else ''}")
    source = f", beside {described.modes.source}" if described.modes else ""
    _print_table(f"natural frequencies [Hz] at {radius}{source}", described, modes)
    if stated:
        there = f"{1e3 * (described.stated_radius or 0.0):.2f} mm"
        title = f"natural frequencies [Hz] at {there}, which the documents state"
        _print_table(title, described, stated)


def _print_table(title: str, described: "CouponFile", modes: "tuple[NamedMode, ...]") -> None:
    from shakerproc.finite_elements.annular_meshes import MODELS

    published, clamp_column = published_of(described), COLUMN_OF_CLAMP[described.clamp]
    rows = []
    for mode in modes:
        known = published.get((mode.diameters, mode.circles))
        off = _deviation(mode.frequencies.get(clamp_column, float("nan")), known)
        cells = [
            mode.diameters,
            mode.circles,
            *(_hertz(mode.frequencies.get(m)) for m in MODELS),
            _hertz(known),
            f"{off:+.2f}" if off is not None else None,
        ]
        rows.append(cells)
    columns = ("diameters", "circles", *MODELS, "published", f"{clamp_column}: off by %")
    output.print_table(columns, rows, title=title)


def _hertz(value: float | None) -> str | None:
    return None if value is None else f"{value:.1f}"


def print_shells(convergence: list[dict[str, Any]], modes: "tuple[NamedMode, ...]") -> None:
    """Print the frequencies of three shell meshes."""
    exact = {(m.diameters, m.circles): m.frequencies["Mindlin"] for m in modes}
    rows: list[list[object]] = [
        [row["elements"], *(_hertz(f) for f in row["frequency_hz"])] for row in convergence
    ]
    rows.append(["no mesh", *(_hertz(exact.get((n, 0))) for n in range(3))])
    columns = ("shells", "0 diameters", "1 diameter", "2 diameters")
    output.print_table(columns, rows, title="shell meshes [Hz]")


def print_static(described: "CouponFile", hole: Static) -> None:
    """Print the stiffness of the hole under every load law."""
    import math

    along = f" along its {hole.axis}" if len(axes_of(described)) > 1 else ""
    thick = 1e3 * described.static.thickness
    mass = 1e3 * described.static.mass
    title = f"stiffness of the hole{along}, {thick:g} mm thick, {numeral(mass, 4)} g, rim fixed"
    rows = [
        (
            one.law,
            f"{math.degrees(one.half_angle):.0f}",
            one.plane,
            numeral(one.stiffness / 1e3, 4),
            f"{one.frequency:.0f}",
            _signed(_deviation(one.stiffness, hole.published)),
        )
        for one in (*hole.spread, hole.chosen)
    ]
    columns = ("load law", "half-angle deg", "plane", "k N/mm", "f_n Hz", "off by %")
    output.print_table(columns, rows, title=title)
    values = [one.stiffness for one in hole.spread]
    text = f"chosen is the last line; the laws spread from {numeral(min(values) / 1e3, 4)} to "
    text += (
        f"{numeral(max(values) / 1e3, 4)} N/mm ({100 * (max(values) / min(values) - 1):.0f} %)"
    )
    if hole.published is not None:
        frequency = hole.published_frequency
        text += f"; published: {numeral(hole.published / 1e3, 4)} N/mm"
        text += f", {frequency:.0f} Hz" if frequency is not None else ""
        text += f" ({described.stiffness.source})" if described.stiffness.source else ""
    output.data(text)
    meshes = ", ".join(f"{k / 1e3:.6g} on {n}" for n, k in hole.convergence.items())
    output.data(f"on three meshes: {meshes} elements [N/mm]")


def _signed(value: float | None) -> str | None:
    return None if value is None else f"{value:+.1f}"


def print_plays(plays: list[tuple[float, float]]) -> None:
    """Print the play of the joint over temperature."""
    if plays:
        rows = [(t, f"{1e3 * play:.4f}", f"{5e2 * play:.4f}") for t, play in plays]
        columns = ("temperature degC", "play mm", "to each side mm")
        output.print_table(columns, rows, title="play of the joint")


def coupon(
    coupon: Annotated[
        Path,
        typer.Argument(metavar="COUPON", help="Coupon (YAML).", exists=True, dir_okay=False),
    ],
    count: Annotated[
        int, typer.Option(help="How many modes; a pair counts once.", min=1, max=30)
    ] = 6,
    law: Annotated[
        Literal["traction", "pressure", "cosine bearing"] | None,
        typer.Option(
            help="Distribution of the load on the hole.", show_default="the coupon file's"
        ),
    ] = None,
    half_angle_deg: Annotated[
        float | None,
        typer.Option(
            help="Half of the loaded arc [deg].", min=1.0, max=90.0, show_default="the file's"
        ),
    ] = None,
    plane: Annotated[
        Literal["strain", "stress"] | None,
        typer.Option(help="Faces held (strain) or free (stress).", show_default="the file's"),
    ] = None,
    static: Annotated[bool, typer.Option(help="Find the stiffness of the hole.")] = True,
    temperature_c: Annotated[
        list[float] | None,
        typer.Option(
            metavar="DEGREES", help="Clearance at this temperature [degC]; may be repeated."
        ),
    ] = None,
    model: Annotated[
        Path | None,
        typer.Option(metavar="NEW.yaml", help="Write a model with these frequencies."),
    ] = None,
    in_plane: Annotated[
        bool, typer.Option("--in-plane", help="The model moves on the hole, not as a plate.")
    ] = False,
    model_modes: Annotated[
        int, typer.Option(help="Modes without nodal diameters in the model.", min=1, max=6)
    ] = 1,
    damping_ratio: Annotated[
        float | None,
        typer.Option(help="Of the model [-].", min=0.0, max=1.0, show_default="the file's"),
    ] = None,
    figures: options.FiguresOption = True,
    out: output.OutOption = None,
    json: output.JsonOption = None,
) -> None:
    """Find modes and static stiffness of a coupon's hole.

    Natural frequencies and mode shapes stand beside published values, where the coupon file has
    them. The clamped radius is often not known: the table says how far the frequencies depend
    on it.
    """
    from shakerproc.finite_elements.annular_meshes import named_modes
    from shakerproc.model_files.coupon_files import read_coupon

    described = _with_options(read_coupon(coupon), law, half_angle_deg, plane)
    if model is not None:
        _check_model(model, coupon, described, damping_ratio)
    modes = named_modes(described.coupon, count)
    stated = _at_stated_radius(described, count)
    holes = [_static(described, axis) for axis in axes_of(described)] if static else []
    plays = _plays(described, temperature_c or [])
    document = document_of(described, modes, stated, holes, plays)
    output.write_json(document, json)
    print_modes(described, modes, stated)
    print_shells(document["shell_mesh_convergence"], modes)
    for hole in holes:
        print_static(described, hole)
    print_plays(plays)
    folder = output.out_folder(out, f"{coupon.stem}_modes")
    with output.results(folder, "modes"):
        _write(folder, described, modes, holes, document, figures=figures)
    if model is not None:
        _write_model(model, described, holes, damping_ratio, model_modes, in_plane=in_plane)
    output.message(f"results in {folder}")


def _with_options(
    described: "CouponFile", law: str | None, half_angle_deg: float | None, plane: str | None
) -> "CouponFile":
    import math

    changed: dict[str, Any] = {"law": law, "plane": plane}
    if half_angle_deg is not None:
        changed["half_angle"] = math.radians(half_angle_deg)
    kept = {name: value for name, value in changed.items() if value is not None}
    return replace(described, stiffness=described.stiffness.model_copy(update=kept))


def _check_model(
    model: Path, coupon: Path, described: "CouponFile", damping_ratio: float | None
) -> None:
    """Pass a model that can be written.

    Raises
    ------
    typer.BadParameter
        If it would be the coupon file, or has no damping.
    """
    if model.exists() and model.samefile(coupon):
        raise typer.BadParameter("this is the coupon file itself", param_hint="--model")
    if damping_ratio is None and described.damping_ratio is None:
        raise typer.BadParameter(
            f"{coupon.name} has no damping_ratio; give one, such as 0.01",
            param_hint="--damping-ratio",
        )


def _at_stated_radius(described: "CouponFile", count: int) -> "tuple[NamedMode, ...]":
    """Return the modes at the clamped radius that the documents state, if they state one."""
    from shakerproc.finite_elements.annular_meshes import named_modes

    if described.stated_radius is None:
        return ()
    return named_modes(replace(described.coupon, clamped_radius=described.stated_radius), count)


def _static(described: "CouponFile", axis: "Axis") -> Static:
    from shakerproc.finite_elements.hole_stiffness import (
        MESHES,
        loaded_hole,
        loaded_holes,
        mesh_convergence,
    )

    said, coupon = described.stiffness, described.static
    convergence = mesh_convergence(coupon, axis, said.law, said.half_angle, said.plane)
    published = next((p for p in said.published if p.axis == axis), None)
    return Static(
        axis=axis,
        chosen=loaded_hole(
            coupon, axis, said.law, said.half_angle, said.plane, refinement=MESHES[-2]
        ),
        published=published.stiffness if published else None,
        published_frequency=published.frequency if published else None,
        spread=loaded_holes(coupon, axis),
        convergence=dict(convergence),
    )


def _plays(described: "CouponFile", temperatures: list[float]) -> list[tuple[float, float]]:
    """Return (temperature [degC], play [m]).

    Raises
    ------
    typer.BadParameter
        If the coupon file has no joint.
    """
    from shakerproc.finite_elements.coupon import clearances_at

    if not temperatures:
        return []
    if described.fit is None:
        raise typer.BadParameter(
            f"{described.path.name} has no joint; write what sits in the hole as joint",
            param_hint="--temperature-c",
        )
    reference = described.reference - 273.15
    return [(t, clearances_at(described.fit, t - reference).play) for t in temperatures]


def _write(
    folder: Path,
    described: "CouponFile",
    modes: "tuple[NamedMode, ...]",
    holes: list[Static],
    document: dict[str, Any],
    *,
    figures: bool,
) -> None:
    from shakerproc import files
    from shakerproc.finite_elements.annular_meshes import MODELS

    published = published_of(described)
    columns: dict[str, list[object]] = {
        "diameters": [m.diameters for m in modes],
        "circles": [m.circles for m in modes],
        "published_hz": [published.get((m.diameters, m.circles)) for m in modes],
    }
    for model in MODELS:
        name = model.lower().replace(", ", "_").replace(" ", "_")
        columns[f"{name}_hz"] = [m.frequencies.get(model) for m in modes]
    files.write_csv(folder / "modes.csv", columns)
    if holes:
        every = [(hole, one) for hole in holes for one in (*hole.spread, hole.chosen)]
        files.write_csv(
            folder / "stiffness.csv",
            {
                "axis": [hole.axis for hole, _ in every],
                "law": [one.law for _, one in every],
                "half_angle_rad": [one.half_angle for _, one in every],
                "plane": [one.plane for _, one in every],
                "stiffness_n_per_m": [one.stiffness for _, one in every],
                "frequency_hz": [one.frequency for _, one in every],
                "published_n_per_m": [hole.published for hole, _ in every],
            },
        )
    files.write_json(folder / "modes.json", document)
    if figures:
        _draw(folder, described, modes)


def _draw(folder: Path, described: "CouponFile", modes: "tuple[NamedMode, ...]") -> None:
    import numpy as np

    from shakerproc.finite_elements.annular_plate import mindlin_modes
    from shakerproc.report.figures import style
    from shakerproc.report.figures.to_png import save
    from shakerproc.report.models.coupon import frequencies_over_clamp, mode_shapes

    coupon, stated = described.coupon, described.stated_radius
    ends = [coupon.clamped_radius, stated or coupon.clamped_radius]
    radii = np.linspace(0.9 * min(ends), min(1.1 * max(ends), 0.9 * coupon.outer_radius), 5)
    names = [(mode.diameters, mode.circles) for mode in modes[:3]]
    over_clamp = {
        (n, s): [
            float(
                mindlin_modes(replace(coupon, clamped_radius=float(b)), n, s + 1).frequencies[s]
            )
            for b in radii
        ]
        for n, s in names
    }
    with style.look():
        shapes = mode_shapes(coupon, modes, described.title)
        save(shapes, folder / "mode_shapes.png")
        clamp = frequencies_over_clamp(
            [float(b) for b in radii],
            over_clamp,
            (coupon.clamped_radius, stated),
            published_of(described),
            f"{described.title}: Mindlin plate, dots are published",
        )
        save(clamp, folder / "clamped_radius.png")


def _write_model(
    model: Path,
    described: "CouponFile",
    holes: list[Static],
    damping_ratio: float | None,
    count: int,
    *,
    in_plane: bool,
) -> None:
    from shakerproc.model_files import write_model
    from shakerproc.model_files.coupon_files import in_plane_model, out_of_plane_model

    ratio = damping_ratio if damping_ratio is not None else described.damping_ratio
    assert ratio is not None  # noqa: S101 - _check_model has seen to it
    if in_plane:
        hole = holes[0] if holes else _static(described, "length")
        made, heading = in_plane_model(
            described.static, described.title, ratio, hole.chosen.frequency, hole.chosen.law
        )
    else:
        made, heading = out_of_plane_model(described.coupon, described.title, ratio, count)
    write_model(
        made, model, heading=f"From {described.path.name} by shakerproc coupon.\n{heading}"
    )
    output.message(f"{model}: {'in plane' if in_plane else 'out of plane'}, see its comments")
