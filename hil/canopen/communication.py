"""The services of a node, made and joined: which frame is for which."""

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Protocol

from hil.canopen import can_ids
from hil.canopen.application import NmtState
from hil.canopen.emergency import Emergencies
from hil.canopen.error_control import ErrorControl, HeartbeatConsumer
from hil.canopen.lss_slave import LssSlave
from hil.canopen.object_dictionary import ObjectDictionary
from hil.canopen.parameter_store import ParameterStore
from hil.canopen.pdos import Handler, Pdos
from hil.canopen.sdo_server import SdoServer
from hil.canopen.sync import Sync
from hil.canopen.timers import Timers

TALKING = (NmtState.PRE_OPERATIONAL, NmtState.OPERATIONAL)
"""States in which all services but PDO work (table 38)."""
Routes = dict[int, Handler]


class Manager(Protocol):
    """Events of the services."""

    def command(self, data: bytes, now_ns: int) -> None:
        """Take a command of network management."""

    def synced(self, counter: int, now_ns: int) -> None:
        """SYNC has come, with a counter or 0."""

    def lose(self, what: str, now_ns: int) -> None:
        """Communication was lost: ``heartbeat`` or ``guarding``."""

    def reset_communication(self, now_ns: int) -> None:
        """A node without an id has got one."""

    def route(self) -> None:
        """Other frames than before are to be heard."""


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
        manager: Manager,
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
