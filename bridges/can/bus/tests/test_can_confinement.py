"""Errors and their confinement by the book; faults; a bus by leaps against one by bits."""

import os
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
import yaml
from can_rig import BIT_NS, READY_NS, Bench
from hypothesis import example, given, settings
from hypothesis import strategies as st

from bridges.can.bus.bus_events import MailboxesFull, NodeState
from bridges.can.frames.can_frame import CanFrame
from bridges.can.frames.frame_length import frame_bits

SEQUENCES = yaml.safe_load((Path(__file__).parent / "fault_confinement.yaml").read_text())


def seen(bus: Bench, node: str) -> list[Any]:
    return [*bus.error_counters(node), bus.state(node).value]


@pytest.mark.parametrize("leaps", [True, False])
@pytest.mark.parametrize("sequence", SEQUENCES, ids=lambda sequence: sequence["name"])
def test_sequences_by_the_book(sequence: dict[str, Any], leaps: bool) -> None:
    bus = Bench(*sequence["nodes"], leaps=leaps)
    bus.run()
    fault, node = None, ""
    for number, step in enumerate(sequence["steps"]):
        if "clear" in step:
            assert fault
            bus.faults.clear(1, fault, node)
        if "fault" in step:
            kind, node, parameters = step["fault"]
            fault = bus.inject(1, kind, node, **parameters)
        if "send" in step:
            sender, identifier, count = step["send"]
            for _ in range(count):
                bus.send(sender, CanFrame(identifier))
        bus.later(step["bits"] * BIT_NS)
        for name, wanted in step["after"].items():
            assert seen(bus, name) == wanted, f"step {number}, {name}"


def test_states_are_told_at_their_times() -> None:
    bus = Bench("a", "b", "c")
    bus.run()
    bus.inject(1, "bus_off", "a")
    assert bus.ears["a"].states == [(READY_NS, NodeState.BUS_OFF)]
    bus.later(10**7)
    assert bus.ears["a"].states[1] == (READY_NS + 128 * 11 * BIT_NS, NodeState.ACTIVE)
    bus.set_recovery("a", False)
    bus.inject(2, "bus_off", "a")
    bus.later(10**9)
    assert bus.state("a") is NodeState.BUS_OFF
    bus.set_recovery("a", True)  # as a driver does that restarts it
    bus.later(128 * 11 * BIT_NS)
    assert bus.state("a") is NodeState.ACTIVE


def test_a_passive_node_waits_eight_bits_more() -> None:
    """Alone it tries again and again, 3 bits behind each error frame, passive 11."""
    bus = Bench("a")
    bus.run()
    bus.send("a", CanFrame(0x123))
    bus.later(10**7)
    assert [event.state for event in bus.events if event.state] == ["error-passive"]
    starts = [event.start_ns for event in bus.events if event.error]
    periods_ns = [after - before for before, after in pairwise(starts)]
    until_ack_ns = bus.events[0].at_ns - READY_NS
    active_ns = until_ack_ns + (6 + 8 + 3) * BIT_NS
    assert periods_ns[:15] == [active_ns] * 15
    assert set(periods_ns[15:]) == {active_ns + 8 * BIT_NS}


def test_noise_makes_errors_and_nothing_is_lost() -> None:
    bus = Bench("a", "b", "c")
    bus.run()
    bus.inject(1, "wire_noise", rate=1e-3, seed=3)
    sent = []
    for number in range(500):
        frame = CanFrame(number, number.to_bytes(8))
        bus.send("a", frame)
        sent.append(frame)
        bus.later(10**6)
    bus.later(10**9)
    assert [told.frame for told in bus.ears["a"].out] == sent
    heard = [told.frame for told in bus.ears["b"].got]
    # A frame whose very last bit is hit is heard twice: the sender alone takes it for lost (3.2, part B: the
    # end of frame is valid for receivers a bit earlier).
    assert sorted(set(heard)) == sent
    assert len(heard) - len(sent) <= 3
    errors = sum(bus.errors.values())
    bits = sum(frame_bits(frame) for frame in sent)
    assert 0.6 * bits * 1e-3 < errors < 2.5 * bits * 1e-3
    assert {"stuff", "bit", "form"} <= set(bus.errors)


