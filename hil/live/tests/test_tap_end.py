"""A tap's port that is held up asks for no time of its own when only its client can change that."""

import asyncio
from collections.abc import Iterator

import pytest
from session_bench import MemoryPort

from hil.live.lines import Lines
from hil.live.port_joint import BACKLOG_HOLD_BYTES, Joint
from hil.live.sim_ends import TapEnd
from hil.testing import Bench
from hil.vocab.time import FOREVER

CONFIG = {
    "bench": "x",
    "devices": {"s1": {"profile": "sac"}},
    "segments": {"bus0": {"stations": ["s1"], "taps": {"m": {"port": "memory"}}}},
}


@pytest.fixture
def joint() -> Iterator[Joint[TapEnd]]:
    loop = asyncio.new_event_loop()
    with Bench(CONFIG) as bench:
        bench.run(1100)
        joint = Joint[TapEnd]("bus0.m", MemoryPort())
        lines = Lines(loop, lambda: bench._runtime.now_ns)
        joint.occupy(TapEnd(bench._runtime, lines, joint, bench._runtime.taps["bus0.m"]))
        yield joint
        lines.close()
    loop.close()


def test_a_client_that_does_not_read_costs_no_timers(joint: Joint[TapEnd]) -> None:
    port = joint.port
    assert isinstance(port, MemoryPort)
    port.unread = BACKLOG_HOLD_BYTES + 1
    assert joint.room() == 0
    assert joint.end.release(joint.end._bench.now_ns) == FOREVER
    port.unread, port.resumed = 0, 0
    joint.drained()
    assert port.resumed == 1


def test_a_full_line_has_room_when_half_of_it_has_gone(joint: Joint[TapEnd]) -> None:
    while room := joint.room():
        joint.received(bytes(room))
    now_ns = joint.end._bench.now_ns
    assert now_ns < joint.end.release(now_ns) < FOREVER
