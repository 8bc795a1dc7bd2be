"""Boards whose commits are answered while the bench is put away."""

import asyncio
from pathlib import Path

from hil.compose import bench_runtime, find_catalogue
from hil.compose.replay import MemoryOptions, replay
from hil.config import from_dict
from hil.live.memory_commits import Commits
from hil.live.store import NvmStore
from hil.sim.bench import BenchHooks
from hil.sim.input_log import InputLogWriter
from hil.sim.inputs import Bytes
from hil.sim.twin import Twin
from hil.vocab.time import SimTimeNs

CONFIG = {"bench": "t", "devices": {"s0": {"profile": "sac"}}}
READY_NS = SimTimeNs(1_500_000_000)
STEP_NS = 1_000_000


def test_a_board_that_stores_again_and_again_is_not_stopped_by_the_end(tmp_path: Path) -> None:
    log = tmp_path / "log"
    device = asyncio.run(put_away_in_a_commit(tmp_path, log))
    assert device.failed is None
    assert device.is_committing  # the next one, which nobody answers any more
    replayed = replay(log)
    assert replayed.difference() is None
    assert [path.name for path in tmp_path.glob("*.nvm*")] == ["s0.nvm"]


async def put_away_in_a_commit(folder: Path, log: Path) -> Twin:
    """A SAC whose answer to one commit makes it begin the next at once, after the end has begun."""
    files, memories = NvmStore(folder), {"s0": dict[str, bytes]()}
    store = Commits(files, asyncio.get_running_loop())
    catalogue = find_catalogue({"memory": MemoryOptions})
    config = from_dict(CONFIG, catalogue)
    dumped = config.model_dump(mode="json", by_alias=True)
    dumped["devices"]["s0"] |= {"port": "memory", "network": None}
    with log.open("w") as file:
        around = BenchHooks(log=InputLogWriter(file, "hil test", dumped, memories))
        bench = bench_runtime(config, catalogue, memories, store, around)
        device = bench.devices["s0"]
        bench.advance(READY_NS)
        bench.apply_to(device, Bytes(b"qs\ry" * 400))
        while not device.is_committing:
            bench.advance(SimTimeNs(bench.now_ns + STEP_NS))
        await store.end()
        while_ending = bench.now_ns
        while not device.is_committing:
            bench.advance(SimTimeNs(bench.now_ns + STEP_NS))
            assert bench.now_ns < while_ending + 10 * READY_NS
    return device
