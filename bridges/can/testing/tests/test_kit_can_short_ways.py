"""A drive on a card takes a target at SYNC by a short way; as by the long one, to the bit and nanosecond."""

import struct
from typing import Any

import pytest
from can_bench import M1
from hypothesis import given, settings
from hypothesis import strategies as st

from bridges.can.bus.bus_events import BusEvent
from bridges.can.cards.canopen_card import CanOpenCard
from bridges.can.cards.card_motor import CardMotor
from bridges.can.testing.can_faces import DriveFace, SdoAborted
from hil.sim.inputs import Follow
from hil.testing import Bench
from hil.vocab.path import Path
from hil.vocab.time import FOREVER, SimTimeNs

SWITCHES = {"home": {"from_deg": 40, "to_deg": 60}, "positive": {"above_deg": 90}}
CONFIG: dict[str, Any] = {
    "bench": "t",
    "devices": {"m1": M1, "m2": M1 | {"plant": "full"}},
    "can": {"can0": {"bit_rate": 1_000_000, "nodes": {"m1": 1, "m2": {"id": 2, "switches": SWITCHES}}}},
}
PDOS = (
    (0x1400, 0x200, (0x6040_0010, 0x607A_0020)),
    (0x1800, 0x180, (0x6041_0010, 0x6064_0020)),
)
STEPS = st.sampled_from([0, 40, 40, -40, 400, 4000])
"""Ways of a target in a cycle, in thousandths of a degree; the last is faster than the motor."""
OBJECTS = st.sampled_from(
    [
        (0x6060, 1, 8), (0x6060, 1, 9), (0x6060, 1, 1), (0x60FF, 4, 90_000), (0x6040, 2, 0x02),
        (0x6040, 2, 0x07), (0x6040, 2, 0x0F), (0x6065, 4, 1000), (0x605A, 2, 6), (0x607D, 4, 2_000_000),
        (0x607E, 1, 0x80),
    ]
)  # fmt: skip
ACTS = st.one_of(
    st.tuples(st.just("cycles"), st.integers(1, 30), STEPS, st.sampled_from([1, 2, 10])),
    st.tuples(st.just("write"), OBJECTS, st.none(), st.none()),
    st.tuples(st.just("enable"), st.none(), st.none(), st.none()),
    st.tuples(st.just("nmt"), st.sampled_from(["stopped", "operational", "reset"]), st.none(), st.none()),
    st.tuples(st.just("type"), st.sampled_from([b"n", b"y", b"s"]), st.none(), st.none()),
    st.tuples(st.just("wait"), st.sampled_from([1, 60, 200]), st.none(), st.none()),
)


def follow(motor: CardMotor, path: Path, start_ns: int = 0) -> None:
    motor._carry_out(Follow(start_ns, path))


def due(card: CanOpenCard, now_ns: SimTimeNs) -> None:
    if now_ns == card._timer_ns:
        card._timer_ns = FOREVER
        card._do(card.node.step, now_ns)


def write(drive: DriveFace, index: int, subindex: int, value: int, size: int) -> None:
    try:
        drive.write(index, subindex, value, size)
    except (SdoAborted, AssertionError):  # not now, or the node is silent
        return


def prepare(drive: DriveFace) -> None:
    for pdo, cob_id, mapped in PDOS:
        cob_id += drive.node_id
        write(drive, pdo, 1, 1 << 31 | cob_id, 4)
        write(drive, pdo, 2, 1, 1)
        write(drive, pdo + 0x200, 0, 0, 1)
        for number, entry in enumerate(mapped, 1):
            write(drive, pdo + 0x200, number, entry, 4)
        write(drive, pdo + 0x200, 0, len(mapped), 1)
        write(drive, pdo, 1, cob_id, 4)
    write(drive, 0x6060, 0, 8, 1)
    drive.nmt("operational")


def enable(drive: DriveFace) -> None:
    for word in (0x80, 0x06, 0x07, 0x0F):
        write(drive, 0x6040, 0, word, 2)


def played(
    acts: list[tuple[str, Any, Any, Any]], *, is_short: bool
) -> tuple[list[BusEvent], list[list[Any]], object, object]:
    """Play the acts, and answer what was on the bus and when, and the states of the axes after each."""
    with pytest.MonkeyPatch.context() as patch, Bench(CONFIG) as bench:
        if not is_short:
            patch.setattr(CardMotor, "follow", follow)
            patch.setattr(CanOpenCard, "_due", due)
        bus, events, states, position = bench.canbus(), list[BusEvent](), list[list[Any]](), 0
        bus.bus.watchers.append(events.append)
        bench.run(4300)
        drives = bus.drives()
        for drive in drives:
            prepare(drive)
            enable(drive)
        for kind, what, step, period_ms in acts:
            match kind:
                case "cycles":
                    for _ in range(what):
                        position += step
                        for drive in drives:
                            bus.send(0x200 + drive.node_id, struct.pack("<Hi", 0x0F, position))
                        bus.send(0x80)
                        bench.run(period_ms)
                case "write":
                    index, size, value = what
                    write(drives[-1], index, 2 if index == 0x607D else 0, value, size)
                case "enable":
                    enable(drives[-1])
                case "nmt":
                    drives[-1].nmt(what)
                case "type":
                    bench.port("m1").write(what)
                case "wait":
                    bench.run(what)
            states.append([bench.axis(drive.axis).snapshot() for drive in drives])
        return events, states, bus.bus.counters(bench.now_ns), [each._card.counters() for each in drives]


@pytest.mark.thorough
@pytest.mark.long
@settings(max_examples=40, deadline=None)
@given(st.lists(ACTS, min_size=1, max_size=12))
def test_a_target_by_the_short_way_is_that_by_the_long_one(acts: list[tuple[str, Any, Any, Any]]) -> None:
    assert played(acts, is_short=True) == played(acts, is_short=False)


def test_both_drives_follow() -> None:
    _, states, _, _ = played([("cycles", 30, 40, 2), ("wait", 10, None, None)], is_short=True)
    # The last target waits for the next SYNC, which is the more urgent frame.
    assert [state.r for state in states[-1]] == pytest.approx([29 * 0.04] * 2)
