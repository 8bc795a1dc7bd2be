"""A process with the core's thread, a board in closed loop, and a busy asyncio loop. Says when it is ready,
waits for a line, runs, and prints the thread's stats.

Arguments: CPU, rate in Hz, seconds, and what happens in the middle: none, gil (held for a second), gc (of a
million objects) or hung (a callback that takes a second)."""

import asyncio
import ctypes
import gc
import json
import sys
import time

from hil.compose import bench_runtime, find_catalogue, start_memories
from hil.config import from_dict
from hil.testing.memory_store import MemoryStore

CONFIG = {"bench": "b", "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}}}


def hold_gil() -> None:
    ctypes.PyDLL(None).usleep(1_000_000)  # PyDLL keeps the GIL during the call


def collect() -> None:
    objects = [[i] for i in range(1_000_000)]
    gc.collect()
    del objects


def hang() -> None:
    end = time.monotonic() + 1
    while time.monotonic() < end:
        pass


DISTURBANCES = {"none": lambda: None, "gil": hold_gil, "gc": collect, "hung": hang}


async def busy(seconds: float, disturbance: str) -> None:
    """Callbacks without a pause, and the disturbance in the middle."""
    loop = asyncio.get_running_loop()
    end = loop.time() + seconds
    loop.call_later(seconds / 3, DISTURBANCES[disturbance])
    while loop.time() < end:
        json.dumps(list(range(500)))
        await asyncio.sleep(0)


def main() -> None:
    """Prints ``rt_stats`` as JSON."""
    cpu, rate_hz, seconds = int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])
    catalogue = find_catalogue()
    config = from_dict(CONFIG, catalogue)
    memories = start_memories(config, catalogue)
    bench = bench_runtime(config, catalogue, memories, MemoryStore())
    device = bench.devices["m1"]
    device.axis.set("mode", ord("x"))
    device.axis.loop(True)
    gc.collect()
    gc.freeze()
    print("ready", flush=True)
    sys.stdin.readline()
    bench.real_time.start(1_000_000_000 // rate_hz, 1.0, 80, cpu)
    asyncio.run(busy(seconds, sys.argv[4]))
    stats = bench.core.native.rt_stats()
    bench.stop()
    if stats["fifo_errno"] or stats["pin_errno"]:
        sys.exit("no real-time priority or CPU here: `hil doctor` says why")
    print(json.dumps(stats))


if __name__ == "__main__":
    main()
