"""Watch over a node: its heartbeats or its answers to guarding, and how it does by them. CiA 301, 7.2.8."""

from dataclasses import dataclass

from bridges.can.canopen.canopen_codes import NMT_STATES, NmtState

HEARTBEAT_NS = 100_000_000
"""Interval of heartbeats, and of the requests of guarding."""
MISSING = 3
"""Intervals without a heartbeat after which a node is lost."""


@dataclass
class NodeWatch:
    """Watch over one node, from ``begin`` to ``end``. ``late_ns``: delay of the line."""

    late_ns: int = 0
    control: str = ""
    """``heartbeat``, ``guarding`` (it is asked by remote frames), or empty: only its boot-up is noticed."""
    _heard_ns: int | None = None
    _begun_ns: int = 0
    _toggle: int | None = None
    _why: str | None = None

    def begin(self, now_ns: int, control: str) -> None:
        """Begin to watch: the node was started just now."""
        self.control, self._heard_ns, self._toggle, self._why = control, now_ns, None, None
        self._begun_ns = now_ns

    def end(self) -> None:
        """Watch no more."""
        self._heard_ns = None

    @property
    def is_on(self) -> bool:
        return self._heard_ns is not None

    @property
    def is_guarded(self) -> bool:
        """True if it is asked by remote frames."""
        return self.control == "guarding"

    def hear(self, data: bytes, now_ns: int) -> bool:
        """Take a message of error control; True if it is that of a boot-up."""
        if len(data) != 1:
            return False
        state = data[0] & 0x7F
        if state == NmtState.INITIALISING:
            if self.is_on:
                self._why = "it was reset, or its power was off: it told its boot-up"
            return True
        if self.is_on:
            if self.is_guarded and data[0] >> 7 == self._toggle:
                return False  # it said the same twice: that is not life
            self._toggle = data[0] >> 7
            self._heard_ns = now_ns
            is_new = now_ns - self._begun_ns < MISSING * HEARTBEAT_NS + self.late_ns
            if state != NmtState.OPERATIONAL and not is_new:  # one on its way from before its start
                self._why = (
                    f"somebody took it out of operation: it is {NMT_STATES.get(state, f'in state {state}')}"
                )
        return False

    def loss(self, now_ns: int) -> str | None:
        """Reason why the node is lost, or None."""
        if self._heard_ns is None:
            return None
        silent_ns = now_ns - self._heard_ns
        if self._why is None and self.control and silent_ns > MISSING * HEARTBEAT_NS + self.late_ns:
            what = "answer to guarding" if self.is_guarded else self.control
            return f"no {what} for {silent_ns / 1e6:.0f} ms"
        return self._why
