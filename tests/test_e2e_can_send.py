"""``hil can send`` at a running bench: what goes on the bus, and what it says where nobody hears it."""

from collections.abc import Iterator

import pytest
from e2e_support import Place, Server, config, until

BUSES = {
    "can0": {"bit_rate": 1_000_000, "nodes": {"m1": 5}},
    "can1": {"bit_rate": 1_000_000, "taps": {"a": {}}},
}


@pytest.fixture(scope="module")
def place() -> Iterator[Place]:
    with Place() as place:
        yield place


@pytest.fixture(scope="module")
def server(place: Place) -> Server:
    return place.serve(config(speed=1, devices={"m1": {}}, can=BUSES), "--no-log")


def sent(place: Place, *words: str, code: int = 0) -> str:
    return place.cli("can", "send", *words, "--runtime-dir", str(place.runtime), code=code)


def test_frames_go_on_the_bus_and_the_node_goes(place: Place, server: Server) -> None:
    until(lambda: server.ask("buses")[0]["nodes"]["m1.canopen"]["state"] != "off", "the node")
    assert sent(place, "can0", "123#", "456#R4", "0000CAFE#0011") == "can0.hil sent 3 frames on can0\n"
    (can0, _) = server.ask("buses")
    assert (can0["nodes"]["can0.hil"]["sent"], can0["nodes"]["can0.hil"]["state"]) == (3, "off")
    assert sent(place, "can0", "123#00").startswith("can0.hil sent 1 frame on")


def test_a_bus_without_another_node_acknowledges_nothing(place: Place, server: Server) -> None:
    said = sent(place, "can1", "123#", code=1)
    assert "can1.hil has sent 0 of 1 frames; does another node on can1 acknowledge them?" in said
    assert "two digits for each" in sent(place, "can0", "123#0", code=2)
    assert "there are can0, can1" in sent(place, "can7", "123#", code=2)
