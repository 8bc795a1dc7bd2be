"""Requests to the registers of an axis, carried out at one moment of simulated time."""

from collections.abc import Callable
from dataclasses import dataclass

from bridges.modbus.card.verb_ends import VerbEnds
from bridges.modbus.protocol.identification import Identification
from bridges.modbus.protocol.pdu import Refused, Request, exception
from bridges.modbus.registers.cells import Halves
from bridges.modbus.registers.map_parts import Manners
from bridges.modbus.registers.register_map import Wanted
from bridges.modbus.registers.register_unit import VerbStage
from bridges.modbus.registers.registers_protocol import Registers, code_and_reason
from bridges.modbus.unit_transaction import at_once, unit_transaction
from hil.core import CoreAxis
from hil.sim.inputs import Do, Input, Pin, Reset, SetField
from hil.sim.motion_end import begun_motion
from hil.sim.twin import Twin
from hil.sim.twin_info import axis_look, board_look
from hil.sim.verb_calls import Answer
from hil.vocab.desk_protocol import AxisLook
from hil.vocab.time import Clock, SimTimeNs
from hil.vocab.verbs import Effect, VerbRefused


@dataclass(frozen=True)
class CardAxis:
    """Axis behind a card, and what the card may do with it. ``part``: the axis's name; empty: the first."""

    device: Twin
    part: str
    make_registers: Callable[[], Registers]
    """Makes the registers as they are after power-up."""
    identification: Identification
    carry_out: Callable[[Input], Answer]
    """Lets an input take effect now. Raises VerbRefused."""
    problem: Callable[[str, float], str | None]
    """Says why a field cannot have a value, or None."""

    @property
    def axis(self) -> CoreAxis | None:
        """None: the board has none."""
        return self.device.axes[self.part] if self.device.axes else None


class RegisterServer:
    """Registers of an axis with their state, from one power-up on. There is one client: the line."""

    def __init__(self, clock: Clock, of: CardAxis) -> None:
        self._clock, self._of = clock, of
        self._registers = of.make_registers()
        self._halves: Halves = {}
        self._ends = (
            VerbEnds(clock, of.device, of.axis, self._registers.note) if of.axis is not None else None
        )
        self.refusal = ""
        """Reason of the last exception, in words."""
        self.carried_out = 0
        """Number of operations that were carried out."""

    @property
    def manners(self) -> Manners:
        """Manners of the unit on its line."""
        return self._registers.manners

    def has_function(self, function: int) -> bool:
        """True if the unit has a function."""
        functions = self.manners.functions
        return functions is None or function in functions

    def close(self) -> None:
        """Await nothing any more."""
        if self._ends:
            self._ends.clear()

    def answer(self, request: Request, now_ns: SimTimeNs) -> bytes:
        """Carry out a request of functions 1 to 6, 15, 16, 22, 23 and 43/14; answers the PDU, an exception
        where it is refused."""
        if self._ends:
            self._ends.look(now_ns)
        steps = unit_transaction(request, self._registers, self._halves, lambda: self._of.identification)
        try:
            return at_once(steps, self._look, lambda wanted: self._carry_out(wanted, now_ns))
        except (Refused, VerbRefused) as error:
            return self.refuse(request.function, error)

    def refuse(self, function: int, error: Refused | VerbRefused) -> bytes:
        """Make an exception, and keep the reason."""
        code, why = code_and_reason(error, self._registers.manners)
        self.refusal = f"{code:02}: {why}"
        return exception(function, code)

    def _look(self) -> AxisLook | None:
        axis = self._of.axis
        if axis is None:
            return board_look(self._of.device, self._clock.now_ns)
        return axis_look(self._of.device, axis.kind, axis.snapshot())

    def _carry_out(self, wanted: Wanted, now_ns: SimTimeNs) -> None:
        said = self._of.carry_out(self._input(wanted))
        self.carried_out += 1
        if wanted.number is None:
            return
        verb = self._of.device.verbs[str(wanted.given["name"])]
        if verb.effect is Effect.ENDS and self._ends:
            self._ends.follow(wanted, wanted.number, begun_motion(now_ns, said))
        else:
            if self._ends:
                self._ends.drop(wanted.number)
            self._registers.note(wanted, VerbStage.DONE)

    def _input(self, wanted: Wanted) -> Input:
        """Input that an operation is. Raises VerbRefused: a value is out of its limits."""
        given = dict(wanted.given)
        if wanted.operation == "reset":
            return Reset()
        if wanted.operation == "pin":
            return Pin(str(given["pin"]), int(str(given["level"])))
        if wanted.operation == "set":
            name, value = str(given["field"]), float(str(given["value"]))
            if problem := self._of.problem(name, value):
                raise VerbRefused("bad_parameter", problem)
            return SetField(name, value)
        name, parameters = str(given["name"]), given["parameters"]
        assert isinstance(parameters, dict)
        return Do(name, tuple(self._of.device.verbs[name].filled(parameters).items()))
