"""Faults of twins, segments and taps: each begins and ends in simulated time, and stands in the input log."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from hil.core.fields import OF_KIND
from hil.session.device import Device
from hil.session.group import Group
from hil.session.inputs import Reset
from hil.session.uart import DeviceUart
from hil.vocab.faults import (
    FAULT_KINDS,
    PORT,
    SEGMENT,
    SERVO,
    STATION,
    SUPPLIED,
    TARGETS,
    TWIN_PORT,
    Fault,
    FaultRefused,
)
from hil.vocab.firmware import MAIN
from hil.vocab.segment import Segment
from hil.vocab.time import NS_PER_MS, NS_PER_S, SimTimeNs
from hil.wire.byte_faults import ByteFault, ByteFaults, Chance, byte_fault

if TYPE_CHECKING:
    from hil.session.bench import BenchRuntime

SERVO_FIELD = "raw"
"""A field that axes with an encoder have."""
OPEN_LINE_COUNT = 0x3FFF
"""What an open data line reads as: its pull-up, in all 14 bits."""


@dataclass(frozen=True)
class Place:
    """What a target's name means."""

    group: Group
    device: Device | None = None
    uart: DeviceUart | None = None
    segment: Segment | None = None
    station: str = ""

    def has(self, target: str) -> bool:
        """Whether a fault that needs this kind of target can be here."""
        return {
            PORT: self.uart is not None,
            TWIN_PORT: self.uart is not None,
            STATION: bool(self.segment and self.station),
            SEGMENT: self.segment is not None and not self.station,
            SUPPLIED: self.device is not None and self.device.axis.supply_V() > 0,
            SERVO: self.device is not None and SERVO_FIELD in OF_KIND[self.device.axis.kind],
        }.get(target, self.device is not None)


def place_of(bench: "BenchRuntime", target: str) -> Place | None:
    """What a target's name means in a bench, None for nothing."""
    if target in bench.segments:
        return Place(bench.group_of(target), segment=bench.segment(target))
    if target in bench.taps:
        return Place(bench.group_of(target), segment=bench.taps[target].segment, station=target)
    name, dot, uart_name = target.partition(".")
    device = bench.devices.get(name)
    if device is None or (uart_name if dot else MAIN) not in device.uarts:
        return None
    uart_name = uart_name if dot else MAIN
    segment = bench.segment_of(name, uart_name)
    station = f"{name}.{uart_name}" if segment else ""
    return Place(bench.group_of(name), device, device.uarts[uart_name], segment, station)


class Faults:
    """Those that were injected into a bench, by their numbers."""

    def __init__(self, bench: "BenchRuntime") -> None:
        self._bench = bench
        self._ends: dict[int, Callable[[], None]] = {}
        self.active: dict[int, Fault] = {}

    def check(self, fault: Fault) -> None:
        """Whether it can be where it is wanted.

        Raises:
            FaultRefused: it cannot, and why.
        """
        place = place_of(self._bench, fault.target)
        if place is None:
            raise FaultRefused(f"there is no {fault.target!r}; there are {', '.join(self.places())}")
        wanted = FAULT_KINDS[fault.kind].target
        if not place.has(wanted):
            fitting = [name for name in self.places() if (p := place_of(self._bench, name)) and p.has(wanted)]
            choice = ", ".join(fitting) or "none here"
            raise FaultRefused(f"{fault.kind} is on {TARGETS[wanted]}, as {choice}; not on {fault.target}")

    def places(self) -> list[str]:
        """All targets."""
        ports = [
            f"{name}.{uart}" for name, d in self._bench.devices.items() for uart in d.uarts if uart != MAIN
        ]
        return [*self._bench.devices, *ports, *self._bench.taps, *self._bench.segments]

    def inject(self, number: int, fault: Fault, now_ns: SimTimeNs) -> None:
        """An input: a fault is to begin now or later. ``check`` has found it good."""
        place = place_of(self._bench, fault.target)
        assert place
        self.active[number] = fault
        begin_ns = now_ns + round(fault.number("start_s") * NS_PER_S)
        for_ns = round(fault.number("for_s") * NS_PER_S)
        if begin_ns > now_ns:
            place.group.at(begin_ns, partial(self._begin, number, fault, place))
        else:
            self._begin(number, fault, place, now_ns)
        if for_ns:
            place.group.at(begin_ns + for_ns, partial(self._end_at, number))

    def clear(self, number: int, now_ns: SimTimeNs) -> None:
        """An input: a fault ends, or does not begin."""
        self._end_at(number, now_ns)

    def forget(self, device: str) -> None:
        """A device goes, and what was wrong with it."""
        for number, fault in list(self.active.items()):
            if fault.target.partition(".")[0] == device and fault.target not in self._bench.taps:
                del self.active[number]
                self._ends.pop(number, None)

    def _begin(self, number: int, fault: Fault, place: Place, now_ns: SimTimeNs) -> None:
        if number in self.active:
            self._ends[number] = _EFFECTS.get(fault.kind, _on_segment)(number, fault, place, now_ns)

    def _end_at(self, number: int, now_ns: SimTimeNs) -> None:
        self.active.pop(number, None)
        if end := self._ends.pop(number, None):
            end()


Effect = Callable[[int, Fault, Place, SimTimeNs], Callable[[], None]]
"""Makes a fault begin; answers what ends it."""


