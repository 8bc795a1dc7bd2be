"""A CAN bus with drives' nodes in the test kit: frames at times, power, faults, replay."""

import io
from dataclasses import replace
from typing import Any

import pytest
from can_bench import TAP, config

from bridges.can.bus.bus_events import NodeState
from bridges.can.frames.can_frame import CanFrame
from bridges.can.frames.frame_length import frame_bits
from hil.compose.replay import replay
from hil.sim.bench import VIRTUAL
from hil.sim.input_log import InputLogWriter
from hil.testing import Bench
from hil.vocab.faults import FaultRefused

NODE = "m1.canopen"


def test_nodes_boot_with_their_boards(canbus) -> None:
    bus = canbus(3, first_id=10)
    booted = [bus.expect(0x70A + at, b"\0", within_ms=10) for at in range(3)]
    assert [each.frame.id for each in booted] == [0x70A, 0x70B, 0x70C], "by their urgency"
    assert [drive.node_id for drive in bus.drives()] == [10, 11, 12]
    bus.bench.device("m2").reset()
    assert bus.expect(0x70B, b"\0", within_ms=10)


def test_without_power_a_node_is_off_and_boots_again_with_it(canbus, fault) -> None:
    bus = canbus(2)
    bus.bench.run(ms=5)
    bus.read()
    off = fault(bus.bench, "node_brown_out", "m1")
    assert (bus.state(NODE), bus.state("m2.canopen")) == (NodeState.OFF, NodeState.ACTIVE)
    bus.bench.run(ms=3000)
    assert all(each.frame.id & 0x7F != 1 for each in bus.read())
    off.clear()
    assert bus.expect(0x701, b"\0", within_ms=10)


def test_a_board_that_has_no_power_from_the_start_is_off_until_it_has() -> None:
    faults = [{"fault": "node_brown_out", "target": "m1", "for_s": 1.0}]
    with Bench(config({"m1": 1, "m2": 2}) | {"faults": faults}) as bench:
        bus = bench.canbus()
        assert bus.expect(0x702, b"\0", within_ms=10)
        bench.run(ms=900)
        assert (bus.state(NODE), [each.frame.id for each in bus.heard]) == (NodeState.OFF, [0x702])
        assert bus.expect(0x701, b"\0", within_ms=200).at_ns > 1_000_000_000


def test_frames_are_sent_and_heard_at_their_times(canbus) -> None:
    bus = canbus(1, bit_rate=500_000)
    bus.bench.run(ms=5)
    bus.read()
    bus.send(0x123, b"\1\2", at_ms=7.5)
    tap_like: list[int] = []
    bus.bus.watchers.append(lambda event: tap_like.append(event.at_ns))
    bus.bench.run(ms=5)
    assert tap_like == [7_500_000 + frame_bits(CanFrame(0x123, b"\1\2")) * 2000]
    with pytest.raises(AssertionError, match=r"no 124# on can0 within 3 ms; the last: 701#00"):
        bus.expect(0x124, b"", within_ms=3)


def test_bus_off_and_recovery(canbus, fault) -> None:
    """A node that is bus-off is back after 128 times 11 recessive bits."""
    bus = canbus(2)
    bus.bench.run(ms=5)
    fault(bus.bench, "bus_off", NODE)
    assert bus.state(NODE) is NodeState.BUS_OFF
    bus.bench.run(ms=1.3)
    assert bus.state(NODE) is NodeState.BUS_OFF
    bus.bench.run(ms=0.2)
    assert (bus.state(NODE), bus.error_counters(NODE)) == (NodeState.ACTIVE, (0, 0))


def test_faults_of_all_kinds_begin_and_end_on_their_targets() -> None:
    with Bench(config({"m1": 1, "m2": 2})) as bench:
        bus = bench.canbus()
        bench.run(ms=5)
        stuck = bench.fault("driver_stuck", NODE, for_s=0.002)
        bench.run(ms=1)
        bus.send(0x10)
        bench.run(ms=0.5)
        assert not any(each.frame.id == 0x10 for each in bus.read())
        bench.run(ms=10)
        assert not stuck.is_active
        with bench.fault("wire_cut", "m2.canopen"), bench.fault("bit_rate_wrong", NODE, bit_rate=250_000):
            bench.run(ms=5)
        with bench.fault("packet_no_ack", NODE), bench.fault("node_babble", TAP, every_ms=1):
            bench.run(ms=5)
        bus.read()
        with bench.fault("node_babble", "m2.canopen", every_ms=1, start_s=0.001):
            bench.run(ms=5.5)
            assert [str(each.frame)[:4] for each in bus.read()] == ["000#"] * 5
        with bench.fault("wire_noise", "can0", rate=0.01):
            for number in range(20):
                bus.send(0x100 + number, b"\x55" * 8)
            bench.run(ms=30)
        assert bus.bus.counters(bench.now_ns)["errors"]


