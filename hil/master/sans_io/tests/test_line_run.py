"""Runs over a line of SACs in simulated time: lines and streams, pauses and stops, and what goes wrong."""

from collections.abc import Iterator, Sequence
from itertools import pairwise

import pytest
from run_rig import AXES, AXIS, PATHS, TAP, Braking, at_zero, circle, line, pulses

from device_profiles.sac.line_nodes import NODES
from device_profiles.sac.packet import encode
from hil.master.sans_io.line_run import AS_TOLD, AT_REST, LineRun
from hil.master.sans_io.node_master import NodeMaster
from hil.master.sans_io.run_items import RunDwell, RunItem, RunPause, RunState, RunSwitch
from hil.testing.line_masters import attend
from hil.vocab.path_planning import AxisMotion
from hil.vocab.time import NS_PER_MS


@pytest.fixture
def rig(segment):
    bench = segment(3)
    for node in AXES.values():
        bench.port(f"s{node}").write(b"$CL10\r")
        bench.run(ms=20)
    master = NodeMaster(NODES)
    return bench, master


def carry_out(bench, run: LineRun, until=None) -> None:
    attend(bench, {TAP: run}, until or (lambda: run.is_over))


def made(rig, items: Sequence[RunItem], **given) -> LineRun:
    bench, master = rig
    run = LineRun(master, AXES, iter(items), **given)
    run.start(bench.now_ns)
    return run


def test_lines_one_after_the_other_end_where_the_report_says(rig):
    bench, _ = rig
    first = line(at_zero(), 1, x=800, y=-400)
    second = line(first.end, 2, x=-200, y=100, z=600)
    run = made(rig, [first, second])
    carry_out(bench, run)
    assert (run.state, run.why) == (RunState.ENDED, "")
    assert pulses(bench) == {"x": 600, "y": -300, "z": 600}
    assert {each.axis: each.pulses for each in run.report.axes} == pulses(bench)
    assert {each.why for each in run.report.axes} == {AS_TOLD}
    assert run.progress(bench.now_ns).done_s == pytest.approx(first.duration_s + second.duration_s)
    assert run.report.line == 2


def test_a_phrase_takes_what_was_planned(rig):
    bench, _ = rig
    phrase = line(at_zero(), x=4000, y=3000)
    run = made(rig, [phrase])
    carry_out(bench, run)
    upload_s = len(list(PATHS.line({"x": AxisMotion(AXIS, 1, 1, 1)}).commands)) * 0.01
    assert phrase.duration_s < run.report.took_s < phrase.duration_s + 0.5 + upload_s


def test_a_stream_through_full_queues_has_no_gap_and_loses_nothing(rig):
    bench, _ = rig
    phrase = circle(at_zero())
    run = made(rig, [phrase])
    carry_out(bench, run)
    assert run.state is RunState.ENDED, run.why
    assert pulses(bench) == at_zero()
    edges = {axis: bench.device(f"s{AXES[axis]}").pin("clk").edges() for axis in "xy"}
    starts = {axis: [at for at, level in each if level] for axis, each in edges.items()}
    # Where an axis turns round it stands a while; elsewhere the longest pause is that of the slowest piece.
    assert all(max(b - a for a, b in pairwise(each)) < 300e6 for each in starts.values())
    took_ns = max(each[-1] for each in starts.values()) - min(each[0] for each in starts.values())
    assert took_ns / 1e9 == pytest.approx(phrase.duration_s, abs=0.06)


def test_a_stream_that_the_line_cannot_carry_is_stopped_and_told(rig):
    bench, _ = rig
    phrase = circle(at_zero(), radius=800, pieces=800, piece_s=0.005)
    run = made(rig, [phrase], brakes={"x": b"d20", "y": b"d20"})
    carry_out(bench, run)
    assert run.state is RunState.FAILED
    assert "ms after it was needed; the line is too slow" in run.why
    assert [each.is_known for each in run.report.axes] == [False, False, True]


def test_dwells_switches_and_pauses_come_in_their_order(rig):
    bench, _ = rig
    first = line(at_zero(), 1, x=200)
    told = []
    run = made(
        rig,
        [
            RunSwitch("spindle", [(6, b"m50v300a999d999")], 1),
            first,
            RunDwell(0.5, 2),
            RunPause(3),
            line(first.end, 4, x=-200),
        ],
        switched=lambda item: told.append(item.name),
    )
    carry_out(bench, run, lambda: run.state is RunState.PAUSED)
    assert told == ["spindle"]
    assert run.progress(bench.now_ns).line == 3
    assert pulses(bench)["x"] == 200
    assert run.report.took_s > first.duration_s + 0.5
    bench.run(ms=1000)
    run.resume(bench.now_ns)
    carry_out(bench, run)
    assert run.state is RunState.ENDED
    assert pulses(bench) == {"x": 0, "y": 0, "z": 100}


