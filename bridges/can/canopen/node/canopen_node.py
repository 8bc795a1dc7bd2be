"""CANopen node: frames and times in, frames out.

Source: CiA 301 version 4.2.0.
"""

from collections.abc import Callable, Sequence
from typing import Any

from bridges.can.canopen.can_ids import NODE_ID_MAX, UNCONFIGURED
from bridges.can.canopen.canopen_codes import NmtState
from bridges.can.canopen.node.application import Application, Value
from bridges.can.canopen.node.communication_entries import (
    COMMUNICATION_NAMES,
    Identity,
    communication_entries,
)
from bridges.can.canopen.node.eds import StoredEds
from bridges.can.canopen.node.network_management import BusState, NetworkManagement, Routes
from bridges.can.canopen.node.object_dictionary import ObjectDictionary, key_of
from bridges.can.canopen.node.parameter_store import Keep, ParameterStore
from bridges.can.frames.can_frame import CanFrame
from hil.vocab.time import FOREVER


def _ignore(*_: object) -> None:
    pass


def _keep_nothing(section: bytes, stored: Callable[[bool, int], None]) -> None:
    stored(True, 0)


class CanOpenNode:
    """Node with the id ``node_id`` (1 to 127; 255: LSS has to give it one) and a device profile.

    It is off until ``power_up``. From then on it wants each frame of the bus whose identifier is in
    ``can_ids``, and ``step`` at ``due_ns``; it sends only while one of these is called. A block of SDO is up
    to 127 frames at once.

    ``make_application`` gets what the node does for it, which it can use from ``entered`` on; who calls the
    application from outside of the node calls ``step`` behind that. ``kept`` is the section that ``keep`` has
    stored last, or nothing; who asked for a store gets no answer before ``keep`` says how it ended.
    ``use_bit_rate`` is called with bits per second when LSS has set others.

    Raises:
        ValueError: the node id is out of range, or an entry's default is not of its type.
    """

    def __init__(
        self,
        node_id: int,
        bit_rate: int,
        make_application: Callable[["CanOpenNode"], Application],
        identity: Identity,
        send: Callable[[CanFrame], None],
        *,
        kept: bytes = b"",
        keep: Keep = _keep_nothing,
        use_bit_rate: Callable[[int], None] = _ignore,
    ) -> None:
        if not 1 <= node_id <= NODE_ID_MAX and node_id != UNCONFIGURED:
            raise ValueError(f"node id {node_id}; it is 1 to {NODE_ID_MAX}, or {UNCONFIGURED} without one")
        self._send = send
        self._is_on = False
        self._now_ns = 0
        self.due_ns: int = FOREVER
        """Next time at which the node wants ``step``: a past one if the application has asked for something
        outside of a call of the node."""
        self.can_ids: Sequence[int] = ()
        """Identifiers of the frames that the node wants, data and remote, all of 11 bits. Another object when
        they have changed."""
        self._handlers: Routes = {}
        self._remote_handlers: Routes = {}
        self._application = make_application(self)
        self.dictionary = _dictionary_of(self._application, identity)
        self._values = self.dictionary.values
        StoredEds(self.dictionary, identity)
        self._management = NetworkManagement(
            self.dictionary,
            self._application,
            identity[:4],
            ParameterStore(self.dictionary, kept, self._keep_by(keep)),
            (node_id, bit_rate),
            self._emit,
            use_bit_rate,
            self._take_routes,
        )
        services = self._management.services
        self._timers, self._emergencies, self._pdos = services.timers, services.emergencies, services.pdos
        self._lss = services.lss
        self._lss.is_there = identity.has_lss
        self._stepping = self._timers.make(self._application.step)

    @property
    def state(self) -> NmtState:
        return self._management.state

    @property
    def node_id(self) -> int:
        """Node id in use; 255 if there is none."""
        return self._management.services.node_id

    def power_up(self, now_ns: int) -> None:
        """Begin as after power-on, whatever was before."""
        self._is_on = True
        self._now_ns = now_ns
        self._management.power_up(now_ns)
        self._flush(now_ns)

    def power_off(self) -> None:
        """End. Nothing is heard or sent before the next ``power_up``."""
        self._is_on = False
        self._management.power_off()
        self.due_ns = FOREVER

    def step(self, now_ns: int) -> None:
        """Do what is due."""
        if self._is_on:
            self._now_ns = now_ns
            self._timers.run(now_ns)
            self._flush(now_ns)

    def hear(self, frame: CanFrame, now_ns: int) -> None:
        """Take a frame of the bus, at the end of its last bit. What is not for the node does nothing."""
        can_id, data, is_extended, is_remote, _ = frame
        handler = (self._remote_handlers if is_remote else self._handlers).get(can_id)
        if handler is not None and not is_extended and not self._lss.is_quiet:
            self._now_ns = now_ns
            handler(data, now_ns)
            self._flush(now_ns)

    def bus_off(self, now_ns: int) -> None:
        """Take note that the bus controller is bus-off."""
        self._change_bus(BusState.OFF, now_ns)

    def bus_passive(self, now_ns: int) -> None:
        """Take note that the bus controller is error-passive."""
        self._change_bus(BusState.PASSIVE, now_ns)

    def bus_on(self, now_ns: int) -> None:
        """Take note that the bus controller is error-active, as it is from power-up on."""
        self._change_bus(BusState.ACTIVE, now_ns)

    def counters(self) -> dict[str, Any]:
        """State, error register (1001h) and last error code, for JSON."""
        return {
            "state": self.state.name.lower().replace("_", "-"),
            "error_register": self._emergencies.register,
            "last_error": self._emergencies.last,
        }

    # ---- services for the application ----

    def value(self, index: int, subindex: int) -> Value:
        """Tell the value of an entry that is not live. Raises KeyError: there is none."""
        return self._values[index << 8 | subindex]  # as ``key_of``, a call less: for each SYNC

    def set_value(self, index: int, subindex: int, value: Value) -> None:
        """Set what reads get, without asking the application."""
        self.dictionary.values[key_of(index, subindex)] = value

    def emergency(self, code: int, register_bits: int, manufacturer: bytes = bytes(5)) -> None:
        """Send EMCY: an error code, the bits of 1001h that are set from now on, and five bytes. Code 0: the
        error of these bits is over."""
        self._emergencies.report(code, register_bits, manufacturer)
        self._be_due()

    def changed(self, index: int, subindex: int) -> None:
        """Send the event-driven TPDOs (254, 255) that have an entry; those of type 0 at the next SYNC."""
        self._pdos.note_change(key_of(index, subindex))
        self._be_due()

    def _be_due(self) -> None:
        if self._is_on:
            self.due_ns = self._now_ns

    # ---- its memory ----

    def _keep_by(self, keep: Keep) -> Keep:
        """Make a ``keep`` that sends what its answer causes."""

        def keep_and_flush(section: bytes, stored: Callable[[bool, int], None]) -> None:
            def ended(durable: bool, now_ns: int) -> None:
                self._now_ns = max(self._now_ns, now_ns)
                stored(durable, self._now_ns)
                if self._is_on:
                    self._flush(self._now_ns)

            keep(section, ended)

        return keep_and_flush

    # ---- frames ----

    def _change_bus(self, state: BusState, now_ns: int) -> None:
        if self._is_on:
            self._now_ns = now_ns
            self._management.bus_changed(state, now_ns)
            self._flush(now_ns)

    def _take_routes(self, handlers: Routes, remote_handlers: Routes) -> None:
        self._handlers, self._remote_handlers = handlers, remote_handlers
        self.can_ids = tuple(sorted(handlers.keys() | remote_handlers.keys()))

    def _flush(self, now_ns: int) -> None:
        """Send what the application has asked for, and be due when it is."""
        if self._emergencies.waiting:
            self._emergencies.flush(now_ns)
        if self._pdos.has_events:
            self._pdos.flush(now_ns)
        if self._stepping.at_ns != self._application.due_ns:
            self._stepping.start(self._application.due_ns)
        self.due_ns = self._timers.due_ns

    def _emit(self, can_id: int, data: bytes) -> None:
        if not self._lss.is_quiet:
            self._send(CanFrame(can_id, data))


def _dictionary_of(application: Application, identity: Identity) -> ObjectDictionary:
    """Make the dictionary of the node's entries and the application's, which come first."""
    common = communication_entries(application.device_type, identity)
    entries = {(each.index, each.subindex): each for each in (*common, *application.entries)}
    names = {**COMMUNICATION_NAMES, **application.names}
    return ObjectDictionary(entries.values(), names, application)
