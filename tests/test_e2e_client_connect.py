"""The client at a door behind which its bench is, is not, or comes later."""

import asyncio
import socket
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from e2e_support import PATIENCE_S, Place, config

from hil.client import ClientError, connect, connect_sync


def free_door() -> str:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{listener.getsockname()[1]}"


def bench(name: str, **zenoh: object) -> str:
    return config(bench=name, bridges={"zenoh": zenoh})


def test_a_bench_that_is_not_there_is_named_at_once_with_those_that_are(place: Place) -> None:
    door = free_door()
    place.serve(bench("demo", listen=[door]), bench="demo")
    begun_s = time.monotonic()
    with pytest.raises(ClientError, match="there is no bench 'nobench' that you may see; there: demo"):
        connect_sync("nobench", door, timeout_s=0.5)

    async def use() -> None:
        async with connect("nobench", door, timeout_s=0.5):
            pass

    with pytest.raises(ClientError, match="there is no bench 'nobench' that you may see; there: demo"):
        asyncio.run(use())
    for name in ("*", "**", "", "a/b", "$*", "Demo"):
        with pytest.raises(ClientError, match="is no name of a bench"):
            connect_sync(name, door)
    with connect_sync("demo", door) as there:
        assert there.alive() == ["axis/m1", "daemon"]
    assert time.monotonic() - begun_s < PATIENCE_S


def test_one_whom_the_bench_does_not_know_learns_nothing(place: Place) -> None:
    door = free_door()
    users = place.folder / "users"
    users.write_text("anna:viewer:long-enough-for-a-secret\n")
    users.chmod(0o600)
    place.serve(bench("demo", listen=[door], users=str(users)), bench="demo")
    with connect_sync("demo", door, user="anna", password="long-enough-for-a-secret") as there:
        assert "daemon" in there.alive()
    with pytest.raises(ClientError, match="there is no bench 'nobench'"):
        connect_sync("nobench", door, user="anna", password="long-enough-for-a-secret", timeout_s=0.5)


def test_one_that_comes_to_the_router_later_is_waited_for(
    place: Place, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hil.client.link.AWAY_S", PATIENCE_S)  # a busy computer starts it in more than 1.5 s
    door = free_door()
    place.serve(bench("first", listen=[door]), bench="first")
    with ThreadPoolExecutor() as pool:
        coming = pool.submit(connect_sync, "second", door, timeout_s=PATIENCE_S)
        place.serve(bench("second", listen=[], connect=[door]), bench="second")
        with coming.result() as there:
            assert there.alive() == ["axis/m1", "daemon"]
