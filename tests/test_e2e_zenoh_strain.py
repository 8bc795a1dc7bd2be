"""The zenoh bridge with clients that hang, flood and leave, and what else goes wrong between them."""

import json
import os
import struct
import threading
import time
from collections.abc import Iterator
from itertools import pairwise

import pytest
from e2e_support import Place, config, free_port, until
from plain_zenoh import NONE, Bench, Plain, session, zenoh_bench

from hil.client import ClientError, connect_sync


@pytest.fixture(scope="module")
def bench() -> Iterator[Bench]:
    with zenoh_bench() as made:
        yield made


def test_nobody_there_says_so() -> None:
    with pytest.raises(ClientError, match="no router and no bench listens there"):
        connect_sync("t", f"tcp/127.0.0.1:{free_port()}", timeout_s=0.5)


def test_queries_that_are_abandoned_leave_nothing(bench: Bench) -> None:
    def threads_after(clients: int) -> int:
        for _ in range(clients):
            hasty = Plain(bench.port)
            for _ in range(20):
                hasty.session.get(
                    "hil/t/axis/s1/cmd/move_rel?done=true", payload='{"angle_deg": 1.8}', timeout=10
                )
            hasty.session.close()
        until(lambda: bench.bridge()["links"] <= 1, "the links to be gone")
        assert bench.plain.one("axis/m1/state")["at_ns"] > 0
        return len(os.listdir(f"/proc/{bench.server.pid}/task"))

    before = threads_after(5)  # zenoh starts some of its threads when it first has work for them
    assert threads_after(5) <= before + 2


def test_a_subscriber_that_never_reads_costs_nobody_else(bench: Bench) -> None:
    stuck = Plain(bench.port)
    gate = threading.Event()
    subscriber = stuck.session.declare_subscriber("hil/t/**", lambda sample: gate.wait())
    try:
        before = bench.bridge()["dropped"]
        heard, mine = bench.plain.listen("axis/m1/state/packed")
        with mine:
            until(lambda: len(heard) > 2000, "states while another one does not read")
        times = [struct.unpack_from("<q", sample.payload.to_bytes())[0] for sample in heard]
        steps_ms = [(b - a) / 1e6 for a, b in pairwise(times)]
        assert all(step_ms >= 1 and step_ms.is_integer() for step_ms in steps_ms)
        missing = sum(steps_ms) - len(steps_ms)  # a daemon that a busy computer kept waiting counts them
        until(lambda: bench.bridge()["dropped"] - before >= missing, "all that are missing to be counted")
        assert bench.plain.one("axis/m1/state")["at_ns"] > 0
    finally:
        gate.set()
        subscriber.undeclare()
        stuck.session.close()


def test_who_does_not_read_answers_holds_nobody_up(bench: Bench) -> None:
    lazy = Plain(bench.port)
    unread = [lazy.session.get("hil/t/**", timeout=60, consolidation=NONE) for _ in range(60)]
    longest_s = 0.0
    with bench.server.client("m1") as terminal:
        for _ in range(20):
            began_s = time.monotonic()
            terminal.ask(b"p")
            assert bench.plain.one("sim/clock")["sim_ns"] > 0
            longest_s = max(longest_s, time.monotonic() - began_s)
    assert longest_s < 5  # it was 12 where the event loop answered
    assert len(unread) == 60
    lazy.session.close()  # type: ignore[no-untyped-call]


def test_of_too_many_that_wait_the_oldest_gives_way(bench: Bench) -> None:
    bench.plain.one("axis/m1/cmd/enable")
    asker = Plain(bench.port)
    far = '{"position_deg": 1e6, "velocity_rpm": 0.001}'
    asked = [
        asker.session.get("hil/t/axis/m1/cmd/move_abs?done=true", payload=far, timeout=60, consolidation=NONE)
        for _ in range(1050)
    ]
    refusals = [[reply.err for reply in replies if reply.err] for replies in asked[:50]]
    assert [json.loads(err.payload.to_bytes())["code"] for (err,) in refusals] == ["not_now"] * 50
    waiting = bench.server.ask("status")["bridges"]["zenoh"]["waiting"]
    assert waiting == 1000
    asker.session.close()  # type: ignore[no-untyped-call]
    bench.plain.one("axis/m1/cmd/stop", '{"how": "prejudice"}')
    replies = bench.plain.get("axis/s1/cmd/move_rel?done=true", '{"angle_deg": 1.8}')
    assert [reply.get("done", False) for reply in replies] == [False, True]


def test_a_flood_leaves_the_others_their_turn(bench: Bench) -> None:
    flooder = Plain(bench.port)
    publisher = flooder.session.declare_publisher("hil/t/axis/m1/cmd/gains")
    for _ in range(30_000):
        publisher.put("{}")
    with bench.server.client("m1") as terminal:
        assert b"Angle" in terminal.ask(b"p")
    assert bench.plain.one("sim/clock")["sim_ns"] > 0
    flooder.session.close()  # type: ignore[no-untyped-call]


@pytest.mark.thorough
def test_a_router_that_dies_and_returns(place: Place) -> None:
    port = free_port()
    bridge = {"listen": [], "connect": [f"tcp/127.0.0.1:{port}"]}
    place.serve(config(speed=1, bridges={"zenoh": bridge})).ready()
    for _ in range(2):
        router = session(mode="router", listen__endpoints=[f"tcp/127.0.0.1:{port}"])
        try:
            with connect_sync("t", f"tcp/127.0.0.1:{port}") as client:
                until(lambda client=client: "daemon" in client.alive(), "the daemon behind the router")  # type: ignore[misc]
                assert client.axis("m1").enable().effective_at_ns
        finally:
            router.close()  # type: ignore[no-untyped-call]


def test_a_port_that_is_taken_is_said(place: Place, bench: Bench) -> None:
    said = place.launch(
        config(bench="u", bridges={"zenoh": {"listen": [bench.endpoint]}}), bench="u"
    ).refused()
    assert "bridges.zenoh.listen.0: 127.0.0.1:" in said
    assert "is in use by hil (process " in said
    assert "choose another port" in said
