"""Items that the reader of a file has left out: counted, with the place of the first of each kind."""

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
