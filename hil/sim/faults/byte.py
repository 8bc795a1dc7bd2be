"""Faults of the bytes at a port, either way; under their numbers, for each has a chance of its own."""

from hil.sim.roster import Place
from hil.vocab.faults import Fault
from hil.vocab.time import NS_PER_MS
from hil.wire.byte_faults import ByteFaults, byte_fault


def begin(number: int, fault: Fault, place: Place) -> None:
    """From now on it does something to bytes."""
    for way in _ways(fault, place):
        way[number] = _byte_faults(fault)


def end(number: int, fault: Fault, place: Place) -> None:
    """No longer."""
    for way in _ways(fault, place):
        way.pop(number)


def _ways(fault: Fault, place: Place) -> list[dict[int, ByteFaults]]:
    """The directions that a fault of a port is on."""
    assert place.uart
    rx, tx = place.uart.rx_faults, place.uart.tx_faults
    if fault.kind == "host_close":
        return [rx, tx]
    return [rx] if fault.parameters.get("towards") == "board" else [tx]


def _byte_faults(fault: Fault) -> ByteFaults:
    if fault.layer == "host":
        return ByteFaults(byte_fault("byte_drop", 1.0), 0)
    delay_ns = round(float(fault.parameters.get("delay_ms", 0)) * NS_PER_MS)
    effect = byte_fault(fault.kind, fault.number("rate"), delay_ns)
    return ByteFaults(effect, int(fault.number("seed")))
