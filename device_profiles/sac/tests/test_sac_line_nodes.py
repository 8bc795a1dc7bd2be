"""What the master of a line knows of SACs: packets to their meaning, and which commands may come twice."""

import pytest

from device_profiles.sac.board import PROFILE
from device_profiles.sac.command_line import COMMANDS_BY_LETTER
from device_profiles.sac.packet import Packet, PacketDecoder, crc8, encode
from hil.vocab.line_node import LinePacket, Signal

NODES = PROFILE.line_nodes
assert NODES


def read(raw: bytes) -> list[LinePacket | None]:
    return [NODES.read(item) for item in PacketDecoder().feed(raw)]


@pytest.mark.parametrize(
    ("data", "signal"),
    [
        (b"\x06", Signal.DONE),
        (b"\x15", Signal.REFUSED),
        (b"\x11", Signal.BEGUN),
        (b"\x12", Signal.ENDED),
        (b"m100", Signal.COMMAND),
    ],
)
def test_signals_are_read(data, signal):
    assert read(encode(1, 85, data)) == [LinePacket(85, 1, signal, data.decode("latin-1"), True)]


def test_text_is_read_without_its_separator():
    assert read(encode(1, 85, b".hello")) == [LinePacket(85, 1, Signal.TEXT, "hello", True)]


def test_what_is_garbled_means_nothing():
    raw = bytearray(encode(1, 85, b"\x06"))
    raw[5] ^= 1
    assert read(bytes(raw)) == [None]
    assert read(b"\2\1\x55\x06\0") == [None]


def test_an_answer_without_crc_is_not_checked():
    [packet] = read(encode(1, 85, b"\x06", crc=False))
    assert packet
    assert not packet.is_checked


def test_every_command_is_checked_by_its_node():
    unchecked = b"m13"
    assert crc8(unchecked) == 0
    [packet] = PacketDecoder().feed(NODES.encode(4, unchecked))
    assert isinstance(packet, Packet)
    assert (packet.data, packet.crc != 0) == (b"m13 ", True)


@pytest.mark.parametrize("address", [1, 2, 3, 256, -1])
def test_an_address_of_no_node_is_refused(address):
    with pytest.raises(ValueError, match="no node's address"):
        NODES.encode(address, b"m1")


@pytest.mark.parametrize("command", [b"", b"m\0", b"m" * 81])
def test_what_no_packet_carries_is_refused(command):
    with pytest.raises(ValueError, match=r"empty|STX|bytes of data"):
        NODES.encode(4, command)


def test_text_outside_latin_1_is_refused():
    assert NODES.text("grün") == b" gr\xfcn"
    with pytest.raises(ValueError, match="Latin-1"):
        NODES.text("\u03b1")


AGAIN = "a1.5 A d v vc1500 V12 vd s S l q9m-2000vc1500a1d1l0pu0s0t0 qs qr qc cf $F $P $R $H0 $K1 $L1 $O0 $CM9"
ONCE = "m m100 M-5 xm10 x5 xl3 n N y ls1 lf9 ln2 + - z g b $U $n $L qp ?i"


@pytest.mark.parametrize("command", AGAIN.split())
def test_these_may_come_twice(command):
    assert NODES.may_repeat(command.encode())


@pytest.mark.parametrize("command", ONCE.split())
def test_these_may_not(command):
    assert not NODES.may_repeat(command.encode())


def test_what_follows_a_blank_does_not_count():
    assert NODES.may_repeat(b"v100 m5")
    assert not NODES.may_repeat(b"m5 v100")
    assert not NODES.may_repeat(NODES.text("v100"))


def test_the_lists_name_every_command_of_the_board():
    said = {command[0] for command in (AGAIN + " " + ONCE).split()}
    assert {letter for letter in COMMANDS_BY_LETTER if letter.islower()} <= {each.lower() for each in said}


def test_a_command_that_may_come_twice_leaves_the_node_as_once(segment):
    """The state that the terminal shows is the same after one time and after two."""
    for command in (b"a7.5", b"v77", b"q9m-2000vc1500a1d1l0pu0s0t0", b"$P", b"$CL25", b"qc"):
        shown = []
        for times in (1, 2):
            b = segment(1)
            for _ in range(times):
                b.tap("bus0.master").write(NODES.encode(4, command))
                b.run(ms=50)
            b.port("s4").read()
            for query in (b"q\r", b"cf\r", b"cc\r"):
                b.port("s4").write(query)
                b.run(ms=1000)
            shown.append(b.port("s4").read())
        assert shown[0] == shown[1]


def test_the_probe_changes_nothing_and_is_answered(segment):
    b = segment(1)
    b.tap("bus0.master").write(NODES.encode(4, NODES.probe))
    b.run(ms=50)
    assert b.tap("bus0.master").read() == encode(1, 4, b"\x06")
    assert b.port("s4").read() == b""
