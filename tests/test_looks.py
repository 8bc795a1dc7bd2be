"""Looking changes nothing: a bench that is looked at, at odd times, sends the same at the same times."""

from types import SimpleNamespace
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from device_profiles.sac.packet import encode
from hil.discovery.named_kinds import find_wire_infos
from hil.live.places import Places
from hil.live.port_link import PortLink
from hil.live.sim_backends import TapBackend
from hil.operations.metrics import metric_rows
from hil.operations.wire_reports import listed_wires
from hil.testing import Bench
from hil.vocab.time import SimTimeNs

STATIONS = ("s1", "s2", "s3", "s4")
CONFIG = {
    "bench": "looks",
    "devices": {name: {"profile": "sac"} for name in STATIONS},
    "segments": {"bus0": {"stations": list(STATIONS), "taps": {"m": {"port": "memory"}}}},
    "faults": [
        {"fault": "node_babble", "target": "s1.network", "bytes": 3, "every_ms": 11},
        {"fault": "node_babble", "target": "s2.network", "bytes": 3, "every_ms": 13},
    ],
}
PACKETS = st.lists(st.tuples(st.integers(0, 60_000), st.sampled_from([b"v150", b"y", b"m20ad"])), max_size=8)
LOOKS = st.lists(st.integers(0, 60_000), max_size=40)


def look(bench: Bench) -> None:
    """Look at a bench as the daemon does, while the group is 2 ms behind the wall's time."""
    runtime = bench._runtime
    ahead = SimpleNamespace(
        now_ns=bench.now_ns + 2_000_000, wires_of=runtime.wires_of, cards_on=runtime.cards_on
    )
    sim: Any = ahead
    listed_wires(sim, Places(), "segments")
    scrape: Any = SimpleNamespace(of=SimpleNamespace(sim=sim))
    for row in metric_rows(find_wire_infos()):
        if row.metric.labels[:1] == ("segment",):
            list(row.read(scrape))
    wire = bench.segment("bus0")
    wire.counters(bench.now_ns)
    wire.clashes()
    for name in STATIONS:
        bench.axis(name).snapshot()
        runtime.snapshot(name)
        wire.baud_of(f"{name}.network")


def run(packets: Any, looks: Any) -> list[Any]:
    """Run packets and looks, in microseconds after the cold start, and return what stations and tap heard and
    sent."""
    with Bench(CONFIG) as bench:
        shown: list[Any] = []
        bench.segment("bus0").watchers.append(shown.append)
        bench.run(1100)
        if looks:
            bench.axis("s3").record("position_deg", interval_ms=0.7)
        events = [(at_us, 1, data) for at_us, data in packets] + [(at_us, 0, b"") for at_us in looks]
        for at_us, is_packet, data in sorted(events):
            bench.run_until(1100 + at_us / 1000)
            if is_packet:
                bench.tap("bus0.m").write(encode(85, 1, data))
            else:
                look(bench)
        bench.run_until(1250)
        told = [bench.port(name, uart).timeline for name in STATIONS for uart in ("main", "network")]
        told += [bench.tap("bus0.m").read_timed(), shown]
        return [*told, bench.segment("bus0").counters(1), *(bench.axis(name).snapshot() for name in STATIONS)]


@settings(max_examples=15)
@given(PACKETS, LOOKS)
def test_what_is_looked_at_goes_on_as_if_nobody_had(packets: Any, looks: Any) -> None:
    assert run(packets, looks) == run(packets, [])


def test_a_burst_is_counted_and_shown_at_its_end_on_a_line_that_is_quiet_otherwise() -> None:
    with Bench({**CONFIG, "faults": []}) as bench:
        shown: list[Any] = []
        bench.segment("bus0").watchers.append(shown.append)
        bench.run(1100)
        bench.tap("bus0.m").write(encode(99, 1, b"y"))
        bench.run(1.8)
        assert (bench.segment("bus0").counters(1)["packets"], shown) == (0, [])
        bench.run(0.03)  # 7 characters take 1.823 ms
        assert (bench.segment("bus0").counters(1)["packets"], len(shown)) == (1, 1)


def test_a_taps_client_gets_nothing_that_can_still_be_taken_back() -> None:
    """Look while the wall's time is ahead of the group's: in between somebody may still send."""
    segment = {"stations": ["s1"], "taps": {"m": {"port": "memory"}, "n": {"port": "memory"}}}
    with Bench({"bench": "x", "devices": {"s1": {"profile": "sac"}}, "segments": {"bus0": segment}}) as bench:
        got = bytearray()
        port: Any = SimpleNamespace(write=got.extend, client_baud=lambda: None)
        lines: Any = SimpleNamespace(has_sent=lambda line: None)
        session = TapBackend(bench._runtime, lines, PortLink("bus0.n", port), bench._runtime.taps["bus0.n"])
        bench.run(1100)
        packet = encode(99, 1, b"y")
        bench.tap("bus0.m").write(packet)
        wall_ns = SimTimeNs(bench.now_ns + 1_500_000)
        assert session.release(wall_ns) <= wall_ns
        assert got == b""
        bench.run(1.5)
        assert session.release(wall_ns) > wall_ns
        assert got == packet[:5]
