"""Network management of a node: its services, made and joined; its states, commands and resets, and what
follows from lost communication.

Source: CiA 301 version 4.2.0, 7.3.2 and 7.5.2.33 (1029h).
"""

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from enum import Enum, auto
from functools import partial

from bridges.can.canopen import can_ids
from bridges.can.canopen.canopen_codes import NmtCommand, NmtState
from bridges.can.canopen.node.application import Application
from bridges.can.canopen.node.emergency import Emergencies, ErrorCode
from bridges.can.canopen.node.error_control import ErrorControl, HeartbeatConsumer
from bridges.can.canopen.node.lss_slave import LssSlave
from bridges.can.canopen.node.object_dictionary import ObjectDictionary
from bridges.can.canopen.node.parameter_store import ParameterStore
from bridges.can.canopen.node.pdos import Handler, Pdos
from bridges.can.canopen.node.sdo_server import SdoServer
from bridges.can.canopen.node.sync import Sync
from bridges.can.canopen.node.timers import Timers

TALKING = (NmtState.PRE_OPERATIONAL, NmtState.OPERATIONAL)
"""States in which all services but PDO work (table 38)."""
Routes = dict[int, Handler]


class Communication:
    """Services of one node. ``emit`` takes an identifier and bytes. Each is told of its settings by
    ``load``."""

    def __init__(
        self,
        dictionary: ObjectDictionary,
        address: Sequence[int],
        store: ParameterStore,
        emit: Callable[[int, bytes], None],
        use_bit_rate: Callable[[int], None],
        manager: "NetworkManagement",
    ) -> None:
        self.node_id = can_ids.UNCONFIGURED
        timers = self.timers = Timers()
        emergencies = self.emergencies = Emergencies(dictionary, timers, emit)
        self.store = store
        self.sync = Sync(dictionary, timers, emergencies, emit, manager.synced, manager.route)
        self.pdos = Pdos(dictionary, timers, emergencies, self.sync, emit, manager.route)
        self.sdo = SdoServer(dictionary, timers, lambda data: emit(can_ids.SDO_ANSWER + self.node_id, data))
        self.error_control = ErrorControl(
            dictionary,
            timers,
            emergencies,
            lambda data: emit(can_ids.ERROR_CONTROL + self.node_id, data),
            partial(manager.lose, "guarding"),
        )
        self.consumer = HeartbeatConsumer(
            dictionary, timers, emergencies, partial(manager.lose, "heartbeat"), manager.route
        )
        self.lss = LssSlave(
            address,
            timers,
            partial(emit, can_ids.LSS_ANSWER),
            store.keep_lss,
            manager.reset_communication,
            use_bit_rate,
        )
        self._command = manager.command

    def load(self) -> None:
        """Take the settings from the dictionary."""
        for service in (self.emergencies, self.sync, self.pdos, self.consumer):
            service.load()

    def routes(self, state: NmtState) -> tuple[Routes, Routes]:
        """Identifiers of the data frames and of the remote frames that a state wants, and who takes them."""
        found: dict[int, list[Handler]] = defaultdict(list)
        for can_id, handler in self._data_routes(state):
            found[can_id].append(handler)
        remote: Routes = {}
        if state is not NmtState.INITIALISING:
            remote[can_ids.ERROR_CONTROL + self.node_id] = self.error_control.hear_request
            remote |= dict(self.pdos.remote_routes())
        return {can_id: _joined(handlers) for can_id, handlers in found.items()}, remote

    def _data_routes(self, state: NmtState) -> Iterator[tuple[int, Handler]]:
        if self.lss.is_there:
            yield can_ids.LSS_REQUEST, self.lss.hear
        if state is NmtState.INITIALISING:
            return
        yield can_ids.NMT, self._command
        for node_id in self.consumer.node_ids:
            yield can_ids.ERROR_CONTROL + node_id, partial(self.consumer.hear, node_id)
        if state in TALKING:
            yield can_ids.SDO_REQUEST + self.node_id, self.sdo.hear
            yield self.sync.can_id, self.sync.hear
        if state is NmtState.OPERATIONAL:
            yield from self.pdos.routes()