def test_noise_depends_on_its_seed_alone() -> None:
    def played(seed: int, leaps: bool) -> object:
        bus = Bench("a", "b", leaps=leaps)
        bus.run()
        bus.inject(1, "wire_noise", rate=2e-3, seed=seed)
        for number in range(50):
            bus.send("a", CanFrame(number, bytes(4)))
        bus.later(10**8)
        return bus.everything()

    assert played(1, True) == played(1, True) == played(1, False)
    assert played(1, True) != played(2, True)


def test_noise_of_rate_0_hits_nothing_and_leaves_others_as_they_are() -> None:
    def played(quiet: int) -> object:
        bus = Bench("a", "b")
        bus.run()
        bus.inject(quiet, "wire_noise", rate=0.0, seed=9)
        fault = bus.inject(5, "wire_noise", rate=2e-3, seed=1)
        for number in range(50):
            bus.send("a", CanFrame(number, bytes(4)))
        bus.later(10**7)
        bus.faults.clear(5, fault)
        bus.later(10**8)
        return bus.everything()

    assert played(1) == played(8)


def test_two_nodes_with_one_identifier_disturb_each_other() -> None:
    """The one that sends a recessive bit where the other's is dominant finds a bit error. Both count until
    they are passive; then the flag of one disturbs nobody, and the other gets through, and then the first."""
    bus = Bench("a", "b", "c")
    bus.run()
    bus.send("a", CanFrame(0x100, b"\x0f"))
    bus.send("b", CanFrame(0x100, b"\x07"))
    bus.later(10**8)
    assert [told.frame.data for told in bus.ears["c"].got] == [b"\x07", b"\x0f"]
    assert {bus.state("a"), bus.state("b")} <= {NodeState.PASSIVE, NodeState.ACTIVE}
    assert max(bus.error_counters("a")) >= 120
    assert bus.errors["bit"] >= 15


def test_two_nodes_with_one_frame_send_it_together() -> None:
    bus = Bench("a", "b", "c")
    bus.run()
    bus.send("a", CanFrame(0x100, b"\x0f"))
    bus.send("b", CanFrame(0x100, b"\x0f"))
    bus.later(10**6)
    assert len(bus.ears["c"].got) == 1
    assert len(bus.ears["a"].out) == len(bus.ears["b"].out) == 1
    assert bus.errors == {}


def test_a_node_that_is_cut_off_goes_on_alone() -> None:
    bus = Bench("a", "b", "c")
    bus.run()
    cut = bus.inject(1, "wire_cut", "a")
    bus.send("a", CanFrame(1))
    bus.send("b", CanFrame(2))
    bus.later(10**8)
    assert seen(bus, "a") == [128, 0, "error-passive"]
    assert [told.frame.id for told in bus.ears["c"].got] == [2]
    assert bus.ears["a"].got == []
    bus.faults.clear(1, cut, "a")
    bus.later(10**6)
    assert [told.frame.id for told in bus.ears["c"].got] == [2, 1]
    assert seen(bus, "a") == [127, 0, "error-active"]


def test_a_sender_that_is_cut_off_in_its_frame_leaves_an_error() -> None:
    bus = Bench("a", "b", "c")
    bus.run()
    bus.send("a", CanFrame(0x155, b"\x55" * 8))
    bus.later(40 * BIT_NS)
    bus.inject(1, "wire_cut", "a")
    bus.later(30 * BIT_NS)
    assert [(event.node, event.error) for event in bus.events] == [("b", "stuff"), ("c", "stuff")]
    bus.later(10**8)
    assert bus.ears["b"].got == []
    assert seen(bus, "a") == [128, 0, "error-passive"]


