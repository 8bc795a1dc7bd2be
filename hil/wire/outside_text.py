"""Text of files that other programs wrote: the one place that says which bytes are which characters.

A mark at the beginning (U+FEFF) says UTF-8 or UTF-16, and is no character of the text. Without one it is
UTF-8, and where it cannot be that, Windows' Western European (1252), in which older tools write.
"""

_MOST = 6
"""Reasons that are told apart; more would be no line for people."""
_OTHERS = "for other reasons"


class LeftOut:
    """Tally of one reading. What cannot be read is left out and added here; it ends nothing."""

    def __init__(self) -> None:
        self._reasons: dict[str, list[str | int]] = {}
        self._notes: dict[str, None] = {}
        self.total = 0

    def add(self, where: str, why: str, content: str = "") -> None:
        """Count one. ``where``: its place, as in ``line 3``; ``why``: the same words for the same reason;
        ``content``: of the first."""
        self.total += 1
        key = why if why in self._reasons or len(self._reasons) < _MOST else _OTHERS
        first = self._reasons.setdefault(key, [f"{where} {content[:60]!r}" if content else where, 0])
        first[1] = int(first[1]) + 1

    def note(self, text: str) -> None:
        """Note how the rest was taken, where it could be taken otherwise."""
        self._notes.setdefault(text)

    def told(self) -> str:
        """Say it in one line, as in ``2 left out: line 3: no frame; line 9: of CAN FD``; empty: nothing."""
        each = [
            f"{where}: {why}" if count == 1 else f"{where} and {int(count) - 1} more: {why}"
            for why, (where, count) in self._reasons.items()
        ]
        left = [f"{self.total} left out: {'; '.join(each)}"] if each else []
        return "; ".join([*left, *self._notes])


_MARKS = ((b"\xef\xbb\xbf", "utf-8"), (b"\xff\xfe", "utf-16-le"), (b"\xfe\xff", "utf-16-be"))


def text_of(data: bytes) -> str:
    """Decode the content of a file; every content is some text."""
    for mark, encoding in _MARKS:
        if data.startswith(mark):
            return data[len(mark) :].decode(encoding, "replace")
    try:
        return data.decode()
    except UnicodeDecodeError:
        return data.decode("cp1252", "replace")


def lines_of(text: str) -> list[str]:
    """Lines without their ends, which are LF, CR with LF, or CR alone."""
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
