"""Logs of daemons that were killed: a replay compares what is certain, and says that the log was cut."""

import os
import threading
from contextlib import suppress
from pathlib import Path
from random import Random

import pytest
from e2e_support import Client, Place, Server, config, until

from hil.net.control_client import ControlError
from hil.sim.log_reading import KILLED

KILLS = int(os.environ.get("HIL_KILLS", "3"))
DEVICES = {
    "u1": {"profile": "uno", "flash": {}},
    "s1": {"profile": "sac", "flash": {}},
    "m1": {},
}
ASKS = {"u1": b"?\r\n", "s1": b"vd\r", "m1": b"p"}


@pytest.fixture
def typed_at(place: Place) -> tuple[Server, Path]:
    """A bench with a log whose boards were asked a lot, and have answered some."""
    log = place.folder / "run.log"
    server = place.serve(config(speed=1, devices=DEVICES), "--log", str(log)).ready()
    for name in DEVICES:
        with server.client(name) as client:
            client.write(ASKS[name])
            until(lambda client=client: client.quiet(0), f"an answer of {name}")
    return server, log


def type_for(server: Server, seconds: float) -> None:
    """Type at all boards, and read what comes, for so long."""
    clients = {name: server.client(name) for name in DEVICES}
    over = threading.Event()
    timer = threading.Timer(seconds, over.set)
    timer.start()

    def keep_on(name: str, client: Client) -> None:
        while not over.wait(0.002):
            with suppress(OSError):
                client.write_until_full(ASKS[name])
                client.quiet(0)

    threads = [threading.Thread(target=keep_on, args=each) for each in clients.items()]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for client in clients.values():
        client.close()


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(each, marks=pytest.mark.thorough) for each in range(1, KILLS))]
)
def test_a_killed_daemons_log_is_cut_and_not_different(
    place: Place, typed_at: tuple[Server, Path], seed: int
) -> None:
    server, log = typed_at
    type_for(server, Random(seed).uniform(0.2, 0.8))
    server.kill()
    assert KILLED in place.cli("replay", str(log))
    assert '"is_cut": true' in place.cli("replay", str(log), "--json")


def test_a_kill_in_a_reload(place: Place, typed_at: tuple[Server, Path]) -> None:
    server, log = typed_at

    def reload() -> None:
        with suppress(ControlError):
            server.ask("reload")

    thread = threading.Thread(target=reload)
    thread.start()
    server.kill()
    thread.join()
    assert KILLED in place.cli("replay", str(log))


def test_an_orderly_stop_ends_the_log(place: Place, typed_at: tuple[Server, Path]) -> None:
    server, log = typed_at
    server.stop()
    last = log.read_text().splitlines()[-1]
    assert last.startswith('{"end":true,"why":"stopped","at_ns":')
    said = place.cli("replay", str(log))
    assert said.startswith("identical: ")
    assert "where the log ends" not in said