@pytest.mark.parametrize(
    ("kind", "target", "said"),
    [
        (
            "wire_noise",
            NODE,
            "wire_noise: m1.canopen is no segment and no CAN bus; there",
        ),
        (
            "bus_off",
            "can0",
            "bus_off: can0 is on no CAN bus; there are",
        ),
        (
            "wire_swapped",
            TAP,
            "wire_swapped: can0.a is on no segment",
        ),
        (
            "modbus_late",
            NODE,
            "modbus_late: m1.canopen has no Modbus node; ",
        ),
        ("shaft_jam", NODE, "shaft_jam: m1.canopen has no motor; there are m1"),
        (
            "bus_off",
            "m2.canopen",
            "there is no 'm2.canopen'; did you mean \"m1.canopen\"? there are m1, m1.canopen, can0.a, can0",
        ),
    ],
)
def test_faults_that_cannot_be(kind: str, target: str, said: str) -> None:
    parameters = {"rate": 0.1} if kind == "wire_noise" else {}
    with Bench(config()) as bench, pytest.raises(FaultRefused) as caught:
        bench.fault(kind, target, **parameters)
    assert str(caught.value).startswith(said), str(caught.value)


def test_the_seventeenth_noise_is_refused() -> None:
    with Bench(config()) as bench:
        for at in range(16):
            bench.fault("wire_noise", "can0", rate=1e-6, start_s=float(at))
        with pytest.raises(FaultRefused, match="can0 has 16 noises already"):
            bench.fault("wire_noise", "can0", rate=1e-6)


def logged(setup: dict[str, Any]) -> tuple[str, bytes]:
    """Log of a bench with clients at its taps, and what one of them heard."""
    file = io.StringIO()
    around = replace(VIRTUAL, log=InputLogWriter(file, "test", setup, {}))
    with Bench(setup, around=around) as bench:
        for tap in ("can0.a", "can0.b"):
            bench.tap(tap).write(b"S6\rZ1\rO\r")
        bench.run(ms=3)
        bench.fault("wire_noise", "can0", rate=0.003, seed=7)
        bench.fault("node_babble", NODE, every_ms=3, for_s=0.05)
        for number in range(40):
            bench.tap("can0.a").write(b"t%03X8001122334455%04X\r" % (0x100 + number, number))
            bench.run(ms=0.7)
        bench.device("m1").reset()
        bench.fault("bus_off", "m2.canopen")
        bench.run(ms=2100)
        return file.getvalue(), bench.tap("can0.b").read()


def test_a_log_is_the_same_again_to_the_byte() -> None:
    setup = config({"m1": 1, "m2": 2}, taps="ab")
    text, heard = logged(setup)
    assert (text, heard) == logged(setup)
    assert heard.count(b"t1") > 30
    replayed = replay(text.splitlines(keepends=True))
    assert replayed.difference() is None
    assert len(replayed.sent["m1"]) >= 2
    until_ns = max(sent.at_ns for sent in replayed.logged.sent)
    replayed.runtime.advance(until_ns)
    again = replayed.runtime.taps["can0.b"].drain(until_ns)
    assert heard.startswith(again)
    assert len(again) > 500


def test_a_raising_node_stops_its_board_alone(canbus) -> None:
    bus = canbus(2)
    bus.bench.run(ms=5)

    def broken(*of: object) -> None:
        raise ZeroDivisionError("by zero")

    bus.bench._runtime.cards[NODE].node.hear = broken  # type: ignore[method-assign]
    bus.send(0x601, bytes(8))
    bus.bench.run(ms=5)
    failed = bus.bench.device("m1").failed
    assert failed
    assert failed.startswith("its CANopen node: ZeroDivisionError: by zero (test_kit_canbus.py:")
    assert bus.bench.device("m2").failed is None
    bus.read()
    bus.bench.device("m1").reset()
    assert bus.expect(0x701, b"\0")


def test_ids_may_be_shared_where_that_is_wanted() -> None:
    with Bench(config({"m1": 5, "m2": 5}, duplicate_ids=True)) as bench:
        bus = bench.canbus()
        assert bus.expect(0x705, b"\0", within_ms=10)
        assert bench._runtime.wires["can0"].bus.frames >= 1  # type: ignore[attr-defined]
        with pytest.raises(KeyError):
            bus.drive("m3")


def test_what_does_not_fit_on_a_bus_is_said(canbus) -> None:
    with pytest.raises(ValueError, match="ids are 1 to 127"):
        canbus(128)
