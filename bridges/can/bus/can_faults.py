"""Faults of a CAN bus, as ``hil.vocab.faults`` names them, by their numbers.

Faults in force decide what the wire is like, in whatever order they begin and end.
"""

import math
from collections.abc import Callable
from contextlib import suppress
from functools import partial

from bridges.can.bus.bus_events import MailboxesFull
from bridges.can.bus.bus_nodes import BusNode
from bridges.can.bus.can_bus import LEAST_BIT_RATE, MOST_BIT_RATE, CanBus
from bridges.can.frames.can_frame import DATA_MAX, CanFrame
from hil.vocab.faults import Fault
from hil.vocab.time import NS_PER_MS, SimTimeNs
from hil.wire.byte_faults import Chance

ON_BUS = ("wire_noise",)
ON_NODE = ("wire_cut", "driver_stuck", "packet_no_ack", "node_babble", "bit_rate_wrong", "bus_off")
ONCE = ("bus_off",)
_DRAWS = 2.0**64


class CanFaults:
    """Faults of a bus.

    - ``wire_noise``: ``rate`` of bits are inverted, for all alike, while the bus is not idle.
    - ``wire_cut``: a node is cut off, and goes on alone.
    - ``driver_stuck``: a node holds the wire dominant.
    - ``packet_no_ack``: a node does not acknowledge ``rate`` of the frames that it hears.
    - ``node_babble``: a node sends frames of nonsense with the most urgent identifier, one ``every_ms``.
    - ``bit_rate_wrong``: a node has a rate of ``bit_rate`` bit/s; of several the latest counts.
    - ``bus_off``: a node is bus-off, once.
    """

    def __init__(self, bus: CanBus) -> None:
        self._bus = bus
        self._noises: dict[int, Fault] = {}
        self._babbling: set[int] = set()
        bus.switched_on = self._restore

    def inject(self, number: int, fault: Fault, name: str = "") -> None:
        """Begin a fault of the bus, or of a node on it.

        Raises:
            ValueError: a kind that a bus does not have, or a bit rate out of range.
        """
        if fault.kind in ON_BUS:
            self._set_noises(self._noises | {number: fault})
            return
        if fault.kind not in ON_NODE:
            raise ValueError(f"{fault.kind} means nothing on a CAN bus")
        node = self._bus.nodes[name]
        if fault.kind == "bus_off":
            self._force_bus_off(node)
        elif fault.kind == "node_babble":
            self._babbling.add(number)
            chance = Chance(int(fault.number("seed")))
            self._babble(
                number,
                name,
                max(round(fault.number("every_ms") * NS_PER_MS), 1),
                chance,
                self._bus.clock.now_ns,
            )
        else:
            if fault.kind == "bit_rate_wrong" and not (
                LEAST_BIT_RATE <= fault.number("bit_rate") <= MOST_BIT_RATE
            ):
                raise ValueError(f"bit_rate is {LEAST_BIT_RATE} to {MOST_BIT_RATE} bit/s")
            node.wire_faults[number] = fault
            self._rewire(node, fault.kind)

    def clear(self, number: int, fault: Fault, name: str = "") -> None:
        """End a fault."""
        self._babbling.discard(number)
        if number in self._noises:
            self._set_noises({each: held for each, held in self._noises.items() if each != number})
        node = self._bus.nodes.get(name)
        if node and node.wire_faults.pop(number, None):
            self._rewire(node, fault.kind)

    def _set_noises(self, noises: dict[int, Fault]) -> None:
        """Set all noises of the wire; those that were there before draw on from where they are."""
        with self._bus.main_line.change() as wire:
            states = dict(zip(_drawing(self._noises), wire.noise_states(), strict=True))
            wire.set_noise(
                [
                    (draws, states.get(number, int(noises[number].number("seed"))))
                    for number, draws in _drawing(noises).items()
                ]
            )
        self._noises = noises

    def _rewire(self, node: BusNode, kind: str) -> None:
        """Derive what a kind of faults does to a node from all of that kind."""
        faults = [fault for fault in node.wire_faults.values() if fault.kind == kind]
        if kind == "wire_cut":
            self._bus.set_cut(node.name, bool(faults))
            return
        if not node.is_on:
            return  # when it is switched on, all of them begin
        with self._bus.changed(node.name) as wire:
            if kind == "driver_stuck":
                wire.set_stuck(node.index, bool(faults))
            elif kind == "packet_no_ack":
                last = faults[-1] if faults else None
                wire.set_no_ack(node.index, *(_draws(last), int(last.number("seed"))) if last else (0, 0))
            else:
                rate = int(faults[-1].number("bit_rate")) if faults else node.bit_rate
                wire.set_rate(node.index, 0 if rate == self._bus.bit_rate else rate)

    def _restore(self, node: BusNode) -> None:
        """Let the faults of a node be in force on a controller that has started again."""
        for kind in dict.fromkeys(fault.kind for fault in node.wire_faults.values()):
            if kind != "wire_cut":
                self._rewire(node, kind)

    def _force_bus_off(self, node: BusNode) -> None:
        if not node.is_on:
            return
        with self._bus.changed(node.name) as wire:
            wire.force_bus_off(node.index)
        self._bus.news.note_state(node, self._bus.line_of(node.name).wire, self._bus.clock.now_ns)

    def _babble(self, number: int, name: str, every_ns: int, chance: Chance, now_ns: SimTimeNs) -> None:
        """Send nonsense, and again when it is time, or when a mailbox is free if that takes longer."""
        if number not in self._babbling or name not in self._bus.nodes:
            return
        frame = CanFrame(0, chance.bits().to_bytes(DATA_MAX, "little"))
        if self._bus.nodes[name].is_on:
            with suppress(MailboxesFull):
                self._bus.send(name, frame)
        again: Callable[[SimTimeNs], None] = partial(self._babble, number, name, every_ns, chance)
        self._bus.clock.at(now_ns + every_ns, again)


def _drawing(noises: dict[int, Fault]) -> dict[int, int]:
    """Draws out of 2**64 with which each noise hits a bit, by the noise's number. Rate 0 has no row."""
    return {number: draws for number, fault in noises.items() if (draws := _draws(fault))}


def _draws(fault: Fault) -> int:
    """Number of draws out of 2**64 that hit, at a fault's rate."""
    return math.ceil(fault.number("rate") * _DRAWS)
