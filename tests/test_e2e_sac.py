"""A SAC behind a pseudo-terminal: a session as its user has it, and what survives the daemon."""

from e2e_support import SAC_READY_NS, Place, Server, config

SAC = {"s1": {"profile": "sac", "flash": {}}}


def started(place: Place, text: str) -> Server:
    """A daemon whose SAC's second of start-up is over: a byte in it would restore the factory's settings."""
    return place.serve(text).started().ready("s1", boot_ns=SAC_READY_NS)


def test_a_session_and_what_survives_it(place: Place) -> None:
    text = config(speed=5, devices=SAC)
    server = started(place, text)
    with server.client("s1") as client:
        client.ask(b"\r", b"SAC>")
        assert client.ask(b"m400v150\r", b"SAC>") == b"m400v150\r\nSAC>"
        assert b"1\t400\t CW\t150\t2000\t 1.00\t1.00\t0\t  0\r\n" in client.ask(b"q\r", b"s sync\r\nSAC>")
        # Answered when it is durable, at once and not with the next byte.
        assert client.ask(b"$Cd2.5\r", b"SAC>") == b"$Cd2.5\r\nSAC>"
        assert client.ask(b"qs\r", b"SAC>") == b"qs\r\nSAC>"
    server.stop()
    server = started(place, text)
    with server.client("s1") as client:
        client.ask(b"\r", b"SAC>")
        assert b"d acc\t\t2.50\r\n" in client.ask(b"$C\r", b"SAC>")
        client.ask(b"x\r", b"SAC>")
        assert b"1\t400\t CW\t150\t2000" in client.ask(b"q\r", b"s sync\r\nSAC>")
    assert "Traceback" not in server.stop()
