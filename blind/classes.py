"""Names of the classes of campaigns, and the groups of them that a score asks for.

`[FORM:]NAME[:DETAIL...][@NUISANCES]`: NAME is `none`, `unexercised`, an effect, a fault,
`outside` (or `outside:KIND`) or `pair` (or `pair:A+B`). FORM is `chain` or `chain3` (2 or 3
masses in a row, the effect in one of the joints), `force` (the mass is driven, not the base),
or one of the brief campaigns `decay`, `short` and `quake` (`blind.brief`).
Details of the dry-friction laws are a regime and a drive: `coulomb_friction:sticking:sweep`.
NUISANCES are `all` or names with `+` between: `gap@second_mode+skew`. A count may follow for a
score, `none*50`. The same seed draws the same campaign with and without nuisances.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from blind import nuisances, ranges

FORMS = {"": 1, "force": 1, "chain": 2, "chain3": 3}
"""Number of masses of each form."""
BRIEF = ("decay", "short", "quake")
"""Forms of `blind.brief`, of one to three tests."""
REGIMES = ("sliding", "sticking", "locked")
DRIVES = {"random": "random", "sweep": "sine sweep"}
PLAIN = ("none", "unexercised", "outside", "pair")


@dataclass(frozen=True)
class CampaignClass:
    """A class of campaigns, taken apart; `base` is its name without the nuisances."""

    base: str
    form: str
    name: str
    chosen: str
    regime: str
    drive: str
    nuisances: tuple[str, ...]


def parse(text: str) -> CampaignClass:
    """Return what a class name asks for.

    Raises
    ------
    ValueError
        If a part of the name is unknown.
    """
    base, _, tail = text.partition("@")
    parts = base.split(":")
    form = parts.pop(0) if len(parts) > 1 and parts[0] in {*FORMS, *BRIEF} else ""
    name, details = parts[0], parts[1:]
    known = {*ranges.EFFECTS, *ranges.FAULTS, *ranges.BENCH, *PLAIN}
    if name not in known:
        raise ValueError(f"no class {text!r}; there are {', '.join(standard())}")
    chosen, regime, drive = "", "", ""
    for detail in details:
        if name in {"outside", "pair"}:
            chosen = detail
        elif name in ranges.FRICTION and detail in REGIMES:
            regime = detail
        elif detail in DRIVES:
            drive = DRIVES[detail]
        else:
            raise ValueError(f"class {text!r}: {detail!r} is no detail of {name}")
    return CampaignClass(base, form, name, chosen, regime, drive, nuisances.chosen(tail))


def standard() -> tuple[str, ...]:
    """Return the classes of the standard score."""
    return (*ranges.EFFECTS, "none", "unexercised", *ranges.FAULTS, "outside", "pair")


def friction() -> tuple[str, ...]:
    """Return every dry-friction law in every regime with every drive."""
    return tuple(f"{law}:{r}:{d}" for law in ranges.FRICTION for r in REGIMES for d in DRIVES)


GROUPS = {
    "standard": standard(),
    "effects": tuple(ranges.EFFECTS),
    "faults": ranges.FAULTS,
    "others": PLAIN,
    "friction": friction(),
    "outsides": tuple(f"outside:{kind}" for kind in ranges.OUTSIDE),
    "pairs": tuple(f"pair:{a}+{b}" for a, b in ranges.PAIRS),
    "all_nuisances": tuple(f"{kind}@all" for kind in ranges.EFFECTS),
    "each_nuisance": tuple(
        f"{kind}@{name}"
        for name in nuisances.NUISANCES
        for kind in ("none", "gap", "cubic_stiffness", "coulomb_friction", "bouc_wen")
    ),
    "chains": (
        "chain:gap",
        "chain3:gap",
        "chain:cubic_stiffness",
        "force:gap",
        "force:cubic_stiffness",
    ),
    "decays": tuple(
        f"decay:{name}"
        for name in (
            "none",
            "coulomb_friction",
            "cubic_stiffness",
            "quadratic_damping",
            "pendulum",
            "gap",
            "iwan",
            "pair:pendulum+coulomb_friction",
            "pair:cubic_stiffness+quadratic_damping",
            "pair:quadratic_damping+coulomb_friction",
        )
    ),
    "shorts": tuple(
        f"short:{name}"
        for name in (
            "none",
            "coulomb_friction",
            "stribeck_friction",
            "quadratic_damping",
            "cubic_stiffness",
            "gap",
            "stop",
            "jenkins",
            "pair:cubic_stiffness+coulomb_friction",
        )
    ),
    "quakes": tuple(
        f"quake:{name}"
        for name in (
            "none",
            "coulomb_friction",
            "cubic_stiffness",
            "bouc_wen",
            "general_bouc_wen",
            "jenkins",
            "quadratic_damping",
            "iwan",
        )
    ),
}
FROZEN = (
    "effects*8,all_nuisances*4,each_nuisance*1,friction*16,none*50,unexercised*50,"
    "faults*8,outsides*4,pairs*4,chains*2"
)
"""What the issue asks of a frozen commit: `make blind`."""


def expand(text: str, each: int) -> Iterator[tuple[str, int]]:
    """Return class names and how often each is drawn, from a list with commas between.

    An entry is a group or a class, with `*COUNT` behind it where it is not to be drawn `each`
    times; `effects@all` is every effect with all nuisances.
    """
    for entry in filter(None, (part.strip() for part in text.split(","))):
        words, _, count = entry.partition("*")
        group, at, tail = words.partition("@")
        for kind in GROUPS.get(group, (group,)):
            parse(kind + at + tail)
            yield kind + at + tail, int(count) if count else each


def tasks(classes: Iterable[tuple[str, int]], seed: int) -> list[tuple[int, str]]:
    """Return (seed, class) of every campaign, all classes once before any comes twice."""
    wanted = list(classes)
    most = max((count for _, count in wanted), default=0)
    return [(seed + i, kind) for i in range(most) for kind, count in wanted if i < count]
