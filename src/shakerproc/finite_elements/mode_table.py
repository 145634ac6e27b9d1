"""The modes of a coupon by every model, each named by its nodal diameters and circles."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, final

from shakerproc.finite_elements.annular_meshes import shell_modes, solid_frequencies
from shakerproc.finite_elements.annular_plate import mindlin_modes, plate_frequency, plate_roots
from shakerproc.finite_elements.coupon import Coupon

MODELS: Final = ("Kirchhoff", "Mindlin", "shell mesh", "solid, all nodes", "solid, faces")
"""Thin plate, plate with shear, 1600 shells; solids held through the thickness or on faces."""


@final
@dataclass(frozen=True, slots=True)
class NamedMode:
    """One mode.

    Attributes
    ----------
    diameters, circles : int
        Nodal diameters and nodal circles, the clamp not counted.
    frequencies : mapping of str to float
        By model, a key of `MODELS` [Hz].
    """

    diameters: int
    circles: int
    frequencies: Mapping[str, float]


def named_modes(coupon: Coupon, count: int = 6) -> tuple[NamedMode, ...]:
    """Return the lowest modes, by rising frequency; a pair with diameters counts once.

    Parameters
    ----------
    coupon : Coupon
        Material and dimensions.
    count : int
        How many.
    """
    found = _lowest(coupon, count)
    columns: dict[str, dict[tuple[int, int], float]] = {model: {} for model in MODELS}
    for n in sorted({n for n, _ in found}):
        circles = 1 + max(s for m, s in found if m == n)
        ratio = coupon.clamped_radius / coupon.outer_radius
        roots = plate_roots(ratio, coupon.material.poissons_ratio, n, circles)
        for s, root in enumerate(roots):
            columns["Kirchhoff"][n, s] = plate_frequency(
                root.lambda_squared, coupon.material, coupon.thickness, coupon.outer_radius
            )
        for model, clamp in (("solid, all nodes", "all nodes"), ("solid, faces", "faces")):
            solid = solid_frequencies(coupon, n, circles, clamp=clamp)  # type: ignore[arg-type]
            columns[model] |= {(n, s): float(f) for s, f in enumerate(solid)}
    columns["Mindlin"] = found
    columns["shell mesh"] = _shells(coupon, count)
    return tuple(
        NamedMode(n, s, {m: columns[m][n, s] for m in MODELS if (n, s) in columns[m]})
        for n, s in found
    )


def _lowest(coupon: Coupon, count: int) -> dict[tuple[int, int], float]:
    """Return the lowest modes of the Mindlin plate, of as many diameters as it takes."""
    modes: dict[tuple[int, int], float] = {}
    n = 0
    while True:
        found = mindlin_modes(coupon, n, count).frequencies
        modes |= {(n, s): float(f) for s, f in enumerate(found)}
        lowest = sorted(modes.items(), key=lambda item: item[1])[:count]
        if n > 1 and found[0] > lowest[-1][1]:
            return dict(lowest)
        n += 1


def _shells(coupon: Coupon, count: int) -> dict[tuple[int, int], float]:
    modes = shell_modes(coupon, 2 * count + 2)
    named: dict[tuple[int, int], float] = {}
    for n, s, frequency in zip(modes.diameters, modes.circles, modes.frequencies, strict=True):
        named.setdefault((int(n), int(s)), float(frequency))
    return named
