"""SACs on a line with real nodes: a twin has no address before its EEPROM is read, and leaves one that a real
node has only until it has another."""

from collections.abc import Iterator

import pytest

from device_profiles.sac.packet import encode
from hil.testing import Bench

COLD_START_MS = 1200
REAL_85, REAL_86 = encode(1, 85, b"y"), encode(1, 86, b"y")


@pytest.fixture
def bench() -> Iterator[Bench]:
    """Twin ``s1`` has address 90, ``s2`` 86; real nodes are behind the tap."""
    setup = {
        "bench": "t",
        "devices": {name: {"profile": "sac", "flash": {}} for name in ("s1", "s2")},
        "segments": {"bus0": {"stations": ["s1", "s2"], "taps": {"line": {"port": "memory", "real": True}}}},
    }
    with Bench(setup) as made:
        made.run(ms=COLD_START_MS)
        for name, address in (("s1", 90), ("s2", 86)):
            rename(made, name, address)
        yield made


def rename(bench: Bench, name: str, address: int) -> None:
    bench.port(name).write(b"$CM%d\r" % address)
    bench.run(ms=100)
    bench.port(name).write(b"$R\r")
    bench.run(ms=100)


def speak(bench: Bench, packet: bytes) -> bytes:
    """Let a real node speak; answers what is heard at the line within 20 ms."""
    tap = bench.tap("bus0.line")
    tap.read()
    tap.write(packet)
    bench.run(ms=20)
    return tap.read()


def notes(bench: Bench) -> list[str]:
    return list(bench._runtime.taps["bus0.line"].notes.values())


def test_a_twin_that_starts_has_no_address(bench: Bench) -> None:
    wire = bench._runtime.segments["bus0"]
    bench.device("s1").reset()
    bench.device("s2").reset()
    for _ in range(COLD_START_MS // 20):
        speak(bench, REAL_85)
        assert (wire.clashes(), notes(bench)) == ({}, [])
    assert speak(bench, encode(86, 85, b"y")).startswith(encode(85, 86, b"\x06"))


def test_a_twin_is_back_with_another_address(bench: Bench) -> None:
    speak(bench, REAL_86)
    assert notes(bench) == [
        "address 86 is a real node: s2.network was taken off the wire, until it has another address"
    ]
    assert speak(bench, encode(86, 85, b"y")) == b""
    bench.device("s2").reset()
    bench.run(ms=COLD_START_MS)
    assert speak(bench, encode(86, 85, b"y")) == b"", "the real node still has it"
    rename(bench, "s2", 87)
    assert notes(bench) == []
    assert speak(bench, encode(87, 85, b"y")).startswith(encode(85, 87, b"\x06"))
    rename(bench, "s2", 86)
    assert speak(bench, encode(86, 85, b"y")).startswith(encode(85, 86, b"\x06")), "until the real one speaks"
    speak(bench, REAL_86)
    assert len(notes(bench)) == 1


def test_two_twins_leave_one_address_and_come_back_one_by_one(bench: Bench) -> None:
    rename(bench, "s1", 86)
    wire = bench._runtime.segments["bus0"]
    assert wire.clashes() == {86: ["s2.network", "s1.network"]}
    speak(bench, REAL_86)
    assert (wire.clashes(), len(notes(bench))) == ({}, 2)
    rename(bench, "s1", 90)
    assert [note.split()[6] for note in notes(bench)] == ["s2.network"]
