"""Pages in Firefox, over WebDriver BiDi, the W3C's protocol that Firefox itself speaks.

Playwright drives only a Firefox of its own build; this is the one that people have.
"""

import asyncio
import json
import re
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import aiohttp

PATIENCE_S = 40.0
"""A bound for what takes a second on an idle machine."""


class FirefoxPage:
    """One tab. ``errors``: exceptions in the page, and what it wrote as errors to its console."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse, loop: asyncio.AbstractEventLoop) -> None:
        self._socket, self._loop = socket, loop
        self._last_id = 0
        self.errors: list[str] = []
        self.ask("session.new", capabilities={})
        self.ask("session.subscribe", events=["log.entryAdded"])
        self._tab = self.ask("browsingContext.create", type="tab")["context"]

    def ask(self, method: str, **params: Any) -> Any:
        """Carry out a command of the protocol; return its result. Raises RuntimeError: Firefox refuses it."""
        return asyncio.run_coroutine_threadsafe(self._ask(method, params), self._loop).result()

    async def _ask(self, method: str, params: dict[str, Any]) -> Any:
        self._last_id += 1
        await self._socket.send_json({"id": self._last_id, "method": method, "params": params})
        async with asyncio.timeout(PATIENCE_S):
            while True:
                said = json.loads(await self._socket.receive_str())
                if said.get("method") == "log.entryAdded" and said["params"]["level"] == "error":
                    self.errors.append(said["params"]["text"])
                if said.get("id") == self._last_id:
                    if said["type"] == "error":
                        raise RuntimeError(f"{method}: {said['message']}")
                    return said["result"]

    def go(self, url: str) -> None:
        self.ask("browsingContext.navigate", context=self._tab, url=url, wait="complete")

    def evaluate(self, expression: str) -> Any:
        """Value of an expression in the page: a string, a number or a truth value."""
        where = {"context": self._tab}
        told = self.ask("script.evaluate", expression=expression, target=where, awaitPromise=True)
        if told["type"] == "exception":
            raise RuntimeError(told["exceptionDetails"]["text"])
        return told["result"].get("value")

    def until(self, expression: str) -> Any:
        """Wait until an expression in the page is true; return its value."""
        end_s = time.monotonic() + PATIENCE_S
        while not (value := self.evaluate(expression)):
            shown = "document.body.innerText"
            assert time.monotonic() < end_s, f"{expression}\n{self.errors}\n{self.evaluate(shown)}"
            time.sleep(0.05)
        return value

    def resize(self, width: int, height: int) -> None:
        size = {"width": width, "height": height}
        self.ask("browsingContext.setViewport", context=self._tab, viewport=size)


@contextmanager
def firefox_page(executable: str, folder: Path) -> Iterator[FirefoxPage]:
    """Start a Firefox with a profile in ``folder``, and open a tab."""
    log = folder / "firefox.log"
    command = [executable, "--headless", "--no-remote", "--profile", str(folder), "--remote-debugging-port=0"]
    with log.open("w") as file, subprocess.Popen(command, stdout=file, stderr=file) as process:
        try:
            address = _address(log)
            with _loop_of_its_own() as loop:

                async def connect() -> tuple[aiohttp.ClientSession, aiohttp.ClientWebSocketResponse]:
                    session = aiohttp.ClientSession()
                    return session, await session.ws_connect(f"{address}/session", max_msg_size=0)

                session, socket = asyncio.run_coroutine_threadsafe(connect(), loop).result()
                try:
                    yield FirefoxPage(socket, loop)
                finally:
                    asyncio.run_coroutine_threadsafe(session.close(), loop).result()
        finally:
            process.terminate()


@contextmanager
def _loop_of_its_own() -> Iterator[asyncio.AbstractEventLoop]:
    """An event loop in a thread: Playwright has one in this."""
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever)
    thread.start()
    try:
        yield loop
    finally:
        loop.call_soon_threadsafe(loop.stop)
        thread.join()
        loop.close()


def _address(log: Path) -> str:
    end_s = time.monotonic() + PATIENCE_S
    while not (found := re.search(r"WebDriver BiDi listening on (ws://\S+)", log.read_text())):
        assert time.monotonic() < end_s, log.read_text()
        time.sleep(0.05)
    return found[1]
