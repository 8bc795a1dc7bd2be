"""Hardware of a device, without its firmware: axis, serial interfaces, memory."""

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from hil.core import CoreAxis
from hil.sim.firmware_guard import Guard
from hil.sim.inputs import Pin, PulseTrain, ScriptEncoder, SetField
from hil.sim.interfaces import Interfaces
from hil.sim.setpoints import TimeOut
from hil.sim.uart_rx_line import DueChanged
from hil.vocab.address import DeviceParts
from hil.vocab.firmware import Board, Commit, Firmware
from hil.vocab.framing import Framing
from hil.vocab.own_fields import OwnFields
from hil.vocab.time import SimTimeNs
from hil.vocab.verbs import Verb

AxisInput = Pin | SetField | ScriptEncoder | PulseTrain


@dataclass(frozen=True, kw_only=True)
class DeviceSpec:
    """Specification of a device, beside its axes.

    ``bauds``: of its UARTs, by their names; None where bytes take no time. All but the first are made in
    software. ``power_up``: fields that the power sets beside the core's own, the encoder's registers, by the
    axis's name. ``nvm``: named contents of its memory at the start. ``framing``: of the lines that it is on.
    """

    name: str
    profile: str
    firmware: Callable[[Board], Firmware]
    bauds: Mapping[str, int | None]
    nvm: Mapping[str, bytes]
    power_up: Mapping[str, Mapping[str, int]]
    facts: Mapping[str, int]
    build: Mapping[str, float | str] = field(default_factory=dict)
    """Parameters of the firmware's build, by their names in its sources."""
    verbs: Mapping[str, Verb] = field(default_factory=dict)
    time_out: TimeOut | None = None
    follow: Callable[..., None] | None = None
    framing: Framing | None = None
    send_buffers: Mapping[str, int] = field(default_factory=dict)
    """Bytes of the buffers to send of its UARTs, where they are not the usual ones (``Interfaces``)."""
    receive_buffers: Mapping[str, int] = field(default_factory=dict)
    """The same of the buffers to receive."""
    resets_when_opened: bool = False
    """True if a client that opens its first port resets its processor."""
    own_map: object | None = None
    """Map of registers of its own (``DeviceInfo.own_map``)."""


class Memory:
    """Non-volatile memory. ``store`` makes sections the whole memory, and answers whether they are durable,
    or None: ``answered`` will be called."""

    def __init__(
        self, content: Mapping[str, bytes], store: Callable[[Mapping[str, bytes]], bool | None]
    ) -> None:
        self.content = dict(content)
        """Durable content by the names of sections; commits under way are not in it."""
        self._store = store
        self._pending: deque[tuple[dict[str, bytes], Callable[[bool], None]]] = deque()
        """Whole memory of each commit that the store has not answered, in their order, and whom to tell."""

    @property
    def is_committing(self) -> bool:
        """True while the store has still to answer a commit."""
        return bool(self._pending)

    def commit(self, request: Commit, done: Callable[[bool], None]) -> None:
        """Begin to write. ``done``: called with the store's answer, now or when it comes."""
        before = self._pending[-1][0] if self._pending else self.content  # each writes all that there is
        whole = before | {request.name: request.data}
        self._pending.append((whole, done))
        durable = self._store(whole)
        if durable is not None:
            self.answered(durable)

    def answered(self, durable: bool) -> None:
        """Take the store's answer to the oldest commit, if there is one; one that failed changes nothing."""
        if not self._pending:
            return
        whole, done = self._pending.popleft()
        if durable:
            self.content.update(whole)
        done(durable)


def _faces(axes: Mapping[str, CoreAxis]) -> dict[str, dict[str, CoreAxis]]:
    faces: dict[str, dict[str, CoreAxis]] = {}
    for name, axis in axes.items():
        faces.setdefault(axis.kind.seen_as, {})[name] = axis
    return faces


def _own_fields(axes: DeviceParts[CoreAxis]) -> OwnFields:
    first = axes[""] if axes else None
    return OwnFields(dict(first.kind.board_fields) if first else {}, first)


