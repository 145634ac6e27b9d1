"""A figure of the page with its caption."""

from dataclasses import dataclass

from markupsafe import Markup


@dataclass(frozen=True, slots=True)
class Drawing:
    """A figure with its caption.

    Attributes
    ----------
    title, caption : str
        What it is, and what to look for.
    drawing : Markup
        The figure.
    kind : str
        Of the curves of a run, so that those of several can be overlaid.
    broad : bool
        Whether it takes the whole width.
    paper : bool
        Whether it is printed with the page.
    """

    title: str
    caption: str
    drawing: Markup
    kind: str = ""
    broad: bool = False
    paper: bool = True
