"""Door with sockets, in a thread of its own, at a bench in memory that goes as far as it is told."""

import asyncio
import threading
from collections.abc import Mapping
from typing import Any

from bridges.modbus.door.door_options import Options
from bridges.modbus.door.modbus_bridge import ModbusBridge
from hil.compose import find_catalogue
from hil.memory_desk.desk_in_memory import memory_desk
from hil.testing import Bench

SETTLE_S = 0.02
"""Time in which the door has looked whether motions have ended."""


class ServedBeside:
    def __init__(self, config: Mapping[str, Any]) -> None:
        self.bench = Bench(config)
        self.bench.start()
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever)
        self._thread.start()
        self._bridge = self._done(self._open())
        self.port = int(self._bridge.status()["listen"][0].rpartition(":")[2])

    def _done(self, work: Any) -> Any:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(60)

    async def _open(self) -> ModbusBridge:
        at = await memory_desk(self.bench.runtime, self.bench.config, find_catalogue())
        given: Any = self.bench.config.bridges["modbus"]
        bridge = ModbusBridge(Options(**{**given.model_dump(), "listen": "127.0.0.1:0"}), at.desk)
        await bridge.open()
        return bridge

    def run_to(self, at_ns: int) -> None:
        async def go() -> None:
            self.bench.run_until(at_ns / 1e6)

        self._done(go())

    def settle(self) -> None:
        self._done(asyncio.sleep(SETTLE_S))

    def close(self) -> None:
        self._done(self._bridge.close())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()
        self.bench.close()
