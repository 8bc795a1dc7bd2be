"""A CAN bus of a bench, with its faults: a ``Wire`` of ``hil.vocab.wire``."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any

from bridges.can.bus.bus_events import BusEvent
from bridges.can.bus.bus_levels import event_levels
from bridges.can.bus.can_bus import CanBus
from bridges.can.bus.can_faults import CanFaults
from bridges.can.cards.channel_node import MOST_NODES, ChannelNode
from bridges.can.frames.socketcan import FRAMES_LOST
from hil.sim.client_tap import ClientTap
from hil.vocab.address import owner_of
from hil.vocab.faults import CAN_NODE, LINE, MOST_NOISES, ON_LINE, Fault
from hil.vocab.monitoring import HealthProblem
from hil.vocab.packet_field import Fields
from hil.vocab.time import Clock
from hil.vocab.wire import FrameKind, Report, WireTap
from hil.wire.pcapng import LINKTYPE_CAN_SOCKETCAN, Interface


def _packed(event: BusEvent) -> bytes:
    from bridges.can.frames.socketcan import pack_error, pack_frame

    return pack_frame(event.frame) if event.frame else pack_error(event.error or event.state)


def _words() -> Callable[[BusEvent], Mapping[str, Any]]:
    from bridges.can.canopen.words.canopen_words import CanOpenWords

    words = CanOpenWords({}, {})

    def described(event: BusEvent) -> Mapping[str, Any]:
        frame = event.frame
        meaning = words.say(frame) if frame else ""
        return {
            "at_s": event.start_ns / 1e9,
            "from": event.node,
            "frame": str(frame) if frame else None,
            "id": frame.id if frame else None,
            "hex": frame.data.hex() if frame else "",
            "text": meaning or event.error or event.state,
            "error": event.error or None,
            "state": event.state or None,
            "duration_s": (event.at_ns - event.start_ns) / 1e9,
        }

    return described


def _fields(texts: Iterable[str]) -> Fields:
    from bridges.can.canopen.words.canopen_words import CanOpenWords
    from bridges.can.frames.can_frame import parse_frame

    words = CanOpenWords({}, {})
    fields: Fields = ()
    for text in texts:
        frame = parse_frame(text)
        words.say(frame)
        fields = words.fields(frame)
    return fields


FRAMES = FrameKind(_packed, _words, LINKTYPE_CAN_SOCKETCAN, FRAMES_LOST, fields=_fields)


_NAMED = 8
"""Maximum number of nodes that are named at the start."""


class BenchBus:
    """Bus under its name, and what can go wrong on it; without nodes at first. ``clock`` is the time in which
    things happen on it."""

    kind, frames = "can", FRAMES

    def __init__(self, name: str, clock: Clock, bit_rate: int) -> None:
        self.name = name
        self.bus = CanBus(clock, bit_rate)
        self.watchers: list[Callable[[BusEvent], None]] = self.bus.watchers
        self._faults = CanFaults(self.bus)
        self._levels: list[tuple[int, int]] = []

    def counters(self, elapsed_ns: int) -> dict[str, Any]:
        """Statistics since the start, for JSON."""
        return {"bus": self.name, "bit_rate": self.bus.bit_rate, **self.bus.counters(elapsed_ns)}

    def report(self, elapsed_ns: int, taps: Sequence[WireTap], cards: Mapping[str, Any]) -> Report:
        """Report on the bus. ``nodes``: all controllers on it, those of taps too; ``drives``: what the
        CANopen nodes are."""
        notes = []
        for each in taps:
            notes += [each.failure] if each.failure else []
            notes += [f"{each.label}: {note}" for note in each.tap.notes.values()]
        drives = {name: card.counters() for name, card in cards.items()}
        own = {"taps": [each.row() for each in taps], "drives": drives, "notes": notes}
        return self.counters(elapsed_ns) | own

    def problems(self, taps: Sequence[WireTap]) -> Iterator[HealthProblem]:
        for each in taps:
            for note in each.tap.notes.values():
                yield HealthProblem("bus", each.label, note, "open it with the bit rate of the bus")

    def about(self, cards: Mapping[str, Any]) -> str:
        nodes = ", ".join(f"{name} is node {card.node_id}" for name, card in [*cards.items()][:_NAMED])
        more = f" and {len(cards) - _NAMED} more" if len(cards) > _NAMED else ""
        return f"CAN bus, {self.bus.bit_rate} bit/s" + (f"; {nodes}{more}" if cards else "")

    def interface(self, name: str) -> Interface:
        return Interface(name, baud=self.bus.bit_rate, link=FRAMES.link)

    def fault_targets(self, station: str) -> Collection[str]:
        return (ON_LINE, CAN_NODE) if station else (LINE,)

    def fault_problem(self, fault: Fault, active: Iterable[Fault]) -> str | None:
        noises = [each for each in active if (each.kind, each.target) == ("wire_noise", self.name)]
        if fault.kind == "wire_noise" and len(noises) >= MOST_NOISES:
            return f"{self.name} has {MOST_NOISES} noises already; clear one of them"
        return None

    def inject(self, number: int, fault: Fault, station: str) -> None:
        self._faults.inject(number, fault, station)

    def clear(self, number: int, fault: Fault, station: str) -> None:
        self._faults.clear(number, fault, station)

    # ---- levels, for pictures of the wire ----

    def record_levels(self, on: bool) -> None:
        if on and self._draw not in self.watchers:
            self.watchers.append(self._draw)
        elif not on and self._draw in self.watchers:
            self.watchers.remove(self._draw)
        self._levels.clear()

    def take_levels(self, until_ns: int) -> list[tuple[int, int]]:
        taken, self._levels = self._levels, []
        return taken

    def _draw(self, event: BusEvent) -> None:
        self._levels += event_levels(event, self.bus.bit_rate)

    # ---- hil.sim.client_tap.HasChannels ----

    def channel(self, label: str) -> ChannelNode:
        return ChannelNode(label, self.bus)

    def channel_problem(self, label: str, taps: Iterable[ClientTap]) -> str | None:
        channels = {tap.name: tap for tap in taps if isinstance(tap, ChannelNode)}
        if label in self.bus.nodes:
            return None if label in channels else f"{label} is a node of another kind"
        here = [name for name in channels if owner_of(name) == self.name]
        return f"{self.name} has {MOST_NODES} channels already" if len(here) >= MOST_NODES else None