def test_a_node_that_babbles_takes_what_it_wants() -> None:
    bus = Bench("a", "b", "c")
    bus.run()
    babble = bus.inject(1, "node_babble", "b", every_ms=0.01)
    bus.later(10**6)  # from now on its mailboxes are never empty
    for number in range(3):
        bus.send("a", CanFrame(0x100 + number))
    bus.later(50 * 10**6)
    assert len(bus.ears["a"].out) == 0
    assert bus.counters(bus.timeline.now_ns)["load_percent"] > 95
    bus.faults.clear(1, babble, "b")
    bus.later(50 * 10**6)
    assert len(bus.ears["a"].out) == 3


def test_a_wire_that_is_held_costs_nothing_and_comes_back() -> None:
    bus = Bench("a", "b", "c")
    bus.run()
    stuck = bus.inject(1, "driver_stuck", "c")
    bus.send("a", CanFrame(1))
    day_ns = 86_400 * 10**9
    bus.later(day_ns)
    calls = bus.timeline._count
    bus.later(day_ns)
    assert bus.timeline._count == calls
    assert bus.counters(bus.timeline.now_ns)["load_percent"] == pytest.approx(100, abs=0.01)
    bus.faults.clear(1, stuck, "c")
    bus.later(10**7)
    assert [told.frame.id for told in bus.ears["b"].got] == [1]


def test_a_wire_on_which_nothing_can_happen_and_never_rests_goes_on() -> None:
    """Held, with noise, and all bus-off: never 11 recessive bits."""
    bus = Bench("a", "b")
    bus.run()
    faults = [
        (1, bus.inject(1, "wire_noise", rate=0.003), ""),
        (2, bus.inject(2, "driver_stuck", "a"), "a"),
    ]
    for number, name in enumerate("ab"):
        bus.inject(3 + number, "bus_off", name)
    bus.send("a", CanFrame(1))
    bus.later(2 * 10**9)
    assert bus.state("a") is bus.state("b") is NodeState.BUS_OFF
    for fault in faults:
        bus.faults.clear(*fault)
    bus.later(10**7)
    assert [told.frame.id for told in bus.ears["b"].got] == [1]


@pytest.mark.parametrize("wrong", [100_000, 125_000, 250_000])
def test_a_node_with_a_wrong_rate_disturbs_until_it_is_passive(wrong: int) -> None:
    bus = Bench("a", "b", "odd")
    bus.run()
    fault = bus.inject(1, "bit_rate_wrong", "odd", bit_rate=wrong)
    for number in range(20):
        bus.send("a", CanFrame(0x123, bytes([number] * 8)))
    bus.later(2 * 10**9)
    assert bus.ears["odd"].got == []
    assert [told.frame.data[0] for told in bus.ears["b"].got] == list(range(20))
    assert sum(bus.errors.values()) > 0
    assert max(bus.error_counters("odd")) >= 128
    # What it sends nobody understands, and the others go on.
    bus.set_recovery("odd", False)
    bus.send("odd", CanFrame(0x321, b"12345678"))
    bus.later(2 * 10**9)
    assert bus.ears["odd"].out == []
    bus.send("a", CanFrame(0x124))
    bus.later(10**8)
    assert bus.ears["b"].got[-1].frame.id == 0x124
    bus.faults.clear(1, fault, "odd")
    bus.set_recovery("odd", True)
    bus.later(10**8)
    assert bus.ears["b"].got[-1].frame == CanFrame(0x321, b"12345678")


@pytest.mark.parametrize("after_bits", range(12))
def test_a_rate_may_become_right_in_the_middle_of_a_flag(after_bits: int) -> None:
    bus = Bench("a", "b", "odd")
    bus.run()
    fault = bus.inject(1, "bit_rate_wrong", "odd", bit_rate=125_000)
    bus.send("a", CanFrame(0x123, b"12345678"))
    while not any(event.node == "odd" for event in bus.events):
        bus.later(BIT_NS)
    bus.later(after_bits * BIT_NS * 4)
    bus.faults.clear(1, fault, "odd")
    bus.later(10**8)
    assert len(bus.ears["a"].out) == 1


