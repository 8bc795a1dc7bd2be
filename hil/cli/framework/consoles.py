"""Consoles of rich: the only ones of the command line. What they show is harmless, their own control is not
escaped."""

import sys
from collections.abc import Iterable
from typing import Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment

from hil.host.shown_stream import own
from hil.vocab.shown_text import printable_lines

_WIDEST = 10_000


class ShownConsole(Console):
    """Console of the standard output, or error, in whose texts nothing is a command to the terminal."""

    def __init__(self, *, stderr: bool = False, **options: Any) -> None:
        super().__init__(file=own(sys.stderr if stderr else sys.stdout), **options)

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        for segment in super().render(renderable, options):
            text = segment.text if segment.control else printable_lines(segment.text)
            yield segment if text == segment.text else Segment(text, segment.style)


def long_lines() -> Console:
    """Console for tables and sentences with names, paths and addresses, which have to be whole to be copied:
    a terminal that is narrower wraps their lines."""
    return ShownConsole(soft_wrap=True, markup=False, width=_WIDEST)
