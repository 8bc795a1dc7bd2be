"""Nodes that get and lose their power, and have a bit rate of their own."""

from can_rig import BIT_NS, RATE, Bench

from bridges.can.bus.bus_events import NodeState
from bridges.can.frames.can_frame import CanFrame


def test_a_node_without_power_acknowledges_and_hears_nothing() -> None:
    bus = Bench("a", "b")
    bus.switch_off("b")
    bus.run()
    bus.send("a", CanFrame(0x123))
    bus.later(10**7)
    assert (bus.ears["b"].got, bus.state("b")) == ([], NodeState.OFF)
    assert bus.errors["acknowledgement"] > 1
    bus.switch_on("b")
    bus.later(10**7)
    assert [told.frame for told in bus.ears["b"].got] == [CanFrame(0x123)]


def test_what_waits_is_lost_with_the_power_in_the_middle_of_a_frame_too() -> None:
    bus = Bench("a", "b")
    bus.run()
    bus.send("a", CanFrame(0x100, b"\x55"))
    bus.send("a", CanFrame(0x101, b"\x55"))
    bus.later(20 * BIT_NS)
    bus.switch_off("a")
    bus.later(10**7)
    bus.switch_on("a")
    bus.later(10**7)
    assert bus.ears["b"].got == []
    bus.send("a", CanFrame(0x102))
    bus.later(10**7)
    assert [told.frame.id for told in bus.ears["b"].got] == [0x102]


def test_a_controller_that_starts_anew_has_no_errors_and_is_not_bus_off() -> None:
    bus = Bench("a", "b")
    bus.run()
    bus.inject(1, "bus_off", "a")
    assert bus.state("a") is NodeState.BUS_OFF
    bus.switch_on("a")
    assert (bus.state("a"), bus.error_counters("a")) == (NodeState.ACTIVE, (0, 0))
    bus.later(12 * BIT_NS)
    bus.send("a", CanFrame(1))
    bus.later(10**6)
    assert len(bus.ears["b"].got) == 1


def test_faults_are_there_again_with_the_power() -> None:
    bus = Bench("a", "b", "c")
    bus.switch_off("b")
    bus.inject(1, "driver_stuck", "b")
    cut = bus.inject(2, "wire_cut", "c")
    bus.switch_off("c")
    bus.run()
    assert not bus.main_line.now().is_held
    bus.switch_on("b")
    bus.later(10**7)
    assert bus.main_line.now().is_held
    bus.faults.clear(2, cut, "c")
    assert bus.state("c") is NodeState.OFF
    bus.switch_off("b")
    bus.later(10**7)
    assert not bus.main_line.now().is_held


def test_a_rate_of_its_own_destroys_frames_until_a_fault_has_the_right_one() -> None:
    bus = Bench("a", "b", "c")
    bus.switch_on("b", RATE // 2)
    bus.run()
    bus.send("a", CanFrame(0x123, b"\x55" * 8))
    bus.later(10**6)
    assert bus.ears["c"].got == []
    fault = bus.inject(1, "bit_rate_wrong", "b", bit_rate=RATE)
    bus.later(10**7)
    assert len(bus.ears["c"].got) == 1
    bus.faults.clear(1, fault, "b")
    bus.send("a", CanFrame(0x123, b"\x55" * 8))
    bus.later(2 * 10**6)
    assert len(bus.ears["c"].got) == 1


def test_mailboxes_and_lost_arbitrations_can_be_asked_for() -> None:
    bus = Bench("a", "b", "c")
    bus.run()
    free = bus.free_mailboxes("a")
    for node, identifier in (("c", 0x10), ("a", 0x300), ("a", 0x301), ("b", 0x100)):
        bus.send(node, CanFrame(identifier))
    assert bus.free_mailboxes("a") == free - 2
    bus.later(10**6)
    assert (bus.free_mailboxes("a"), bus.waiting("a"), bus.tally("a")) == (free, 0, (0, 2)), "to c, then to b"
