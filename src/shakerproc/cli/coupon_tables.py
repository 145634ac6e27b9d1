"""Output of `shakerproc coupon`: the JSON document and the tables."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from shakerproc.cli import output
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
    found: "tuple[NamedMode, ...]",
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
        "modes": _rows(described, found),
        "modes_at_stated_radius": _rows(described, stated),
        "shell_mesh_convergence": _shell_convergence(described.coupon),
        "modal_equivalent": modal_equivalent(described.coupon, 3),
        "stiffness": [_hole_document(described.stiffness, hole) for hole in holes],
        "play": [{"temperature_c": t, "play_m": play} for t, play in plays],
    }


def _rows(described: "CouponFile", found: "tuple[NamedMode, ...]") -> list[dict[str, Any]]:
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
        for mode in found
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
    described: "CouponFile", found: "tuple[NamedMode, ...]", stated: "tuple[NamedMode, ...]"
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
    _print_table(f"natural frequencies [Hz] at {radius}{source}", described, found)
    if stated:
        there = f"{1e3 * (described.stated_radius or 0.0):.2f} mm"
        title = f"natural frequencies [Hz] at {there}, which the documents state"
        _print_table(title, described, stated)


def _print_table(title: str, described: "CouponFile", found: "tuple[NamedMode, ...]") -> None:
    from shakerproc.finite_elements.annular_meshes import MODELS

    published, own = published_of(described), COLUMN_OF_CLAMP[described.clamp]
    rows = []
    for mode in found:
        known = published.get((mode.diameters, mode.circles))
        off = _deviation(mode.frequencies.get(own, float("nan")), known)
        cells = [
            mode.diameters,
            mode.circles,
            *(_hertz(mode.frequencies.get(m)) for m in MODELS),
            _hertz(known),
            f"{off:+.2f}" if off is not None else None,
        ]
        rows.append(cells)
    columns = ("diameters", "circles", *MODELS, "published", f"{own}: off by %")
    output.print_table(columns, rows, title=title)


def _hertz(value: float | None) -> str | None:
    return None if value is None else f"{value:.1f}"


def print_shells(convergence: list[dict[str, Any]], found: "tuple[NamedMode, ...]") -> None:
    """Print the frequencies of three shell meshes."""
    exact = {(m.diameters, m.circles): m.frequencies["Mindlin"] for m in found}
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