def test_a_pause_is_where_all_axes_rest(rig):
    bench, _ = rig
    first = line(at_zero(), 1, x=2000, y=1000)
    run = made(rig, [first, line(first.end, 2, x=-2000)])
    carry_out(bench, run, lambda: run.progress(bench.now_ns).done_s > 0.2)
    run.pause()
    carry_out(bench, run, lambda: run.state is RunState.PAUSED)
    assert pulses(bench) == first.end
    run.resume(bench.now_ns)
    carry_out(bench, run)
    assert pulses(bench) == {"x": 0, "y": 1000, "z": 0}


def test_other_items_for_the_rest_are_taken_at_the_next_item(rig):
    bench, _ = rig
    first = line(at_zero(), 1, x=400)
    asked = []

    def changed() -> Iterator[RunItem] | None:
        asked.append(bench.now_ns)
        return iter([line(first.end, 2, speed=500, x=400)]) if len(asked) == 2 else None

    run = made(rig, [first, line(first.end, 2, x=400)], changed=changed)
    carry_out(bench, run)
    assert len(asked) == 3
    assert pulses(bench)["x"] == 800
    assert run.report.took_s > first.duration_s + 0.8


def test_a_stop_with_grace_brakes_along_the_path_where_that_can_be_and_all_places_are_known(rig):
    bench, _ = rig
    phrase = Braking(circle(at_zero()))
    run = made(rig, [phrase, line(at_zero(), x=800)])
    carry_out(bench, run, lambda: run.progress(bench.now_ns).done_s > 0.5)
    run.stop(bench.now_ns, "grace")
    carry_out(bench, run)
    assert (run.state, run.why) == (RunState.STOPPED, "a controlled stop was asked for")
    assert {each.axis: each.pulses for each in run.report.axes} == pulses(bench) == phrase.end
    assert pulses(bench) != at_zero()
    assert phrase.duration_s < 3


def test_a_pause_brakes_along_the_path_and_the_run_goes_on_behind_it(rig):
    bench, _ = rig
    phrase = Braking(circle(at_zero()))

    def items() -> Iterator[RunItem]:
        yield phrase
        yield line(phrase.end, 2, x=100)

    run = made(rig, items())
    carry_out(bench, run, lambda: run.progress(bench.now_ns).done_s > 0.5)
    run.pause()
    carry_out(bench, run, lambda: run.state is RunState.PAUSED)
    assert pulses(bench) == phrase.end
    run.resume(bench.now_ns)
    carry_out(bench, run)
    assert run.state is RunState.ENDED
    assert pulses(bench)["x"] == phrase.end["x"] + 100


def test_a_stop_with_grace_lets_a_phrase_end_that_is_short(rig):
    bench, _ = rig
    first = line(at_zero(), x=800)
    run = made(rig, [first, line(first.end, x=800)])
    carry_out(bench, run, lambda: run.progress(bench.now_ns).done_s > 0.1)
    run.stop(bench.now_ns)
    carry_out(bench, run)
    assert run.state is RunState.STOPPED
    assert {each.axis: each.pulses for each in run.report.axes} == pulses(bench) == first.end


@pytest.mark.parametrize("latency_ms", [0, 250])
@pytest.mark.parametrize("how", ["grace", "prejudice"])
def test_a_stop_leaves_all_axes_at_rest_and_says_that_their_places_are_not_known(rig, how, latency_ms):
    bench, _ = rig
    rig = bench, NodeMaster(NODES, latency_ns=latency_ms * NS_PER_MS)
    run = made(rig, [line(at_zero(), x=12000, y=-6000)], brakes={"x": b"d60", "y": b"d30"})
    carry_out(bench, run, lambda: run.progress(bench.now_ns).done_s > 1)
    speed_rpm = bench.axis("s4").snapshot().speed_rpm
    run.stop(bench.now_ns, how)
    begun_ns = bench.now_ns
    carry_out(bench, run)
    assert run.state is RunState.STOPPED
    bench.run(ms=1500)
    assert [bench.axis(f"s{node}").snapshot().motion_state for node in AXES.values()] == [0, 0, 0]
    x, y, z = run.report.axes
    assert (x.is_known, y.is_known, z.is_known) == (False, False, True)
    now = pulses(bench)
    assert 0 < abs(x.about_pulses) <= abs(now["x"])
    assert now["x"] - x.about_pulses < (30 if how == "prejudice" else 2000)
    assert speed_rpm > 100
    last_ns = [at for at, level in bench.device("s4").pin("clk").edges() if level][-1]
    assert (last_ns - begun_ns > 50 * NS_PER_MS) == (how == "grace")