def _on_bytes(number: int, fault: Fault, place: Place, now_ns: SimTimeNs) -> Callable[[], None]:
    assert place.uart
    delay_ns = round(float(fault.parameters.get("delay_ms", 0)) * NS_PER_MS)
    effect = byte_fault(fault.kind, fault.number("rate"), delay_ns)
    ways = place.uart.rx_faults if fault.parameters["towards"] == "board" else place.uart.tx_faults
    ways[number] = ByteFaults(effect, int(fault.number("seed")))
    return lambda: (ways.pop(number), None)[1]


def _host(number: int, fault: Fault, place: Place, now_ns: SimTimeNs) -> Callable[[], None]:
    assert place.uart
    ways = [place.uart.tx_faults] + ([place.uart.rx_faults] if fault.kind == "host_close" else [])
    for way in ways:
        way[number] = ByteFaults(ByteFault(drop_rate=1.0), 0)

    def undo() -> None:
        for way in ways:
            way.pop(number)

    return undo


def _on_segment(number: int, fault: Fault, place: Place, now_ns: SimTimeNs) -> Callable[[], None]:
    segment = place.segment
    assert segment

    def answer(at_ns: int, station: str, raw: bytes) -> None:
        place.group.at(at_ns, partial(_send, segment, station, raw))

    segment.inject(number, fault, place.station, answer)
    return lambda: segment.clear(number, fault, place.station)


def _send(segment: Segment, station: str, raw: bytes, now_ns: SimTimeNs) -> None:
    if segment.has(station):
        segment.transmit(station, now_ns, raw, segment.baud_of(station))


def _babble(number: int, fault: Fault, place: Place, now_ns: SimTimeNs) -> Callable[[], None]:
    segment, station = place.segment, place.station
    assert segment
    chance = Chance(int(fault.number("seed")))
    period_ns = round(fault.number("every_ms") * NS_PER_MS)
    is_on = True

    def speak(at_ns: SimTimeNs) -> None:
        if is_on:
            data = bytes(chance.bits() & 0xFF for _ in range(int(fault.number("bytes"))))
            _send(segment, station, data, at_ns)
            place.group.at(at_ns + period_ns, speak)

    def stop() -> None:
        nonlocal is_on
        is_on = False

    speak(now_ns)
    return stop


def _reset(number: int, fault: Fault, place: Place, now_ns: SimTimeNs) -> Callable[[], None]:
    assert place.device
    place.device.apply(Reset(), now_ns)
    place.device.step(now_ns)
    place.group.note_due(place.device)
    return lambda: None


def _brown_out(number: int, fault: Fault, place: Place, now_ns: SimTimeNs) -> Callable[[], None]:
    device = place.device
    assert device
    device.lose_power(f"no power (fault {number})")
    return lambda: (_reset(number, fault, place, place.group.now_ns), None)[1]


def _hang(number: int, fault: Fault, place: Place, now_ns: SimTimeNs) -> Callable[[], None]:
    device = place.device
    assert device
    device.is_hung = True

    def go_on() -> None:
        device.is_hung = False
        device.step(place.group.now_ns)
        place.group.note_due(device)

    return go_on


def _load(number: int, fault: Fault, place: Place, now_ns: SimTimeNs) -> Callable[[], None]:
    assert place.device
    axis, torque_Nm = place.device.axis, fault.number("torque_Nm")
    axis.set("load_torque_Nm", axis.get("load_torque_Nm") + torque_Nm)
    return lambda: axis.set("load_torque_Nm", axis.get("load_torque_Nm") - torque_Nm)


def _encoder(number: int, fault: Fault, place: Place, now_ns: SimTimeNs) -> Callable[[], None]:
    assert place.device
    axis = place.device.axis
    count = OPEN_LINE_COUNT if fault.kind == "encoder_disconnect" else int(axis.get("raw"))
    axis.script_encoder(((now_ns, count),), False)
    return lambda: axis.script_encoder((), False)


def _shaft(number: int, fault: Fault, place: Place, now_ns: SimTimeNs) -> Callable[[], None]:
    assert place.device
    axis = place.device.axis
    values: dict[str, float] = {}
    undone: dict[str, float] = {}
    match fault.kind:
        case "shaft_jam":
            values["jam"] = 1
        case "steps_lost":
            axis.fault("shift_rev", fault.number("turn_deg") / 360)
        case "phase_open":
            values["open_a" if fault.parameters["coil"] == "A" else "open_b"] = 1
        case "thermal_trip":
            values |= {"open_a": 1, "open_b": 1}
        case "supply_sag":
            undone["supply_V"] = axis.supply_V()
            values["supply_V"] = fault.number("supply_V")
        case "encoder_slip":
            values["slip_counts"] = fault.number("counts")
        case "encoder_noise":
            axis.fault("noise_seed", fault.number("seed"))
            values["noise_counts"] = fault.number("counts")
    for what, value in values.items():
        axis.fault(what, value)

    def undo() -> None:
        for what in values:
            axis.fault(what, undone.get(what, 0))

    return undo


_EFFECTS: dict[str, Effect] = {
    **dict.fromkeys(("byte_flip", "byte_drop", "byte_duplicate", "byte_delay"), _on_bytes),
    "host_stop_reading": _host,
    "host_close": _host,
    "node_babble": _babble,
    "node_reset": _reset,
    "node_brown_out": _brown_out,
    "node_hang": _hang,
    "shaft_load": _load,
    **dict.fromkeys(
        (
            "shaft_jam",
            "steps_lost",
            "phase_open",
            "thermal_trip",
            "supply_sag",
            "encoder_slip",
            "encoder_noise",
        ),
        _shaft,
    ),
    "encoder_freeze": _encoder,
    "encoder_disconnect": _encoder,
}
