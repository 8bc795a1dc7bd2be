"""No command is carried out twice, every transaction has an outcome, and outcomes are true: counted at twins.

Each command moves by a power of 3, so that the digits of an axis's position tell how often each was done.
"""

import os
from collections.abc import Callable, Iterator

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from late_line import LateLine

from device_profiles.sac.line_nodes import NODES
from hil.master.sans_io.node_master import NodeMaster
from hil.master.sans_io.transaction import Outcome, Transaction
from hil.testing.bench import Bench
from hil.testing.line_masters import attend
from hil.vocab.time import NS_PER_MS

EXAMPLES = int(os.environ.get("HIL_FUZZ", "1")) * 15
STEP_DEG = 1.8
ADDRESSES = (4, 5, 6)
LATENCY_NS = 5 * NS_PER_MS
MostlyNone = st.none() | st.none()
FAULTS = ("packet_no_ack", "packet_bad_crc")


def line() -> Bench:
    """Three nodes past their start, that turn without ramps."""
    names = {f"s{address}": address for address in ADDRESSES}
    taps = {"master": {"port": "memory"}}
    bench = Bench(
        {
            "bench": "nodes",
            "devices": {name: {"profile": "sac"} for name in names},
            "segments": {"bus0": {"stations": list(names), "taps": taps}},
        }
    )
    bench.run(ms=1100)
    for text in (b"$CM%d\r", b"$CJ0\r", b"$R\r", b"v1500\r", b"a999\r", b"d999\r"):
        for name, address in names.items():
            bench.port(name).write(text % address if b"%" in text else text)
        bench.run(ms=50)
    bench.tap("bus0.master").read()
    return bench


