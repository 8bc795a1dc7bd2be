r"""Text as people type it at a board: bytes that are no characters are written with a backslash."""

import re

from hil.vocab.verbs import VerbRefused

_ESCAPES = {"r": "\r", "n": "\n", "t": "\t", "\\": "\\"}


def typed(text: str) -> bytes:
    r"""Bytes of a text: ``\r``, ``\n``, ``\t``, ``\\`` and ``\xHH`` are one byte each.

    Raises:
        VerbRefused: something else follows a backslash, or a character is no byte.
    """

    def one(match: re.Match[str]) -> str:
        code = match[1]
        if code in _ESCAPES:
            return _ESCAPES[code]
        if code.startswith("x") and len(code) == 3:
            return chr(int(code[1:], 16))
        raise VerbRefused(
            "bad_parameter", f"text: \\{code} means nothing; write \\r, \\n, \\t, \\\\ or \\xHH"
        )

    try:
        return re.sub(r"\\(x[0-9A-Fa-f]{2}|.|$)", one, text, flags=re.S).encode("latin-1")
    except UnicodeEncodeError:
        raise VerbRefused("bad_parameter", "text: a character is no byte; write it as \\xHH") from None
