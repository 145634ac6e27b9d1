"""Names of quantities and columns that were other ones: taken for one version, with a note."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

FORMER: Final[Mapping[str, str]] = MappingProxyType({
    "omega_e": "peak_frequency",
    "omega_e_hz": "peak_frequency_hz",
    "omega_e_over_omega_n": "peak_over_natural_frequency",
})
"""Present name by the former one; omega is [rad/s], and these are frequencies."""


def present_name(name: str) -> str:
    """Return the present name of a quantity or column."""
    return FORMER.get(name, name)


def former_note(name: str, where: str) -> str:
    """Return the note on a former name that somebody used; empty for a present one."""
    if name not in FORMER:
        return ""
    return (
        f"{where}: {name} is called {FORMER[name]} now; the former name is taken in this "
        "version and not in the next"
    )
