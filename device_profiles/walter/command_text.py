"""Text of a command: one buffer that is never wiped, and words that are taken out of it in place.

This is why words get lost, and old ones come back: the board's parser writes NUL behind a word, and puts back
what it had no use for.
"""

from device_profiles.walter.float32 import int16_of, long_of, real_of

LINE_BYTES = 128
"""Most characters of a line; further ones are dropped."""
_COMPARED = 8
"""Characters of a name that count."""
_DROPPED = bytes(byte for byte in range(256) if not 0x20 <= byte <= 0x7E)
_NUL, _BLANK, _EQUALS = 0, ord(" "), ord("=")


def is_same_name(word: bytes, name: str) -> bool:
    """Answer whether a word is a name, by its first characters and without regard to case."""
    return word[:_COMPARED].upper() == name[:_COMPARED].upper().encode()


def begins(word: bytes, prefix: str) -> bool:
    """Answer whether a word begins with a prefix, without regard to case."""
    return word[: len(prefix)].upper() == prefix.upper().encode()


class CommandText:
    """Line that is typed, then the words of it. Places are indices; None: nothing is left."""

    def __init__(self) -> None:
        self._buffer = bytearray(2 * LINE_BYTES)  # a NUL stays behind whatever a line has overwritten
        self._length = 0
        self._rest: int | None = None
        self._rest_before: int | None = None
        self.is_checked = False
        """True if commands need a checksum."""
        self.checksum = 0
        """Checksum of the words read so far."""
        self.error = 0
        """Number of the error that the latest check has found."""

    def feed(self, data: bytes) -> None:
        """Take what is typed before the line's end: printable characters, as far as there is room."""
        taken = data.translate(None, _DROPPED)[: LINE_BYTES - self._length]
        if taken:
            end = self._length + len(taken)
            self._buffer[self._length : end] = taken
            self._buffer[end] = _NUL
            self._length = end

    def begin(self) -> bytes | None:
        """Take the command's own word; None: the line is blank."""
        self._rest_before = self._rest
        self.checksum = 0
        place = self._token(0)
        return None if place is None else self._summed(place)

    def clear(self) -> None:
        """Begin a new line; what stood in the buffer stays behind its first character."""
        self._buffer[0] = _NUL
        self._length = 0

    # ---- words ----

    def word(self) -> bytes | None:
        """Take the next word; None: there is none."""
        place = self._next()
        return None if place is None else self._text(place)

    def text(self) -> str | None:
        """Take the next word as text; None: there is none."""
        word = self.word()
        return None if word is None else word.decode("ascii")

    def real(self) -> float | None:
        """Take the next word as a float32; None: there is none."""
        text = self.text()
        return None if text is None else real_of(text)

    def int16(self) -> int | None:
        """Take the next word as an integer of 16 bits; None: there is none."""
        text = self.text()
        return None if text is None else int16_of(text)

    def put_back(self) -> None:
        """Go back to before the latest word. It ends where it was cut: what followed is lost with it."""
        self._rest = self._rest_before

    def named(self, name: str) -> str | None:
        """Take the next word if it is ``name=value``; answers the value. None: it is not, and is put back."""
        place = self._next()
        if place is None:
            return None
        begin = self._skip(place, _EQUALS)
        if begin is None:
            self.put_back()
            return None
        end = self._end(begin, _EQUALS)
        value = None
        if self._buffer[end] != _NUL:
            self._buffer[end] = _NUL
            start = self._skip(end + 1, _BLANK)
            if start is not None:
                stop = self._end(start, _BLANK)
                self._buffer[stop] = _NUL
                value = self._text(start)
        found = self._text(begin)
        if value is not None and is_same_name(found, name):
            return value.decode("ascii")
        self._buffer[place + len(found)] = _EQUALS
        self.put_back()
        return None

    def named_real(self, name: str) -> float | None:
        """Take the next word if it is ``name=number``; None: it is not."""
        value = self.named(name)
        return None if value is None else real_of(value)

    def check(self) -> str | None:
        """Check the checksum behind the arguments, if commands need one. Returns None, or what the board
        says, and ``error`` has the number."""
        if not self.is_checked:
            return None
        self.error = 0
        wanted = self.checksum
        given = self.named("chk")
        if given is None:
            self.error = 1
            return "chksum expected"
        if int16_of(str(long_of(given))) == wanted:
            return None
        self.error = 2
        return f"chk!={wanted})"

    # ---- in the buffer ----

    def _next(self) -> int | None:
        self._rest_before = self._rest
        if self._rest is None:
            return None
        place = self._token(self._rest)
        if place is not None:
            self._summed(place)
        return place

    def _token(self, start: int) -> int | None:
        """Cut a word out; answers where it begins, and leaves where the rest does."""
        begin = self._skip(start, _BLANK)
        if begin is None:
            self._rest = None
            return None
        end = self._end(begin, _BLANK)
        if self._buffer[end] == _NUL:
            self._rest = None
        else:
            self._buffer[end] = _NUL
            self._rest = end + 1
        return begin

    def _skip(self, start: int, byte: int) -> int | None:
        while self._buffer[start] == byte:
            start += 1
        return None if self._buffer[start] == _NUL else start

    def _end(self, start: int, byte: int) -> int:
        while self._buffer[start] not in (byte, _NUL):
            start += 1
        return start

    def _text(self, start: int) -> bytes:
        return bytes(self._buffer[start : self._buffer.index(_NUL, start)])

    def _summed(self, place: int) -> bytes:
        word = self._text(place)
        for byte in word:
            self.checksum = (self.checksum * 33 + byte) & 0xFF
        return word
