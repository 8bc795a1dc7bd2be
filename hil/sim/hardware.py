"""Hardware of a device, without its firmware: axis, serial interfaces, memory."""

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from hil.core import CoreAxis, CoreMotion
from hil.core.fields import OF_KIND
from hil.sim.firmware_guard import Guard
from hil.sim.inputs import Drive, Pin, ScriptEncoder, SetField
from hil.sim.interfaces import Interfaces
from hil.sim.setpoints import TimeOut
from hil.vocab.firmware import MAIN, NETWORK, Board, Commit, Firmware
from hil.vocab.verbs import Verb

AxisInput = Pin | SetField | ScriptEncoder | Drive


@dataclass(frozen=True, kw_only=True)
class DeviceSpec:
    """Specification of a device, beside its axis.

    ``bauds``: of its UARTs, by their names; None where bytes take no time. All but the main one are made in
    software. ``power_up``: the axis's fields that the power sets beside the core's own, the encoder's
    registers. ``nvm``: named contents of its memory at the start.
    """

    name: str
    profile: str
    firmware: Callable[[Board], Firmware]
    bauds: Mapping[str, int | None]
    nvm: Mapping[str, bytes]
    power_up: Mapping[str, int]
    facts: Mapping[str, int]
    verbs: Mapping[str, Verb] = field(default_factory=dict)
    time_out: TimeOut | None = None
    follow: Callable[..., None] | None = None


class Memory:
    """Non-volatile memory. ``store`` makes sections the whole memory, and answers whether they are durable,
    or None: ``answered`` will be called."""

    def __init__(
        self, content: Mapping[str, bytes], store: Callable[[Mapping[str, bytes]], bool | None]
    ) -> None:
        self.content = dict(content)
        """Durable content by the names of sections; commits under way are not in it."""
        self._store = store
        self._pending: deque[dict[str, bytes]] = deque()
        """Whole memory of each commit that the store has not answered, in their order."""

    @property
    def is_committing(self) -> bool:
        """Whether the store has still to answer."""
        return bool(self._pending)

    def commit(self, request: Commit) -> bool | None:
        """Begin to write; answers as ``store``."""
        whole = self.content | {request.name: request.data}
        self._pending.append(whole)
        return self._store(whole)

    def answered(self, durable: bool) -> bool:
        """Take the store's answer to the oldest commit; one that failed changes nothing. Returns whether
        there was one."""
        if not self._pending:
            return False
        whole = self._pending.popleft()
        if durable:
            self.content.update(whole)
        return True


class Hardware:
    """Board without its firmware. ``store``: as ``Memory`` takes it; ``due_changed``: as ``Interfaces``."""

    def __init__(
        self,
        spec: DeviceSpec,
        axis: CoreAxis,
        guard: Guard,
        store: Callable[[Mapping[str, bytes]], bool | None],
        due_changed: Callable[[], None],
    ) -> None:
        self.axis = axis
        self.memory = Memory(spec.nvm, store)
        self.interfaces = Interfaces(spec.bauds, guard, due_changed)
        self.notes: dict[str, str] = {}
        """Notes for the operator, keyed by topic."""
        self._registers = {name: value for name, value in spec.power_up.items() if name in OF_KIND[axis.kind]}
        """Registers of the encoder at power-up; a stepper has none."""
        uarts = self.interfaces.by_name
        self.board = Board(
            uart=uarts[MAIN],
            axis=axis,
            nvm=self.memory.content,
            network=uarts.get(NETWORK),
            motion=axis if isinstance(axis, CoreMotion) else None,
            facts=spec.facts,
            note=self.note,
        )
        """Interfaces that its firmware is made with."""
        self.power_up_axis()

    def note(self, about: str, text: str | None) -> None:
        """Set a note for the operator; None removes it."""
        if text is None:
            self.notes.pop(about, None)
        else:
            self.notes[about] = text

    def power_up(self) -> None:
        """Power the board up; what is on the lines stays there."""
        self.notes.clear()
        self.power_up_axis()
        self.interfaces.clear()

    def power_up_axis(self) -> None:
        """Reset the axis and its driver as after power-up; the shaft stays where it is."""
        self.axis.power_up()
        for name, value in self._registers.items():
            self.axis.set(name, value)

    def apply(self, given: AxisInput) -> None:
        """Let an input take effect that the firmware has no part in."""
        match given:
            case Pin(pin, level):
                self.axis.pin(pin, level)
            case SetField(name, value):
                self.axis.set(name, value)
            case ScriptEncoder(points, linear):
                self.axis.script_encoder(points, linear)
            case Drive(train):
                self.axis.drive([(e.at_ns, e.pin, e.level, e.steps, e.duration_ns) for e in train])
