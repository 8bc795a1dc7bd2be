"""Server's side of RFC 2217 (Telnet Com Port Control Option) for one client. Pure: bytes in, bytes out.

Sources: RFC 854 (Telnet), RFC 856 (binary), RFC 857 (echo), RFC 858 (suppress go ahead), RFC 2217. A client's
setting is answered with the value in force then: the baud as asked; data bits, parity and stop bits always 8,
none, 1.

A client is offered what lets a person's `telnet` send each key at once, as it is, and show no key twice: the
board echoes, or does not.
"""

from collections import Counter
from enum import Enum, auto

IAC, DONT, DO, WONT, WILL, SB, SE = 255, 254, 253, 252, 251, 250, 240
BINARY, ECHO, SUPPRESS_GO_AHEAD, COM_PORT = 0, 1, 3, 44
_AGREED = (BINARY, ECHO, SUPPRESS_GO_AHEAD, COM_PORT)
_OFFERED = ((WILL, ECHO), (WILL, SUPPRESS_GO_AHEAD), (WILL, BINARY), (DO, BINARY))
"""Options offered to each client; without BINARY the Enter key of most sends a 0, too (RFC 854, page 11)."""
_MOST_AGREED = 8
"""Maximum number of times that one option is agreed to, so that no client's answers go round forever."""
(SIGNATURE, SET_BAUD, SET_DATA_SIZE, SET_PARITY, SET_STOP_SIZE, SET_CONTROL) = range(6)
NOTIFY_MODEM_STATE, SET_LINE_MASK, SET_MODEM_MASK, PURGE = 7, 10, 11, 12
FROM_SERVER = 100
"""Offset of the numbers of a server's answers."""
MODEM_LINES = 0x10 | 0x20 | 0x80
"""Modem lines that are on, CTS, DSR and carrier: a board is there and ready."""
_SUB_MAX = 64
"""Maximum length of a request."""
_FIXED = {SET_DATA_SIZE: 8, SET_PARITY: 1, SET_STOP_SIZE: 1}
_BREAK_ON, _BREAK_OFF = 5, 6
_DTR_ON, _DTR_OFF, _RTS_ON, _RTS_OFF = 8, 9, 11, 12
_REQUESTS = {0: 1, 4: _BREAK_OFF, 13: 14}
"""Answers to questions about flow control (none) and break."""
_BAUD_BYTES = 4
_MAX_BAUD = 4_000_000


class _State(Enum):
    DATA = auto()
    COMMAND = auto()
    OPTION = auto()
    SUB = auto()
    SUB_COMMAND = auto()


class Telnet:
    """State of one client. ``baud`` is what it asked for, None before it has."""

    def __init__(self, signature: str) -> None:
        self.baud: int | None = None
        self.dtr = self.rts = True
        self.rises = 0
        """Number of times that the client has switched DTR on."""
        self._signature = signature.encode()
        self._state = _State.DATA
        self._verb = 0
        self._sub = bytearray()
        self._said: dict[tuple[bool, int], bool] = {}
        self._agreed: Counter[tuple[bool, int]] = Counter()
        self._offered = {(verb == WILL, option) for verb, option in _OFFERED}

    @property
    def hello(self) -> bytes:
        return b"".join(bytes((IAC, verb, option)) for verb, option in _OFFERED)

    def decode(self, data: bytes) -> tuple[bytes, bytes]:
        """Decode bytes of the line, and what to answer. A break is a 0, as a UART reads it."""
        line, reply = bytearray(), bytearray()
        for byte in data:
            match self._state:
                case _State.DATA:
                    if byte == IAC:
                        self._state = _State.COMMAND
                    else:
                        line.append(byte)
                case _State.COMMAND:
                    self._command(byte, line)
                case _State.OPTION:
                    reply += self._negotiate(self._verb, byte)
                    self._state = _State.DATA
                case _State.SUB:
                    if byte == IAC:
                        self._state = _State.SUB_COMMAND
                    elif len(self._sub) < _SUB_MAX:
                        self._sub.append(byte)
                case _State.SUB_COMMAND:
                    self._state = _State.SUB
                    if byte == IAC and len(self._sub) < _SUB_MAX:
                        self._sub.append(byte)
                    elif byte == SE:
                        self._state = _State.DATA
                        reply += self._requested(bytes(self._sub), line)
        return bytes(line), bytes(reply)

    def encode(self, data: bytes) -> bytes:
        return data.replace(b"\xff", b"\xff\xff")

    def _command(self, byte: int, line: bytearray) -> None:
        self._state = _State.DATA
        if byte == IAC:
            line.append(IAC)
        elif byte in (DO, DONT, WILL, WONT):
            self._verb = byte
            self._state = _State.OPTION
        elif byte == SB:
            self._sub.clear()
            self._state = _State.SUB

    def _negotiate(self, verb: int, option: int) -> bytes:
        """Accept known options and refuse the rest; answer each once, so that answers do not loop. What is
        said to an offer is an answer itself."""
        is_ours = verb in (DO, DONT)  # it is about what we do
        key = (is_ours, option)
        agrees = option in _AGREED and verb in (DO, WILL) and self._agreed[key] < _MOST_AGREED
        is_known, self._said[key] = self._said.get(key) == agrees, agrees
        if key in self._offered or is_known:
            self._offered.discard(key)
            return b""
        self._agreed[key] += agrees
        answer = bytes((IAC, (WILL if agrees else WONT) if is_ours else (DO if agrees else DONT), option))
        if key == (True, COM_PORT) and agrees:
            answer += self._sub_answer(NOTIFY_MODEM_STATE, bytes((MODEM_LINES,)))
        return answer

    def _requested(self, sub: bytes, line: bytearray) -> bytes:
        if len(sub) < 2 or sub[0] != COM_PORT:
            return b""
        what, value = sub[1], sub[2:]
        if what == SIGNATURE:
            return b"" if value else self._sub_answer(SIGNATURE, self._signature)
        if what == SET_BAUD and len(value) == _BAUD_BYTES:
            asked = int.from_bytes(value, "big")
            if 0 < asked <= _MAX_BAUD:
                self.baud = asked
            return self._sub_answer(SET_BAUD, (self.baud or 0).to_bytes(_BAUD_BYTES, "big"))
        if what in _FIXED and len(value) == 1:
            return self._sub_answer(what, bytes((_FIXED[what],)))
        if what == SET_CONTROL and len(value) == 1:
            return self._sub_answer(SET_CONTROL, bytes((self._control(value[0], line),)))
        if what in (SET_LINE_MASK, SET_MODEM_MASK, PURGE) and len(value) == 1:
            return self._sub_answer(what, value)
        return b""

    def _control(self, value: int, line: bytearray) -> int:
        if value == _BREAK_ON:
            line.append(0)
        elif value in (_DTR_ON, _DTR_OFF):
            self.rises += value == _DTR_ON and not self.dtr
            self.dtr = value == _DTR_ON
        elif value in (_RTS_ON, _RTS_OFF):
            self.rts = value == _RTS_ON
        elif value == 7:
            return _DTR_ON if self.dtr else _DTR_OFF
        elif value == 10:
            return _RTS_ON if self.rts else _RTS_OFF
        elif value not in (_BREAK_OFF, 1, 14):
            return _REQUESTS.get(value, 1)  # flow control stays off
        return value

    @staticmethod
    def _sub_answer(what: int, value: bytes) -> bytes:
        body = bytes((COM_PORT, what + FROM_SERVER)) + value
        return bytes((IAC, SB)) + body.replace(b"\xff", b"\xff\xff") + bytes((IAC, SE))
