"""Turns of clients: in each pass of the loop so many requests, one after the other of those who wait."""

import asyncio
from collections.abc import Awaitable, Callable

import pytest
from served_door import READ, Door, packet, with_door
from simulated_loop import Simulated

from hil.net.fair_share import BURST_S, IN_A_PASS, SHARE, FairShare


class Asking:
    """Client that has so many requests. ``log``: who was answered, in turn; a point for each pass."""

    def __init__(self, turns: FairShare, name: str, requests: int, log: list[str], took_s: float = 0) -> None:
        self._turns, self._name, self._requests, self._log = turns, name, requests, log
        self._took_s = took_s

    def has_turn(self, most: int) -> None:
        if self._requests:
            self._turns.note(self, self._took_s)
        while most and self._requests and self._turns.spend():
            most -= 1
            self._requests -= 1
            self._log.append(self._name)
        if self._requests:
            self._turns.queue(self)


def in_simulated_time(use: Callable[[FairShare, list[str]], Awaitable[None]]) -> str:
    log: list[str] = []

    async def main() -> None:
        await use(FairShare(), log)

    with asyncio.Runner(loop_factory=Simulated) as runner:
        runner.run(main())
    return "".join(log)


def on_loop(use: Callable[[FairShare, list[str]], Awaitable[None]]) -> str:
    log: list[str] = []

    async def main() -> None:
        await use(FairShare(), log)

    asyncio.run(main())
    return "".join(log)


async def passes(count: int, log: list[str]) -> None:
    for _ in range(count):
        await asyncio.sleep(0)
        log.append(".")


def test_a_pass_has_so_many_turns() -> None:
    async def use(turns: FairShare, log: list[str]) -> None:
        for _ in range(3):
            log += ["x" for _ in range(IN_A_PASS + 3) if turns.spend()]
            await passes(2, log)

    assert on_loop(use).replace(".", "") == "x" * IN_A_PASS * 3


def test_who_has_many_requests_has_the_turns_of_one() -> None:
    async def use(turns: FairShare, log: list[str]) -> None:
        for name, requests in (("a", 100), ("b", 3), ("c", 3), ("d", 3), ("e", 3)):
            Asking(turns, name, requests, log).has_turn(IN_A_PASS)
        await passes(40, log)

    said = on_loop(use)
    assert max(map(len, said.split(".")[1:])) == IN_A_PASS
    assert said.replace(".", "").startswith("aaaa" + "abcde" * 3 + "aaaa")


def test_with_nobody_waiting_nothing_is_due() -> None:
    async def use(turns: FairShare, log: list[str]) -> None:
        assert turns.spend()
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


def test_several_clients_have_their_share_of_the_time_and_no_more() -> None:
    async def use(turns: FairShare, log: list[str]) -> None:
        for name in "abcd":
            Asking(turns, name, 10_000, log, took_s=50e-6).has_turn(1)
        await asyncio.sleep(1)

    answered = len(in_simulated_time(use))
    assert answered * 50e-6 == pytest.approx(SHARE, abs=2 * BURST_S)


def test_one_client_alone_has_all_that_it_asks_for() -> None:
    async def use(turns: FairShare, log: list[str]) -> None:
        Asking(turns, "a", 10_000, log, took_s=50e-6).has_turn(1)
        await passes(10_000 // IN_A_PASS + 10, log)

    assert in_simulated_time(use).count("a") == 10_000
