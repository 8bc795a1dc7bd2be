"""Desk of a daemon, for the tests of it."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from inspect import isawaitable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from hil.compose.find import find_catalogue
from hil.config import parse
from hil.daemon import Daemon, Serving
from hil.vocab.desk_protocol import Desk, Done, Encoded, Source
from hil.vocab.verbs import Role, VerbRefused

CONFIG = json.dumps(
    {
        "bench": "h",
        "speed": 20,
        "devices": {
            "m1": {"profile": "mechaduino", "flash": {"table": "identity"}, "setpoints": {"timeout_ms": 50}},
            "s1": {"profile": "sac"},
            "s10": {"profile": "sac"},
            "real": {"profile": "mechaduino", "at": "/dev/null/nothing"},
        },
        "segments": {"bus0": {"stations": ["s1", "s10"], "taps": {"t": {"port": "pty"}}}},
    }
)
ADMIN, OPERATOR = Source("the tests", Role.ADMIN), Source("a hand", Role.OPERATOR)
VIEWER = Source("a guest", Role.VIEWER)


class Asking(NamedTuple):
    """A desk that is asked for something and waited for."""

    desk: Desk
    serving: Serving

    async def __call__(self, operation: str, target: str = "", source: Source = ADMIN, **given: Any) -> Any:
        answer = self.desk.ask(source, operation, target, given)
        answer = await answer if isawaitable(answer) else answer
        return json.loads(b"".join(answer.parts)) if isinstance(answer, Encoded) else answer

    async def verb(self, device: str, name: str, source: Source = ADMIN, **parameters: Any) -> Done:
        done: Done = await self("do", device, source, name=name, parameters=parameters)
        return done

    async def wait(self, device: str, done: Done, at_most_s: float) -> bool:
        """Return whether what was begun was ended by something else."""
        given = {name: done.answer[name] for name in ("ends_after_ns", "set_point") if name in done.answer}
        at_ns = done.effective_at_ns
        ended = await self("wait", device, effective_at_ns=at_ns, at_most_s=at_most_s, **given)
        return bool(ended["interrupted"])

    async def until_ready(self, device: str, at_ns: int = 4_500_000_000) -> None:
        for _ in range(3000):
            if (await self("state", device))["at_ns"] > at_ns:
                return
            await asyncio.sleep(0.01)
        raise AssertionError("simulated time does not go on")


Using = Callable[[Callable[[Asking], Awaitable[None]]], None]


def desk_in(folder: Path, config_text: str = CONFIG, config_file: Path | None = None) -> Using:
    """Call that runs what is awaited with the desk of a daemon, below a folder, that has started.
    ``config_file``: what a reload reads."""

    def run(use: Callable[[Asking], Awaitable[None]]) -> None:
        async def main() -> None:
            config = parse(config_text, "h.yaml", find_catalogue())
            daemon = Daemon(
                config,
                config_folder=folder,
                config_file=config_file,
                runtime_base=folder / "run",
                state_base=folder / "state",
            )
            started: asyncio.Future[Serving] = asyncio.get_running_loop().create_future()
            running = asyncio.create_task(daemon.run(started.set_result))
            await asyncio.wait({running, started}, return_when=asyncio.FIRST_COMPLETED, timeout=30)
            try:
                assert started.done()
                serving = started.result()
                await use(Asking(serving.desk, serving))
            finally:
                daemon.stop()
                await running

        asyncio.run(main())

    return run


async def refusal(asking: Awaitable[Any]) -> tuple[str, str]:
    with pytest.raises(VerbRefused) as refused:
        await asking
    return refused.value.code, str(refused.value)