def test_a_node_that_stops_answering_stops_the_others_with_grace(rig, fault):
    bench, _ = rig
    run = made(rig, [circle(at_zero())], brakes={"x": b"d60", "y": b"d60"})
    carry_out(bench, run, lambda: run.progress(bench.now_ns).done_s > 1)
    fault(bench, "wire_cut", "s5.network")
    carry_out(bench, run)
    assert run.state is RunState.FAILED
    assert run.why.startswith("node 5 (y), m")
    assert "not known (no answer to it, and it must not be carried out twice)" in run.why
    bench.run(ms=500)
    assert bench.axis("s4").snapshot().motion_state == 0
    x, y, z = run.report.axes
    assert not x.is_known
    assert x.why == "a controlled stop cut its motion short"
    assert "whether it stopped is not known: s: not known" in y.why
    assert (z.pulses, z.why) == (0, AT_REST)


def test_a_node_that_refuses_before_the_release_leaves_all_where_they_were(rig, fault):
    bench, _ = rig
    fault(bench, "packet_nak", "s5.network")
    run = made(rig, [line(at_zero(), x=800, y=800)])
    carry_out(bench, run)
    assert run.state is RunState.FAILED
    assert "refused (it refused it 3 times)" in run.why
    bench.run(ms=500)
    assert pulses(bench)["x"] == 0
    x, y, _ = run.report.axes
    assert (x.pulses, x.why) == (0, AT_REST)
    assert not y.is_known  # it refuses the stop, too


def test_lost_answers_of_the_upload_are_told_and_nothing_is_released(rig, fault):
    bench, _ = rig
    fault(bench, "packet_no_ack", "s4.network")
    run = made(rig, [line(at_zero(), x=800, y=800)])
    carry_out(bench, run)
    assert run.state is RunState.FAILED
    bench.run(ms=3000)
    assert pulses(bench) == at_zero()


def test_an_upload_whose_answer_is_lost_begins_again_and_nothing_goes_twice(rig, fault):
    bench, _ = rig
    phrase = line(at_zero(), x=800, y=800)
    lost = bench.fault("packet_no_ack", "s4.network")
    run = made(rig, [phrase])
    carry_out(bench, run, lambda: bool(run._feed and run._feed._is_unsure))
    lost.clear()
    carry_out(bench, run)
    assert (run.state, pulses(bench)) == (RunState.ENDED, phrase.end)


def test_a_late_answer_does_not_end_a_stream(rig, fault):
    bench, _ = rig
    run = made(rig, [circle(at_zero())])
    carry_out(bench, run, lambda: run.progress(bench.now_ns).done_s > 1)
    bench.port("s5").write(b"q\r")  # a listing keeps the board for 0.4 s
    carry_out(bench, run)
    assert run.state is RunState.ENDED, run.why
    assert pulses(bench) == at_zero()


def test_a_port_that_vanishes_in_the_middle_is_told(rig):
    bench, master = rig
    run = made(rig, [circle(at_zero())])
    carry_out(bench, run, lambda: run.progress(bench.now_ns).done_s > 1)
    run.lose(bench.now_ns, "bus0.master has gone")
    assert run.state is RunState.FAILED
    assert run.why == "bus0.master has gone; axes may still move"
    x, y, z = run.report.axes
    assert "could not be stopped" in x.why
    assert (x.is_known, y.is_known, z.is_known) == (False, False, True)
    assert master.outstanding == []


def test_a_node_that_misses_the_release_begins_by_its_own(rig, fault):
    bench, _ = rig
    phrase = line(at_zero(), x=800, y=800)
    run = made(rig, [phrase])
    carry_out(bench, run, lambda: bool(run._feed and run._feed.is_released))
    bench.fault("wire_cut", "s5.network", for_s=0.001)
    carry_out(bench, run)
    assert run.state is RunState.ENDED
    assert pulses(bench) == phrase.end


def test_a_node_that_may_have_missed_both_releases_is_told(rig, fault):
    bench, _ = rig
    run = made(rig, [line(at_zero(), x=800, y=800)])
    carry_out(bench, run, lambda: bool(run._feed and run._feed.is_released))
    bench.fault("wire_cut", "s5.network")
    carry_out(bench, run)
    assert run.state is RunState.FAILED
    assert run.why == "node 5 (y), whether it has begun: y: not known (no answer to 3 tries)"
    assert [each.is_known for each in run.report.axes] == [False, False, True]


def test_an_answer_of_a_node_that_was_not_asked_stops_the_run(rig):
    bench, _ = rig
    run = made(rig, [line(at_zero(), x=8000)])
    carry_out(bench, run, lambda: run.progress(bench.now_ns).done_s > 0.5)
    bench.tap(TAP).write(encode(5, 1, b"m100"))  # as a packet whose address was changed by noise
    carry_out(bench, run)
    assert run.state is RunState.FAILED
    assert "not sent to it" in run.why
