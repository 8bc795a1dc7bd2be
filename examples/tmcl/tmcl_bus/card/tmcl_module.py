"""A TMCL module: the interface card of an axis, a station of a segment of its own."""

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from hil.sim.firmware_guard import place_of
from hil.sim.flight import flight_of, heard
from hil.vocab.framing import Item
from hil.vocab.segment import HeardCharacter, Segment
from hil.vocab.time import Clock, SimTimeNs
from tmcl_bus.card.interpreter import CommandRefused, Interpreter
from tmcl_bus.card.module_axis import ModuleAxis
from tmcl_bus.card.module_ear import ModuleEar
from tmcl_bus.frames import Reply, Status, asks_for_text, has_right_sum, request_of

_BAUD_CODES = {9600: 0, 14400: 1, 19200: 2, 28800: 3, 38400: 4, 57600: 5, 76800: 6, 115200: 7}
_BAUD, _ADDRESS, _HOST = 65, 66, 76
"""General parameters of bank 0."""


class ModuleSpec(NamedTuple):
    """Specification of a module. ``version``: of hil, as in ``0.2.0``."""

    name: str
    number: int
    host: int
    baud: int
    response_ns: int
    version: str


class TmclModule:
    """Station with a module's address. It acts on a request at the end of its ninth character, and replies
    ``response_ns`` later. Nobody replies to another address.

    Its power is the board's: without it nobody replies, and with each power-up its settings start again.
    """

    faults = None

    def __init__(self, spec: ModuleSpec, axis: ModuleAxis, segment: Segment, clock: Clock) -> None:
        self.name, self.wire, self.device = spec.name, segment, axis.device
        self.listeners: list[Callable[[SimTimeNs, bytes], None]] = []
        """Called with each reply, at the time at which its first start bit is on the line."""
        self._spec, self._axis, self._clock = spec, axis, clock
        major, minor = map(int, spec.version.split(".")[:2])
        self._text = f"0000V{major:d}{minor:02d}".encode("ascii")[:8]
        self._version = major << 8 | minor
        self._ear = ModuleEar(clock, self._request)
        self._seen: Counter[str] = Counter()
        self._refusal = ""
        self._has_raised = False
        """True if its interpreter has raised an error: it is silent until the next power-up."""
        self._power_up()
        segment.join(spec.name, self)
        segment.set_address(spec.name, spec.number)

    def counters(self) -> dict[str, Any]:
        """Statistics since the start, for JSON; ``refusal``: the last one's reason."""
        counts = {kind: self._seen[kind] for kind in ("requests", "answers", "exceptions")}
        return {"unit": self._spec.number, **counts, "refusal": self._refusal or None}

    def _power_up(self) -> None:
        spec = self._spec
        self._ups, self._has_raised = self.device.power.ups, False
        known = {_ADDRESS: spec.number, _HOST: spec.host}
        if spec.baud in _BAUD_CODES:
            known[_BAUD] = _BAUD_CODES[spec.baud]
        self._interpreter = Interpreter(self._axis, known, self._version)

    # ---- hil.vocab.segment.Receiver ----

    @property
    def baud_now(self) -> int:
        return self._spec.baud

    def hear(
        self, start_ns: SimTimeNs, data: bytes, baud: int, packets: Sequence[Item] | None = None
    ) -> None:
        if flight := heard(start_ns, data, baud, self._spec.baud):
            self._ear.hear(flight)

    def hear_characters(self, characters: Sequence[HeardCharacter]) -> None:
        if characters:
            self._ear.hear(flight_of(tuple(characters)))

    def retract(self, after_ns: SimTimeNs) -> None:
        self._ear.retract(after_ns)

    # ---- a request ----

    def _request(self, now_ns: SimTimeNs, raw: bytes) -> None:
        if raw[0] != self._spec.number or not self.device.power.is_there:
            return
        if self._ups != self.device.power.ups:
            self._power_up()
        if self._has_raised:
            return
        self._seen["requests"] += 1
        try:
            reply = self._reply(raw)
        except Exception as error:  # a board's verbs may be anybody's: nobody else stops for its mistake
            self._has_raised = True
            self.device.power.fail(f"its TMCL module: {type(error).__name__}: {error}{place_of(error)}")
            return
        self._clock.at(SimTimeNs(now_ns + self._spec.response_ns), lambda now_ns: self._begin(now_ns, reply))

    def _reply(self, raw: bytes) -> bytes:
        """Carry a request out; answers the bytes of the reply."""
        spec, request = self._spec, request_of(raw)
        status, value = Status.OK, 0
        if not has_right_sum(raw):
            status = self._refused(Status.WRONG_CHECKSUM, "the checksum is wrong")
        elif asks_for_text(raw):
            return bytes((spec.host,)) + self._text
        else:
            try:
                value = self._interpreter.carry_out(request)
            except CommandRefused as error:
                status = self._refused(error.status, str(error))
        return Reply(spec.host, spec.number, status, request.command, value).encode()

    def _refused(self, status: Status, why: str) -> Status:
        self._seen["exceptions"] += 1
        self._refusal = f"{status:d}: {why}"
        return status

    def _begin(self, now_ns: SimTimeNs, raw: bytes) -> None:
        if not self.device.power.is_there:
            return
        self._seen["answers"] += 1
        for listener in self.listeners:
            listener(now_ns, raw)
        self.wire.transmit(self.name, now_ns, raw, self._spec.baud)
