"""Four drives that follow targets with SYNC turn as the same axes do in a run."""

import math
import struct
from itertools import pairwise

from bridges.can.bus.bus_events import NodeState
from bridges.can.frames.can_frame import CanFrame
from bridges.can.testing.can_faces import CanBusFace, DriveFace
from hil.sim.inputs import Follow
from hil.vocab.path import PathPiece
from hil.vocab.time import NS_PER_MS, SimTimeNs

DRIVES, CYCLES = 4, 500
NEAR_DEG = 1e-9


def prepared(bus: CanBusFace) -> list[DriveFace]:
    """Drives that are enabled in mode 8, with RPDO 1 (controlword, target) at SYNC, 1 ms apart."""
    drives = bus.drives()
    for it in drives:
        it.await_ready()
        cob_id = 0x200 + it.node_id
        for index, subindex, value, size in (
            (0x1400, 1, 1 << 31 | cob_id, 4),
            (0x1400, 2, 1, 1),
            (0x1600, 0, 0, 1),
            (0x1600, 1, 0x6040_0010, 4),
            (0x1600, 2, 0x607A_0020, 4),
            (0x1600, 0, 2, 1),
            (0x1400, 1, cob_id, 4),
            (0x6060, 0, 8, 1),
        ):
            it.write(index, subindex, value, size)
        it.nmt("operational")
        it.enable()
    bus.bench.run_until(math.ceil(bus.bench.now_ns / NS_PER_MS) + 1)
    bus.read()
    return drives


def target(drive: int, cycle: int) -> int:
    """Target in thousandths of a degree: a wave of each drive's own."""
    return round((10_000 + 15_000 * drive) * (1 - math.cos(2 * math.pi * (drive + 1) * cycle / 500)))


def positions(bus: CanBusFace) -> list[float]:
    return [bus.bench.axis(it.axis).snapshot().position_deg for it in bus.drives()]


class Probe:
    """Listener to a bus: when each SYNC was complete."""

    def __init__(self, bus: CanBusFace) -> None:
        self.ends_ns: list[int] = []
        bus.bus.join("probe", self)

    def hear(self, frame: CanFrame, start_ns: SimTimeNs, end_ns: SimTimeNs) -> None:
        if frame.id == 0x80:
            self.ends_ns.append(end_ns)

    def sent(self, frame: CanFrame, start_ns: SimTimeNs, end_ns: SimTimeNs) -> None:
        return

    def changed(self, state: NodeState, at_ns: SimTimeNs) -> None:
        return


def test_a_stream_of_targets_is_a_run_to_the_bit_of_what_counts(canbus) -> None:
    bus = canbus(DRIVES)
    probe = Probe(bus)
    drives = prepared(bus)
    begin_ms = bus.bench.now_ns / NS_PER_MS
    from_deg = [bus.bench.axis(it.axis).snapshot().r for it in drives]
    seen: list[tuple[int, list[float]]] = []
    for cycle in range(CYCLES):
        bus.send(0x80)
        bus.bench.run(ms=0.1)
        seen.append((int(bus.bench.now_ns), positions(bus)))
        for number, it in enumerate(drives):
            bus.send(0x200 + it.node_id, struct.pack("<Hi", 0x0F, target(number, cycle + 1)))
        bus.bench.run_until(begin_ms + cycle + 1)
    assert {later - before for before, later in pairwise(probe.ends_ns)} == {NS_PER_MS}
    assert all(it.statusword & 0x6F == 0x27 for it in drives)

    run = canbus(DRIVES)
    Probe(run)
    assert prepared(run)
    assert run.bench.now_ns / NS_PER_MS == begin_ms
    for number, it in enumerate(run.drives()):
        path, r = [], from_deg[number]
        for cycle in range(CYCLES):
            next_deg = target(number, cycle) / 1000
            path.append(PathPiece(NS_PER_MS, r, (next_deg - r) / 1e-3))
            r = next_deg
        run.bench._runtime.apply_input(it.axis, Follow(probe.ends_ns[0], (*path, PathPiece(0, r))))
    worst_deg = 0.0
    for at_ns, wanted in seen:
        run.bench.run_until(at_ns / NS_PER_MS)
        for is_at, should in zip(positions(run), wanted, strict=True):
            worst_deg = max(worst_deg, abs(is_at - should))
    assert worst_deg <= NEAR_DEG
    assert max(wanted[-1] for _, wanted in seen) > 100  # they have moved
