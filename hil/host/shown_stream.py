"""Standard output and error of a command: the one way out of text to a terminal.

Names, answers, errors and arguments are written from everywhere, and some of them are anybody's. So what is
written is made harmless here. Colours and the control of a terminal are written past it, to ``own``, by who
has made the rest harmless.
"""

import sys
from collections.abc import Iterable
from typing import Any, TextIO

from hil.vocab.shown_text import printable_lines


class ShownStream:
    """Text stream that escapes what is a command to a terminal; all else is the stream's below."""

    def __init__(self, own: TextIO) -> None:
        self.own = own

    def write(self, text: str) -> int:
        if not isinstance(text, str):  # as a text stream does: libraries try what they have
            raise TypeError(f"text is wanted, not {type(text).__name__}")
        self.own.write(printable_lines(text))
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.own, name)


def guard_streams() -> None:
    """Let all that this process writes to its standard streams from now on be harmless."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is not None and not isinstance(stream, ShownStream):
            setattr(sys, name, ShownStream(stream))


def own(stream: TextIO) -> TextIO:
    """Stream below, for text that is harmless already, with colours."""
    return stream.own if isinstance(stream, ShownStream) else stream