def test_a_node_that_is_too_fast_disturbs_as_long_as_it_is_there() -> None:
    """It takes a few recessive bits for the end of an error frame, and answers the dominant bit behind them
    by an overload flag, which is dominant of a passive node too (3.1.4, part B)."""
    bus = Bench("a", "b", "odd")
    bus.run()
    fault = bus.inject(1, "bit_rate_wrong", "odd", bit_rate=1_000_000)
    for _ in range(3):
        bus.send("a", CanFrame(0x123, bytes([4] * 8)))
    bus.later(10**8)
    assert bus.ears["b"].got == []
    assert bus.state("odd") is NodeState.PASSIVE
    assert NodeState.BUS_OFF in dict(map(reversed, bus.ears["a"].states))  # type: ignore[arg-type]
    bus.faults.clear(1, fault, "odd")
    bus.later(10**8)
    assert len(bus.ears["b"].got) == 3


def test_a_listener_acknowledges_nothing_and_has_no_errors() -> None:
    bus = Bench("a")
    bus.join("tap", bus.ears.setdefault("tap", type(bus.ears["a"])()), is_listening=True)
    bus.run()
    bus.send("a", CanFrame(1))
    bus.later(10**7)
    # An active flag of the sender destroys the frame; a passive one is as recessive as the frame's end.
    assert bus.ears["tap"].got[0].start_ns > bus.ears["a"].states[0][0]
    assert {told.frame.id for told in bus.ears["tap"].got} == {1}
    assert bus.ears["a"].out == []
    assert seen(bus, "a") == [128, 0, "error-passive"]
    assert seen(bus, "tap") == [0, 0, "error-active"]


@pytest.mark.parametrize(
    ("kind", "node", "parameters", "why"),
    [
        ("wire_swapped", "a", {}, "wire_swapped means nothing on a CAN bus"),
        ("bit_rate_wrong", "a", {"bit_rate": 5}, "bit_rate is 10000 to 1000000"),
    ],
)
def test_faults_that_cannot_be_are_refused(
    kind: str, node: str, parameters: dict[str, float], why: str
) -> None:
    bus = Bench("a")
    with pytest.raises(ValueError, match=why):
        bus.inject(1, kind, node, **parameters)


def test_a_node_that_listens_only_sends_nothing_until_it_may() -> None:
    bus = Bench("a", "b", "c")
    bus.run()
    bus.set_listening("a", True)
    bus.send("a", CanFrame(1))
    bus.later(10**6)
    assert bus.frames == 0
    bus.set_listening("a", False)
    bus.later(10**6)
    assert [told.frame.id for told in bus.ears["b"].got] == [1]


@pytest.mark.parametrize("kind", ["wire_cut", "driver_stuck", "bus_off"])
def test_what_is_done_when_a_frame_ends_comes_after_it(kind: str) -> None:
    """At the very nanosecond, and before the bus has its turn."""
    bus = Bench("a", "b", "c")
    bus.run()
    frame = CanFrame(0x123, b"1")
    end_ns = READY_NS + frame_bits(frame) * BIT_NS
    bus.timeline.at(end_ns, lambda now_ns: bus.inject(1, kind, "a") and None)
    bus.send("a", frame)
    bus.later(10**6)
    assert [told.end_ns for told in bus.ears["b"].got] == [end_ns]
    assert [told.end_ns for told in bus.ears["a"].out] == [end_ns]