class Hardware:
    """Board without its firmware. ``store``: as ``Memory`` takes it; ``due_changed``: as ``Interfaces``."""

    def __init__(
        self,
        spec: DeviceSpec,
        axes: Mapping[str, CoreAxis],
        guard: Guard,
        store: Callable[[Mapping[str, bytes]], bool | None],
        due_changed: DueChanged,
    ) -> None:
        self.axes = DeviceParts(axes)
        self.memory = Memory(spec.nvm, store)
        self.interfaces = Interfaces(spec.bauds, guard, due_changed, spec.send_buffers, spec.receive_buffers)
        self.notes: dict[str, str] = {}
        """Notes for the operator, keyed by topic."""
        self.told: dict[str, float] = {}
        """Values of the firmware's own, by name."""
        self.processors = {name: axis.processor for name, axis in axes.items() if axis.processor}
        """Processors by the names of the axes whose pins they have."""
        for processor in self.processors.values():
            self.interfaces.join_processor(processor)
        self._reset_cause = "power"
        self._registers = {
            name: {
                each: value for each, value in spec.power_up.get(name, {}).items() if each in axis.kind.fields
            }
            for name, axis in axes.items()
        }
        """Registers of the encoders at power-up; a stepper has none."""
        self.fields = _own_fields(self.axes)
        """Fields of the board's own, as the firmware has them."""
        self.started_ns = SimTimeNs(0)
        """Time at which the firmware was made."""
        self.board = Board(
            uarts=self.interfaces.by_name,
            axes=self.axes,
            faces=_faces(axes),
            processors=self.processors,
            reset_cause=lambda: self._reset_cause,
            nvm=self.memory.content,
            facts=spec.facts,
            build=spec.build,
            note=self.note,
            tell=self.tell,
            fields=self.fields,
            clock=lambda: self.interfaces.now_ns,
            started_ns=lambda: self.started_ns,
        )
        """Interfaces that the firmware is made with."""
        self.power_up_axes()

    def note(self, about: str, text: str | None) -> None:
        """Set a note for the operator; None removes it."""
        if text is None:
            self.notes.pop(about, None)
        else:
            self.notes[about] = str(text)

    def tell(self, name: str, value: float | None) -> None:
        """Keep a value that the firmware tells; None removes it."""
        if value is None:
            self.told.pop(name, None)
        elif isinstance(value, int | float):
            self.told[name] = value
        else:
            raise TypeError(f"tell({name!r}, ...) takes a number or None, not {type(value).__name__}")

    def power_up(self) -> None:
        """Power the board up; what is on the lines stays there."""
        self._reset_cause = "power"
        self._clear()
        self.power_up_axes()
        self.interfaces.clear()

    def reset_processors(self) -> None:
        """Hold the processors, as their RESET pins do when a client opens the port: SRAM stays."""
        self._reset_cause = "line"
        self._clear()
        for processor in self.processors.values():
            processor.hold()
        self.interfaces.clear()

    def _clear(self) -> None:
        self.notes.clear()
        self.told.clear()

    def power_up_axes(self) -> None:
        """Reset the axes and their drivers as after power-up; the shafts stay where they are."""
        for name, axis in self.axes.items():
            axis.power_up()
            for field_name, value in self._registers[name].items():
                axis.set(field_name, value)
        self.fields.power_up()

    def cut_axes(self) -> None:
        """Take the axes' power."""
        for axis in self.axes.values():
            axis.power_up()  # after it nothing drives them
        self.fields.power_up()

    def stop_axes(self) -> None:
        """Stop the control of all axes."""
        for axis in self.axes.values():
            axis.loop(False)

    def apply(self, given: AxisInput, axis: CoreAxis) -> None:
        """Let an input take effect that the firmware has no part in."""
        match given:
            case Pin(pin, level):
                axis.pin(pin, level)
            case SetField(name, value):
                axis.set(name, value)
            case ScriptEncoder(points, linear):
                axis.script_encoder(points, linear)
            case PulseTrain(train):
                axis.drive([(e.at_ns, e.pin, e.level, e.steps, e.duration_ns) for e in train])
