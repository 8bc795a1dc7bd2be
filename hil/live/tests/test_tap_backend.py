"""A tap's port that is held up asks for no time of its own when only its client can change that."""

import asyncio
from collections.abc import Iterator

import pytest
from session_bench import MemoryPort

from hil.live.lines import PacedLines
from hil.live.port_link import BACKLOG_HOLD_BYTES, PortLink
from hil.live.sim_backends import TapBackend
from hil.testing import Bench
from hil.vocab.time import FOREVER

CONFIG = {
    "bench": "x",
    "devices": {"s1": {"profile": "sac"}},
    "segments": {"bus0": {"stations": ["s1"], "taps": {"m": {"port": "memory"}}}},
}


@pytest.fixture
def link() -> Iterator[PortLink[TapBackend]]:
    loop = asyncio.new_event_loop()
    with Bench(CONFIG) as bench:
        bench.run(1100)
        link = PortLink[TapBackend]("bus0.m", MemoryPort())
        lines = PacedLines(loop, lambda: bench._runtime.now_ns)
        link.occupy(TapBackend(bench._runtime, lines, link, bench._runtime.taps["bus0.m"]))
        yield link
        lines.close()
    loop.close()


def test_a_client_that_does_not_read_costs_no_timers(link: PortLink[TapBackend]) -> None:
    port = link.port
    assert isinstance(port, MemoryPort)
    port.unread = BACKLOG_HOLD_BYTES + 1
    assert link.room() == 0
    assert link.backend.release(link.backend._bench.now_ns) == FOREVER
    port.unread, port.resumed = 0, 0
    link.drained()
    assert port.resumed == 1


def test_a_full_line_has_room_when_half_of_it_has_gone(link: PortLink[TapBackend]) -> None:
    while room := link.room():
        link.received(bytes(room))
    now_ns = link.backend._bench.now_ns
    assert now_ns < link.backend.release(now_ns) < FOREVER
