"""Output of a board: it goes to its client at once, whatever made the board send it."""

from e2e_support import Client, Place, Server, config, until

SAC = {"profile": "sac", "flash": {}}
BUS = {"bus0": {"stations": ["s1", "s2"], "taps": {"master": {"port": "tcp"}, "spy": {"port": "tcp"}}}}


def started(place: Place) -> Server:
    server = place.serve(config(speed=5, devices={"s1": SAC, "s2": SAC}, segments=BUS))
    until(lambda: server.ask("status")["sim_ns"] > 1_500_000_000, "the cold start")
    return server


def tap(server: Server, name: str) -> Client:
    return Client(next(row["port"] for row in server.ask("list")["taps"] if row["tap"] == name))


def test_a_board_that_hung_answers_when_its_fault_is_cleared(place: Place) -> None:
    server = started(place)
    with server.client("s1") as client:
        client.quiet(0.1)
        hang = server.ask("inject", fault="node_hang", target="s1", parameters={})["number"]
        client.write(b"vd\r")
        until(lambda: server.status("s1")["rx_bytes"] == 3, "the question")
        assert client.quiet(0.2) == b""
        server.ask("clear", number=hang)
        client.read_until(b"SAC>")


def test_bursts_that_are_played_are_heard_at_the_other_tap(place: Place) -> None:
    server = started(place)
    with tap(server, "bus0.spy") as spy:
        server.ask("play", tap="bus0.master", bursts=[[0, b"free".hex()]])
        assert spy.read_exactly(4) == b"free"
