"""Characters of a picture: those that no installed font has are written as their code."""

from functools import cache
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIRST: Final = "DejaVu Sans"
"""Comes with matplotlib: Latin, Greek, Cyrillic, Hebrew, Arabic, signs of mathematics."""

OTHERS: Final = (
    "Noto Sans CJK SC", "Noto Sans CJK JP", "Noto Sans CJK KR", "Source Han Sans SC",
    "WenQuanYi Zen Hei", "WenQuanYi Micro Hei", "Microsoft YaHei", "SimHei", "PingFang SC",
    "Hiragino Sans", "Yu Gothic", "IPAGothic", "Malgun Gothic", "NanumGothic",
    "Noto Sans Devanagari", "Noto Sans Thai", "Arial Unicode MS",
)  # fmt: skip
"""Fonts of common systems for what it lacks, tried in this order."""


@cache
def families() -> tuple[str, ...]:
    """Return the fonts of a picture, of those that are installed."""
    from matplotlib.font_manager import fontManager

    installed = {font.name for font in fontManager.ttflist}
    return (FIRST, *(name for name in OTHERS if name in installed))


def legible(text: str) -> str:
    r"""Return text in which a character that no font has is its code, such as ``\u4e2d``."""
    if text.isascii() and text.replace("\n", "").isprintable():
        return text
    return "".join(c if c == "\n" or _is_drawn(c) else _code(c) for c in text)


def write_legibly(picture: "Figure") -> None:
    """Write every text of a picture so that it can be drawn."""
    from matplotlib.text import Text

    for item in picture.findobj(Text):
        text = item.get_text()
        if (new := legible(text)) != text:
            item.set_text(new)


def _code(character: str) -> str:
    return character.encode("unicode_escape").decode()


@cache
def _is_drawn(character: str) -> bool:
    from matplotlib.font_manager import FontProperties, findfont, get_font

    if not character.isprintable():
        return False
    fonts = (get_font(findfont(FontProperties(family=name))) for name in families())
    return any(font.get_char_index(ord(character)) for font in fonts)
