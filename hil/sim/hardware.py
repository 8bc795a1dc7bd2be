"""A board without its firmware: axis, serial interfaces, memory."""

from collections.abc import Callable, Mapping

from hil.core import CoreAxis, CoreMotion
from hil.core.fields import OF_KIND
from hil.sim.inputs import Drive, Pin, ScriptEncoder, SetField
from hil.sim.interfaces import Interfaces
from hil.sim.memory import Memory
from hil.sim.spec import DeviceSpec
from hil.sim.stops import Guard
from hil.vocab.firmware import MAIN, NETWORK, Board

AxisInput = Pin | SetField | ScriptEncoder | Drive


class Hardware:
    """``store``: as ``Memory`` takes it; ``due_changed``: as ``Interfaces``."""

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
        """A stepper has no encoder."""
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
        """What its firmware is made with."""
        self.power_up_axis()

    def note(self, about: str, text: str | None) -> None:
        """Set a note for the operator; None: take it away."""
        if text is None:
            self.notes.pop(about, None)
        else:
            self.notes[about] = text

    def power_up(self) -> None:
        """The power has come anew; what is on the lines stays there."""
        self.notes.clear()
        self.power_up_axis()
        self.interfaces.clear()

    def power_up_axis(self) -> None:
        """The axis and its driver as after power-up; the shaft stays where it is."""
        self.axis.power_up()
        for name, value in self._registers.items():
            self.axis.set(name, value)

    def apply(self, given: AxisInput) -> None:
        """An input takes effect that the firmware has no part in."""
        match given:
            case Pin(pin, level):
                self.axis.pin(pin, level)
            case SetField(name, value):
                self.axis.set(name, value)
            case ScriptEncoder(points, linear):
                self.axis.script_encoder(points, linear)
            case Drive(train):
                self.axis.drive([(e.at_ns, e.pin, e.level, e.steps, e.duration_ns) for e in train])
