"""A packet to everybody that a SAC takes beside its main loop does what it would have done there."""

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from device_profiles.sac.command_line import CommandLine
from device_profiles.sac.packet import encode
from hil.testing import Bench

NODES = ("s1", "s2", "s3")
CONFIG: dict[str, Any] = {
    "bench": "t",
    "devices": {name: {"profile": "sac"} for name in NODES},
    "segments": {"bus0": {"stations": list(NODES), "taps": {"m": {"port": "memory"}}}},
}
QUICK = [b"v150", b"v90", b"vc4000", b"vd", b"m200", b"m", b"S", b"s", b"n", b"N", b"y", b"zz", b"l2", b"a40"]
SLOW = [
    b"",
    b"?",
    b"x1",
    b"q",
    b"$ss",
    b"cc",
    b"b",
    b"+",
    b"-",
    b" text",
    b".t",
    b"\6",
    b"\x15",
    b"\x11",
    b"m13",
]
DATA = st.sampled_from(QUICK + SLOW)
ACTS = st.one_of(
    st.tuples(st.just("all"), DATA, st.booleans(), st.booleans()),
    st.tuples(st.just("one"), DATA, st.booleans(), st.booleans()),
    st.tuples(
        st.just("type"),
        st.sampled_from([b"0v99\r", b"v77\r", b"cf\r", b"q\r", b"m", b"\r", b"85y\r"]),
        st.none(),
        st.none(),
    ),
    st.tuples(st.just("raw"), st.binary(max_size=5), st.none(), st.none()),
)


def played(acts: list[tuple[str, bytes, Any, Any]], takes: bool) -> tuple[object, ...]:
    """Play the acts, and return what the boards have sent and when, their states, and how many turns they
    had."""
    with pytest.MonkeyPatch.context() as patch:
        if not takes:
            patch.setattr(CommandLine, "takes", None)
        bench = Bench(CONFIG)
        bench.run(1100)
        for kind, data, has_crc, is_close in acts:
            if kind == "type":
                bench.port("s2").write(data)
            elif kind == "raw":
                bench.tap("bus0.m").write(data)
            else:
                bench.tap("bus0.m").write(encode(0 if kind == "all" else 85, 1, data, crc=has_crc))
            bench.run(1.5 if is_close else 7)
        bench.run(50)
        devices = bench._runtime.devices
        return (
            [bench.port(name, uart).timeline for name in NODES for uart in ("main", "network")],
            [bench.axis(name).snapshot() for name in NODES],
            [devices[name]._sketch.turns for name in NODES],
            [devices[name]._sketch.runtime.due_ns for name in NODES],
            bench.segment("bus0").counters(1),
        )


@settings(max_examples=60, deadline=None)
@given(st.lists(ACTS, min_size=1, max_size=8))
def test_what_is_taken_is_done_as_in_the_main_loop(acts: list[tuple[str, bytes, Any, Any]]) -> None:
    assert played(acts, True) == played(acts, False)


def test_a_velocity_to_all_is_taken_and_a_text_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    answers: list[bool] = []
    takes = CommandLine.takes

    def noted(self: CommandLine, packets: Any) -> bool:
        answers.append(takes(self, packets))
        return answers[-1]

    monkeypatch.setattr(CommandLine, "takes", noted)
    bench = Bench(CONFIG)
    bench.run(1100)
    bench.tap("bus0.m").write(encode(0, 1, b"y"))
    bench.run(100)  # the first packet finds that the prompt is out
    for data, expected in ((b"v150", True), (b" hi", False), (b"$ss", False), (b"zz", True)):
        answers.clear()
        bench.tap("bus0.m").write(encode(0, 1, data))
        bench.run(100)
        assert answers == [expected] * len(NODES)
    answers.clear()
    bench.tap("bus0.m").write(encode(85, 1, b"v150"))
    bench.run(10)
    assert answers == [], "what is for one is answered, which takes time"