@pytest.mark.parametrize("kind", ["wire_cut", "driver_stuck", "bus_off", "node_babble", "leave"])
def test_faults_may_begin_in_a_callback(kind: str) -> None:
    bus = Bench("a", "b", "c")
    bus.run()

    def hear(frame: CanFrame, start_ns: int, end_ns: int) -> None:
        if kind == "leave":
            bus.leave("a")
        elif frame.id == 1:
            bus.inject(1, kind, "a", every_ms=1)

    bus.ears["b"].hear = hear  # type: ignore[method-assign]
    bus.send("a", CanFrame(1))
    bus.later(5 * 10**6)
    assert bus.ears["c"].got[0].frame.id == 1
    assert bus.frames >= 1


# ---- leaps against bits ----

KINDS = (
    "wire_noise",
    "wire_cut",
    "driver_stuck",
    "packet_no_ack",
    "node_babble",
    "bit_rate_wrong",
    "bus_off",
)


@st.composite
def acts(draw: st.DrawFn) -> list[tuple[Any, ...]]:
    found: list[tuple[Any, ...]] = []
    for _ in range(draw(st.integers(1, 12))):
        pause_ns = draw(st.integers(0, 400_000))
        node = draw(st.sampled_from("abc"))
        what = draw(st.sampled_from(("send", "send", "send", "inject", "clear", "leave")))
        if what == "send":
            is_extended, low = draw(st.booleans()), draw(st.integers(0, 3))
            frame = CanFrame(low, draw(st.binary(max_size=2)), is_extended)
            found.append((pause_ns, what, node, frame))
        else:
            rate = draw(st.sampled_from((0.003, 0.5, 1.0)))
            kind = draw(st.sampled_from(KINDS))
            if kind == "wire_noise":
                rate = 0.003
            found.append((pause_ns, what, node, kind, rate, draw(st.sampled_from((125_000, 480_000)))))
    return found


def do(bus: Bench, given_acts: list[tuple[Any, ...]], look_ns: int = 0) -> object:
    bus.run()
    held = []
    for number, (pause_ns, what, node, *rest) in enumerate(given_acts):
        end_ns = bus.timeline.now_ns + pause_ns
        while look_ns and bus.timeline.now_ns + look_ns < end_ns:
            bus.later(look_ns)
            bus.counters(bus.timeline.now_ns)
        bus.run(end_ns)
        if what == "send":
            with suppress(MailboxesFull):
                bus.send(node, rest[0])
        elif what == "inject":
            kind, rate, bit_rate = rest
            where = "" if kind == "wire_noise" else node
            fault = bus.inject(number, kind, where, rate=rate, every_ms=0.3, bit_rate=bit_rate)
            if kind != "bus_off":
                held.append((number, fault, where))
        elif held:
            bus.faults.clear(*held.pop(0))
    bus.later(3_000_000)
    for each in held:
        bus.faults.clear(*each)
    bus.later(100_000_000)
    return bus.everything()


@pytest.mark.long
@settings(max_examples=int(os.environ.get("HIL_FUZZ", "150")), deadline=None)
@given(acts())
def test_fuzz_leaps_and_looks_change_nothing(given_acts: list[tuple[Any, ...]]) -> None:
    """Whatever is done, ``HIL_FUZZ`` times: by leaps or by bits, looked at or not, it is the same."""
    by_leaps = do(Bench("a", "b", "c"), given_acts)
    assert do(Bench("a", "b", "c", leaps=False), given_acts) == by_leaps
    assert do(Bench("a", "b", "c"), given_acts, 37_001) == by_leaps


@settings(max_examples=80, deadline=None)
@given(acts())
@example([(0, "send", name, CanFrame(0)) for name in "abc"])
def test_a_bus_gets_well_again(given_acts: list[tuple[Any, ...]]) -> None:
    """When all faults are over, whatever they were, everything that waits is sent; but for one frame that all
    send at the same bits, and nobody is left to acknowledge."""
    bus = Bench("a", "b", "c")
    do(bus, given_acts)
    bus.later(10**9)
    firsts = [node.mailboxes.first for node in bus.nodes.values()]
    assert len({first and first.frame for first in firsts}) == 1
    assert all(node.state is bus.state(name) for name, node in bus.nodes.items())
