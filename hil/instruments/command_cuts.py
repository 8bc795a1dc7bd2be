"""Cutting of what comes into commands: by line ends, by a number of bytes, or by silence."""

from typing import NamedTuple


class Cuts(NamedTuple):
    """Rules of where a command ends. ``ends``: texts that end one; ``size``: its number of bytes, 0: any;
    ``begins``: text that begins one, what is before it is dropped; ``silence_ns``: time without a byte that
    ends one, 0: none does; ``longest``: characters of a command, what is beyond is lost."""

    ends: tuple[str, ...] = ()
    size: int = 0
    begins: str = ""
    silence_ns: int = 0
    longest: int = 256


class CommandCutter:
    """Collector of one command. Characters stand for bytes."""

    def __init__(self, cuts: Cuts) -> None:
        self._cuts = cuts
        self._ends = tuple(sorted(cuts.ends, key=len, reverse=True))
        self._last = frozenset(end[-1] for end in self._ends)
        self.text = ""
        """Beginning of the command that is under way."""
        self.is_cut = False
        """True if characters of it were lost, because it is too long."""

    def feed(self, byte: str) -> str | None:
        """Take a character; answers the command that it ends, without its line end, or None."""
        cuts = self._cuts
        self.text += byte
        if cuts.begins and len(self.text) <= len(cuts.begins) and not cuts.begins.startswith(self.text):
            while not cuts.begins.startswith(
                self.text
            ):  # its end may be a beginning, of FF FF FF that of FF FF FD
                self.text = self.text[1:]
            return None
        if cuts.size and len(self.text) == cuts.size:
            return self.ended()
        if byte in self._last:
            for end in self._ends:
                if self.text.endswith(end):
                    return self.ended(len(end))
        if len(self.text) > cuts.longest + 2:
            # The last characters stay: they may be the beginning of a line end.
            self.text, self.is_cut = self.text[: cuts.longest] + self.text[cuts.longest + 1 :], True
        return None

    def ended(self, end: int = 0) -> str:
        """Command that has come, without its last ``end`` characters."""
        text = self.text[: len(self.text) - end]
        self.text, self.is_cut = "", self.is_cut or len(text) > self._cuts.longest
        return text
