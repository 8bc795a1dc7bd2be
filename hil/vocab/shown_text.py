"""Text for a terminal that may be anybody's: nothing in it is a command to the terminal.

What a terminal would not show as it is becomes its escape, as in ``\\x1b``: control characters of both sets
(C0 and C1), and marks that are not seen but turn text around or hide it.
"""

import re

_SUSPECT = re.compile(r"\r(?!\n)|[^ -~\n\t\r]")


def printable(text: str) -> str:
    """One line: what is no character to be seen, ends of lines too, is escaped."""
    return text if text.isprintable() else "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def printable_lines(text: str) -> str:
    """The same for several lines: their ends and tabs stay."""
    return _SUSPECT.sub(_escaped, text)


def _escaped(found: re.Match[str]) -> str:
    return found[0] if found[0].isprintable() else ascii(found[0])[1:-1]
