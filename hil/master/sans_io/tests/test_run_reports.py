"""Reports of runs are true: an axis whose place is known stands there, whatever went wrong on the line."""

import os

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from late_line import LateLine
from run_rig import AXES, TAP, at_zero, circle, line, pulses

from device_profiles.sac.line_nodes import NODES
from hil.master.sans_io.line_run import LineRun
from hil.master.sans_io.node_master import NodeMaster
from hil.master.sans_io.run_items import RunItem, RunState
from hil.testing.bench import Bench
from hil.testing.line_masters import attend
from hil.vocab.time import NS_PER_MS, NS_PER_S

EXAMPLES = int(os.environ.get("HIL_FUZZ", "1")) * 8
LATENCY_NS = 4 * NS_PER_MS
STATIONS = ("bus0.master", *(f"s{node}.network" for node in AXES.values()))


def bench_of_axes() -> Bench:
    names = {f"s{node}": node for node in AXES.values()}
    wire = {"stations": list(names), "taps": {"master": {"port": "memory"}}}
    bench = Bench(
        {
            "bench": "axes",
            "devices": {name: {"profile": "sac"} for name in names},
            "segments": {"bus0": wire},
        }
    )
    bench.run(ms=1100)
    for text in (b"$CM%d\r", b"$CL10\r", b"$R\r"):
        for name, node in names.items():
            bench.port(name).write(text % node if b"%" in text else text)
        bench.run(ms=60)
    bench.tap(TAP).read()
    return bench


def check(bench: Bench, run: LineRun) -> None:
    bench.run(ms=4000)
    where = pulses(bench)
    for each in run.report.axes:
        if each.is_known:
            assert each.pulses == where[each.axis], f"{each}, and it is at {where[each.axis]}; {run.report}"
        else:
            assert each.why
    if run.state is RunState.ENDED:
        assert all(each.is_known for each in run.report.axes)
    for axis, node in AXES.items():
        end = next(each for each in run.report.axes if each.axis == axis)
        if "not known" not in end.why and "could not be stopped" not in end.why:
            assert bench.axis(f"s{node}").snapshot().motion_state == 0, f"{axis} moves; {run.report}"


@settings(max_examples=EXAMPLES, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    kinds=st.lists(st.sampled_from(["line", "circle"]), min_size=1, max_size=3),
    fault=st.none() | st.sampled_from(["packet_no_ack", "packet_bad_crc", "wire_cut"]),
    station=st.sampled_from(STATIONS),
    start_s=st.sampled_from([0.0, 0.03, 0.2, 0.5, 1.0, 1.5]),
    for_s=st.sampled_from([0.001, 0.02, 0.3, 5.0]),
    rate=st.sampled_from([0.02, 0.3, 1.0]),
    delays_ms=st.lists(st.sampled_from([0, 0, 0, 2, 20, 300]), max_size=30),
    stop_s=st.none() | st.sampled_from([0.05, 0.4, 1.2]),
    how=st.sampled_from(["grace", "prejudice"]),
    vanish_s=st.none() | st.none() | st.sampled_from([0.02, 0.7]),
)
@example(["line"], "wire_cut", "bus0.master", 0.0, 0.001, 1.0, [], None, "grace", None)
@example(["line"], "wire_cut", "s5.network", 0.03, 0.3, 1.0, [], None, "grace", None)
def test_what_a_report_says_is_so(
    kinds: list[str],
    fault: str | None,
    station: str,
    start_s: float,
    for_s: float,
    rate: float,
    delays_ms: list[int],
    stop_s: float | None,
    how: str,
    vanish_s: float | None,
) -> None:
    with bench_of_axes() as bench:
        if fault == "wire_cut":
            bench.fault(fault, station, start_s=start_s, for_s=for_s)
        elif fault and fault.startswith("packet"):
            bench.fault(fault, station, start_s=start_s, for_s=for_s, rate=rate)
        items: list[RunItem] = []
        here = at_zero()
        for number, kind in enumerate(kinds):
            items.append(
                line(here, number, x=400, y=-300, z=50) if kind == "line" else circle(here, 200, 30, 0.04)
            )
            here = dict(items[-1].end)  # type: ignore[union-attr]
        master = NodeMaster(NODES, latency_ns=LATENCY_NS)
        run = LineRun(master, AXES, iter(items), brakes=dict.fromkeys(AXES, b"d60"))
        late = LateLine(run, iter(each * NS_PER_MS for each in delays_ms), iter(()))
        begun_ns = bench.now_ns
        run.start(begun_ns)

        def acts() -> bool:
            after_s = (bench.now_ns - begun_ns) / NS_PER_S
            if stop_s is not None and after_s > stop_s:
                run.stop(bench.now_ns, how)  # type: ignore[arg-type]
            if vanish_s is not None and after_s > vanish_s:
                run.lose(bench.now_ns, "the port has gone")
            return run.is_over

        attend(bench, {TAP: late}, acts)
        check(bench, run)


@pytest.mark.parametrize("seed", range(5))
def test_what_a_report_says_is_so_on_a_noisy_line(seed: int) -> None:
    with bench_of_axes() as bench:
        bench.fault("wire_noise", "bus0", rate=0.0005, seed=seed)
        phrase = circle(at_zero(), 200, 60, 0.05)
        run = LineRun(NodeMaster(NODES), AXES, iter([phrase]), brakes=dict.fromkeys(AXES, b"d60"))
        run.start(bench.now_ns)
        attend(bench, {TAP: run}, lambda: run.is_over)
        check(bench, run)