def _joined(handlers: list[Handler]) -> Handler:
    """Make one handler of those that want the same frame."""
    if len(handlers) == 1:
        return handlers[0]

    def each(data: bytes, now_ns: int) -> None:
        for handler in handlers:
            handler(data, now_ns)

    return each


_STATES: dict[int, NmtState] = {
    NmtCommand.START: NmtState.OPERATIONAL,
    NmtCommand.STOP: NmtState.STOPPED,
    NmtCommand.PRE_OPERATIONAL: NmtState.PRE_OPERATIONAL,
}
"""States by the commands that lead to them."""
_NO_CHANGE, _TO_STOPPED = 1, 2
"""Values of 1029h; 0: from OPERATIONAL to PRE-OPERATIONAL."""


class BusState(Enum):
    """State of a bus controller (ISO 11898-1, fault confinement)."""

    ACTIVE = auto()
    PASSIVE = auto()
    OFF = auto()


class NetworkManagement:
    """States of a node with its services. ``on_routes`` is called with data and remote frames that are wanted
    from now on. ``configured``: node id and bit rate without LSS."""

    def __init__(
        self,
        dictionary: ObjectDictionary,
        application: Application,
        address: Sequence[int],
        store: ParameterStore,
        configured: tuple[int, int],
        emit: Callable[[int, bytes], None],
        use_bit_rate: Callable[[int], None],
        on_routes: Callable[[Routes, Routes], None],
    ) -> None:
        self.state = NmtState.INITIALISING
        self._dictionary = dictionary
        self._application = application
        self._configured = configured
        self._use_bit_rate = use_bit_rate
        self._on_routes = on_routes
        self._bus_state = BusState.ACTIVE
        self.services = Communication(dictionary, address, store, emit, use_bit_rate, self)
        store.on_stored = self._memory_known
        self._begins: Callable[[int], None] | None = None
        """Way in which the node begins when it is known what its memory has."""

    def power_up(self, now_ns: int) -> None:
        """Begin as after power-on, whatever was before."""
        self.services.timers.stop()
        self._begin(self._power_up, now_ns)

    def _power_up(self, now_ns: int) -> None:
        self._bus_state = BusState.ACTIVE
        services, kept = self.services, self.services.store.kept
        node_id, bit_rate = self._configured
        services.lss.power_up(kept.node_id or node_id, kept.bit_rate or bit_rate)
        if services.lss.bit_rate != bit_rate:
            self._use_bit_rate(services.lss.bit_rate)
        self._reset_node(now_ns)
        if services.store.is_damaged:
            services.emergencies.report(ErrorCode.LOST_PARAMETERS, 0)

    def power_off(self) -> None:
        self._begins = None
        self._leave(NmtState.INITIALISING)
        self.services.lss.reset()
        self.services.timers.stop()
        self._on_routes({}, {})

    def command(self, data: bytes, now_ns: int) -> None:
        """Take a command of the master; what is none does nothing."""
        if len(data) != 2 or data[1] not in (0, self.services.node_id):
            return
        if data[0] in _STATES:
            self._enter(_STATES[data[0]], now_ns)
        elif data[0] == NmtCommand.RESET:
            self.reset_node(now_ns)
        elif data[0] == NmtCommand.RESET_COMMUNICATION:
            self.reset_communication(now_ns)

    def reset_node(self, now_ns: int) -> None:
        """Begin again with all settings."""
        self._begin(self._reset_node, now_ns)

    def reset_communication(self, now_ns: int) -> None:
        """Begin again with all settings of communication; without a node id LSS alone goes on."""
        self._begin(self._reset_communication, now_ns)

    def _begin(self, how: Callable[[int], None], now_ns: int) -> None:
        """Begin as soon as it is known what the memory has: at once, or when a store has ended. The
        application does not go on until then."""
        self._leave(NmtState.INITIALISING)
        if self.services.store.is_storing:
            self._begins = how
            self.services.lss.reset()
            self._on_routes({}, {})
            # Not `is not`: each look at a method makes another object.
            if how != self._reset_communication:
                self._reset_application(now_ns)
        else:
            self._begins = None
            how(now_ns)

    def _memory_known(self, now_ns: int) -> None:
        if self._begins:
            self._begin(self._begins, now_ns)

    def _reset_node(self, now_ns: int) -> None:
        self._reset_application(now_ns)
        self._reset_communication(now_ns)

    def _reset_application(self, now_ns: int) -> None:
        self.services.emergencies.reset_profile()
        self._load(profile_too=True)
        self._application.entered(NmtState.INITIALISING, now_ns)

    def _reset_communication(self, now_ns: int) -> None:
        services = self.services
        services.node_id = services.lss.active_node_id = services.lss.node_id
        self._load(profile_too=False)
        services.lss.reset()
        if services.node_id == can_ids.UNCONFIGURED:
            self.route()
            return
        services.error_control.boot(now_ns)
        self._enter(NmtState.PRE_OPERATIONAL, now_ns)

    def synced(self, counter: int, now_ns: int) -> None:
        """Do what belongs to a SYNC, in its order."""
        if self.state is NmtState.OPERATIONAL:
            pdos = self.services.pdos
            pdos.take_held(now_ns)
            self._application.synced(now_ns)
            pdos.sample(counter, now_ns)

    def lose(self, what: str, now_ns: int) -> None:
        """Do as 1029h says, as communication was lost."""
        self._application.lost(what, now_ns)
        self.services.emergencies.flush(now_ns)  # STOPPED would keep it
        behaviour = self._dictionary.number(0x1029, 1)
        if behaviour == _TO_STOPPED:
            self._enter(NmtState.STOPPED, now_ns)
        elif behaviour != _NO_CHANGE and self.state is NmtState.OPERATIONAL:
            self._enter(NmtState.PRE_OPERATIONAL, now_ns)

    def bus_changed(self, state: BusState, now_ns: int) -> None:
        """Take note of the bus controller's state."""
        former, self._bus_state = self._bus_state, state
        if state is former:
            return
        emergencies = self.services.emergencies
        if former is BusState.OFF:
            emergencies.begin("bus-off", ErrorCode.RECOVERED_BUS_OFF)
            emergencies.end("bus-off")
        if state is BusState.OFF:
            self.lose("bus-off", now_ns)
        elif state is BusState.PASSIVE:
            emergencies.begin("passive", ErrorCode.ERROR_PASSIVE)
        else:
            emergencies.end("passive")

    def route(self) -> None:
        """Say which frames are wanted from now on."""
        self._on_routes(*self.services.routes(self.state))

    def _load(self, *, profile_too: bool) -> None:
        """Take all values from the memory, or their defaults."""
        services = self.services
        services.store.node_id = services.lss.node_id
        self._dictionary.reset(services.lss.node_id, services.store.values(), profile_too=profile_too)
        services.load()

    def _enter(self, state: NmtState, now_ns: int) -> None:
        if state is self.state:
            return
        self._leave(state)
        if state in TALKING:
            self.services.emergencies.is_silent = False
            self.services.sync.start(now_ns)
        if state is NmtState.OPERATIONAL:
            self.services.pdos.enter(now_ns)
        self.route()
        self._application.entered(state, now_ns)

    def _leave(self, state: NmtState) -> None:
        """End what does not go on in the next state."""
        self.state = state
        self.services.error_control.enter(state)
        self.services.pdos.leave()
        if state not in TALKING:
            self.services.sdo.reset()
            self.services.sync.stop()
            self.services.emergencies.is_silent = True