def executions(bench: Bench, node: int, count: int) -> list[int]:
    """How often a node has done each command, by the digits of its position to the base 3."""
    position = round(bench.axis(f"s{node}").snapshot().commanded_deg / STEP_DEG)
    return [position // 3**number % 3 for number in range(count)]


def check(bench: Bench, sent: list[Transaction]) -> None:
    bench.run(ms=3000)
    told = {node: executions(bench, node, len(sent)) for node in ADDRESSES}
    for number, each in enumerate(sent):
        done = told[each.unit][number]
        assert each.outcome is not None
        assert done <= 1, f"{each} was done {done} times"
        if each.outcome is Outcome.DONE:
            assert done == 1, each
        if each.outcome in (Outcome.REFUSED, Outcome.NOT_SENT):
            assert done == 0, each


@settings(max_examples=EXAMPLES, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    nodes=st.lists(st.sampled_from(ADDRESSES), min_size=1, max_size=7),
    faults=st.lists(
        st.tuples(st.sampled_from(FAULTS), st.sampled_from(["bus0.master", "s4.network", "s5.network"])),
        max_size=3,
    ),
    seed=st.integers(0, 1000),
    delays_ms=st.lists(st.sampled_from([0, 0, 0, 3, 8, 30, 200, 450]), max_size=12),
    doubled=st.lists(st.booleans(), max_size=12),
    cut=MostlyNone | st.sampled_from(ADDRESSES),
    stop_after=MostlyNone | st.integers(0, 4),
)
def test_no_command_is_done_twice(
    nodes: list[int],
    faults: list[tuple[str, str]],
    seed: int,
    delays_ms: list[int],
    doubled: list[bool],
    cut: int | None,
    stop_after: int | None,
) -> None:
    with line() as bench:
        for kind, target in faults:
            bench.fault(kind, target, rate=0.5, seed=seed)
        if cut:
            bench.fault("wire_cut", f"s{cut}.network", start_s=0.02)
        master = NodeMaster(NODES, latency_ns=LATENCY_NS)
        late = LateLine(master, iter(each * NS_PER_MS for each in delays_ms), iter(doubled))
        sent: list[Transaction] = []
        for number, node in enumerate(nodes):
            if number == stop_after:
                master.cancel(bench.now_ns)
            sent.append(master.send(node, b"m%d" % 3**number, bench.now_ns))
            if number % 3 == 2:
                master.send(node, b"v1500", bench.now_ns)
        attend(bench, {"bus0.master": late}, lambda: master.is_idle)
        check(bench, sent)
        assert master.outstanding == []


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(
    "disturb",
    [
        lambda bench, seed: bench.fault("wire_noise", "bus0", rate=0.003, seed=seed),
        lambda bench, seed: bench.fault("node_babble", "s6.network", bytes=9, every_ms=11, seed=seed),
        lambda bench, seed: bench.fault("driver_late", "s5.network", late_us=700),
    ],
    ids=["noise", "babble", "late driver"],
)
def test_a_bad_line_does_nothing_twice(disturb: Callable[[Bench, int], object], seed: int) -> None:
    with line() as bench:
        disturb(bench, seed)
        master = NodeMaster(NODES)
        sent = [master.send((4, 5)[n % 2], b"m%d" % 3**n, bench.now_ns) for n in range(8)]
        attend(bench, {"bus0.master": master}, lambda: master.is_idle)
        check(bench, sent)


def test_a_settled_command_is_repeated_until_it_is_there() -> None:
    with line() as bench:
        bench.fault("packet_no_ack", "s4.network", rate=0.5, seed=2)
        master = NodeMaster(NODES, tries=10)
        sent = [master.send(4, b"a%d" % n, bench.now_ns) for n in range(1, 9)]
        attend(bench, {"bus0.master": master}, lambda: master.is_idle)
        assert {each.outcome for each in sent} == {Outcome.DONE}
        assert master.table[4].lost > 0


def test_who_never_answers_is_not_known_and_the_reason_says_why() -> None:
    with line() as bench:
        bench.fault("packet_no_ack", "s4.network")
        master = NodeMaster(NODES)
        once, often = (master.send(4, each, bench.now_ns) for each in (b"m3", b"v200"))
        attend(bench, {"bus0.master": master}, lambda: master.is_idle)
        assert (once.outcome, once.sent, often.sent) == (Outcome.NOT_KNOWN, 1, 3)
        assert once.why == "no answer to it, and it must not be carried out twice"
        assert often.why == "no answer to 3 tries"


def test_a_refused_command_goes_out_again_and_is_refused_at_last() -> None:
    with line() as bench:
        bench.fault("packet_bad_crc", "bus0.master")
        master = NodeMaster(NODES)
        sent = master.send(4, b"m3", bench.now_ns)
        attend(bench, {"bus0.master": master}, lambda: master.is_idle)
        assert (sent.outcome, sent.sent, sent.why) == (Outcome.REFUSED, 3, "it refused it 3 times")
        assert executions(bench, 4, 1) == [0]


def _forever(value: int) -> Iterator[int]:
    while True:
        yield value


def test_an_answer_after_the_time_out_is_the_answer() -> None:
    with line() as bench:
        master = NodeMaster(NODES, latency_ns=LATENCY_NS)
        late = LateLine(master, _forever(100 * NS_PER_MS), iter(()))
        first, second = (master.send(4, each, bench.now_ns) for each in (b"m1", b"m3"))
        other = master.send(5, b"m9", bench.now_ns)
        attend(bench, {"bus0.master": late}, lambda: master.is_idle)
        assert {first.outcome, second.outcome, other.outcome} == {Outcome.DONE}
        assert first.sent == second.sent == 1
        assert other.first_ns < first.ended_ns  # the line was free for others meanwhile


def test_a_doubled_answer_is_no_answer_to_the_next_command() -> None:
    with line() as bench:
        master = NodeMaster(NODES)
        late = LateLine(master, iter(()), iter([True]))
        first = master.send(4, b"m1", bench.now_ns)
        attend(bench, {"bus0.master": late}, lambda: first.is_over)
        bench.fault("wire_cut", "s4.network")
        second = master.send(4, b"m3", bench.now_ns)
        attend(bench, {"bus0.master": late}, lambda: master.is_idle)
        assert (first.outcome, second.outcome) == (Outcome.DONE, Outcome.NOT_KNOWN)
        assert master.table[4].strays == 1


def test_a_stop_does_not_take_the_late_answer_of_something_else_for_its_own() -> None:
    with line() as bench:
        master = NodeMaster(NODES, latency_ns=LATENCY_NS)
        late = LateLine(master, iter([40 * NS_PER_MS]), iter(()))
        move = master.send(4, b"m2187", bench.now_ns)
        attend(bench, {"bus0.master": late}, lambda: bench.now_ns > move.queued_ns + 9 * NS_PER_MS)
        cut = bench.fault("wire_cut", "s4.network")
        (_, stop) = master.stop([4], bench.now_ns)
        attend(bench, {"bus0.master": late}, lambda: master.is_idle)
        cut.clear()
        assert move.outcome is Outcome.NOT_KNOWN
        assert stop.outcome is Outcome.NOT_KNOWN
        assert stop.sent > 1
