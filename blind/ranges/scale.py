"""What a hidden effect is drawn for, and what it is."""

from dataclasses import dataclass
from typing import Any

Parameters = dict[str, float]


@dataclass(frozen=True)
class Scale:
    """The linear joint and its motion; the last two are V and the rms of the spring force."""

    mass: float
    stiffness: float
    omega: float
    displacement: float
    velocity: float
    spring_force: float


@dataclass(frozen=True)
class Hidden:
    """One hidden effect: what it is called and what the truth integrates for it.

    `parts` are (code, parameters, thresholds); `attached` is (mass, stiffness, damping);
    `start` is the displacement of the joint at rest [m]. `kind` is what the program calls it,
    where that is not the name of its class. `known` are effects that the user's model holds
    already, as (kind, parameters with units). The motion must reach both `wells`, at +-start,
    if so asked.
    """

    parameters: Parameters
    parts: tuple[tuple[int, tuple[float, ...], tuple[float, ...]], ...] = ()
    attached: tuple[float, float, float] | None = None
    main: str = ""
    start: float = 0.0
    kind: str = ""
    known: tuple[tuple[str, dict[str, str]], ...] = ()
    wells: bool = False

    def as_truth(self, name: str, between: list[str]) -> dict[str, Any]:
        """Return what the truth says of it, by the name of its class and its two places."""
        return {
            "kind": self.kind or name, "between": between,
            "parameters": self.parameters, "main": self.main,
        }  # fmt: skip
