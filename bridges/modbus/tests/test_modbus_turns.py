"""Turns of clients: in each pass of the loop so many requests, one after the other of those who wait."""

import asyncio
from collections.abc import Awaitable, Callable

from served_door import READ, Door, packet, with_door

from bridges.modbus.turns import IN_A_PASS, Turns


class Asking:
    """Client that has so many requests. ``log``: who was answered, in turn; a point for each pass."""

    def __init__(self, turns: Turns, name: str, requests: int, log: list[str]) -> None:
        self._turns, self._name, self._requests, self._log = turns, name, requests, log

    def has_turn(self, most: int) -> None:
        while most and self._requests and self._turns.take():
            most -= 1
            self._requests -= 1
            self._log.append(self._name)
        if self._requests:
            self._turns.queue(self)


def on_loop(use: Callable[[Turns, list[str]], Awaitable[None]]) -> str:
    log: list[str] = []

    async def main() -> None:
        await use(Turns(), log)

    asyncio.run(main())
    return "".join(log)


async def passes(count: int, log: list[str]) -> None:
    for _ in range(count):
        await asyncio.sleep(0)
        log.append(".")


def test_a_pass_has_so_many_turns() -> None:
    async def use(turns: Turns, log: list[str]) -> None:
        for _ in range(3):
            log += ["x" for _ in range(IN_A_PASS + 3) if turns.take()]
            await passes(2, log)

    assert on_loop(use).replace(".", "") == "x" * IN_A_PASS * 3


def test_who_has_many_requests_has_the_turns_of_one() -> None:
    async def use(turns: Turns, log: list[str]) -> None:
        for name, requests in (("a", 100), ("b", 3), ("c", 3), ("d", 3), ("e", 3)):
            Asking(turns, name, requests, log).has_turn(IN_A_PASS)
        await passes(40, log)

    said = on_loop(use)
    assert max(map(len, said.split(".")[1:])) == IN_A_PASS
    assert said.replace(".", "").startswith("aaaa" + "abcde" * 3 + "aaaa")


def test_with_nobody_waiting_nothing_is_due() -> None:
    async def use(turns: Turns, log: list[str]) -> None:
        assert turns.take()
        await passes(3, log)
        assert not asyncio.get_running_loop()._ready  # type: ignore[attr-defined]

    on_loop(use)


def test_others_on_the_loop_go_on_while_a_client_asks_for_much() -> None:
    async def use(door: Door) -> None:
        client, passed = await door.client(), 0
        client.writer.write(packet(READ) * 400)
        while door.bridge.status()["requests"] < 400:
            before = door.bridge.status()["requests"]
            await asyncio.sleep(0)
            passed += 1
            assert door.bridge.status()["requests"] - before <= 2 * IN_A_PASS
        assert passed > 400 / IN_A_PASS / 2

    with_door(use)
