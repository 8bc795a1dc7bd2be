"""The network at a SAC's terminal: typed packets, shown text, ports swapped, two SACs on one wire."""

import pytest
from network_board import ACK, DC1, DC2, NAK, Board, characters_ns, packets, pulses

from device_profiles.sac.packet import encode
from hil.testing import Bench

TWO = {
    "bench": "two",
    "devices": {"s1": {"profile": "sac"}, "s2": {"profile": "sac"}},
    "segments": {"bus0": {"stations": ["s1", "s2"]}},
}


@pytest.fixture
def board():
    return Board()


# ---- the terminal ----


def test_an_address_sends_a_packet(board):
    assert board.type("86m3000") == b"86m3000\r\nSAC>"
    assert board.network.read() == b"\2\x56\x55m3000\3\x70\0"


@pytest.mark.parametrize(("line", "data"), [("86 hello", b" hello"), ("86.hello", b".hello"), ("86", b"")])
def test_text_keeps_its_separator(board, line, data):
    board.type(line)
    assert board.heard() == [(86, 85, data)]


@pytest.mark.parametrize(("typed", "address"), [(300, 44), (85, 85), (0, 0), (256, 0), (4294967381, 85)])
def test_addresses_are_bytes_and_one_of_its_own_only_goes_out(board, typed, address):
    board.type(f"{typed}m10ad", ms=1000)
    assert board.heard() == [(address, 85, b"m10ad")]
    assert pulses(board) == 0


@pytest.mark.parametrize("address", [2, 3, 258, 259])
def test_nothing_goes_to_an_address_that_cannot_be_used(board, address):
    assert board.type(f"{address}m10") == f"{address}m10\r\nSAC>".encode()
    assert board.network.read() == b""


def test_text_that_comes_is_shown_with_a_new_prompt(board):
    assert board.packet(b" hello there", origin=86) == [(86, 85, ACK)]
    assert board.terminal.read() == b"\r\nhello there\r\nSAC>"
    board.packet(b".dot", destination=0)
    assert board.terminal.read() == b"\r\ndot\r\nSAC>"


def test_a_line_that_is_being_typed_is_drawn_again_after_text(board):
    board.terminal.write(b"vc\b")
    board.packet(b" hello")
    board.terminal.write(b"d")
    board.packet(NAK, origin=86)
    board.terminal.write(b"\r")
    board.packet(b" you there")
    assert board.terminal.read() == (
        b"vc\b \b\r\nhello\r\nSAC>vd\r\nNAK 86\r\nSAC>vd\r\n0\t0\r\nSAC>\r\nyou there\r\nSAC>"
    )


def test_a_line_that_is_being_typed_in_a_program_mode_is_drawn_again_too(board):
    board.type("xp")
    board.terminal.write(b"0,")
    board.packet(b" hello")
    board.terminal.write(b"7\r")
    board.bench.run(ms=300)
    assert board.terminal.read() == b"0,\r\nhello\r\nSAC>0,7\r\nx_ 0 7\r\nx_ 1 0\r\nSAC>"


@pytest.mark.parametrize("key", ["\\", "/"])
def test_a_reply_goes_to_the_last_sender(board, key):
    board.type(f"{key} nobody yet")
    assert board.heard() == []
    board.packet(b" hello", origin=86)
    board.packet(b"y", origin=87)
    board.packet(ACK, origin=88)
    board.type(f"{key} thanks")
    assert board.heard() == [(87, 85, b" thanks")]
    board.type(f"{key}m100")
    assert board.heard() == [(87, 85, b"m100")]
    board.packet(b" all", origin=89, destination=0)
    board.type(f"{key} thanks")
    assert board.heard() == []


def test_a_refusal_is_shown_and_an_acknowledgement_is_not(board):
    board.packet(ACK, origin=86)
    assert board.terminal.read() == b""
    board.packet(NAK, origin=86)
    assert board.terminal.read() == b"\r\nNAK 86\r\nSAC>"


def test_in_a_program_mode_a_number_is_no_address(board):
    board.type("qp", ms=2000)
    board.type("3m77", ms=2000)
    assert board.heard() == []
    board.type("x")
    assert "\n3\t77\t" in board.type("q", ms=2000).decode()


# ---- the ports swapped ----


def test_swapped_ports_change_places(board):
    board.type("$CE1")
    board.type("$R")
    assert board.network.read() == b"SAC>"
    board.network.write(b"vd\r")
    board.bench.run(ms=100)
    assert board.network.read() == b"vd\r\n0\t0\r\nSAC>"
    board.terminal.write(encode(85, 1, b"m10ad"))
    board.bench.run(ms=1000)
    assert packets(board.terminal.read()) == [(1, 85, ACK)]
    assert pulses(board) == 20
    assert "packets here" in board.bench.device("s1").notes["terminal"]


def test_a_brick_is_recovered_by_rst_at_a_cold_start(board):
    board.type("$CE1")
    device = board.bench.device("s1")
    device.reset()
    board.bench.run(ms=1100)
    assert board.terminal.read() == b""
    assert board.network.read() == b"SAC 1.0\r\nSAC>"
    device.pin("RST", 0)
    device.reset()
    board.bench.run(ms=1100)
    assert board.terminal.read() == b"SAC 1.0\r\nSAC>"
    assert board.network.read() == b""
    assert board.packet(b"y") == [(1, 85, ACK)]


def test_a_byte_at_the_swapped_terminal_restores_the_factory_too(board):
    board.type("$CE1")
    board.bench.device("s1").reset()
    board.bench.run(ms=500)
    board.network.write(b"x")
    board.bench.run(ms=600)
    assert board.network.read() == b"SAC 1.0\r\n"
    assert board.terminal.read() == b"SAC>"


# ---- two of them, back to back ----


class Pair:
    def __init__(self):
        self.bench = Bench(TWO)
        self.s1, self.s2 = self.bench.port("s1"), self.bench.port("s2")
        self.wires = [self.bench.port(name, "network") for name in ("s1", "s2")]
        self.bench.run(ms=1100)
        self.s2.write(b"$CM86\r")
        self.bench.run(ms=100)
        self.s2.write(b"$R\r")
        self.bench.run(ms=500)
        self.s1.read()
        self.s2.read()

    def type(self, port, line, ms=300.0):
        port.write(line.encode() + b"\r")
        self.bench.run(ms=ms)
        return self.s1.read(), self.s2.read()


@pytest.fixture
def pair():
    return Pair()


def test_a_command_over_the_wire_moves_the_other(pair):
    assert pair.type(pair.s1, "86m100v150ad", ms=3000) == (b"86m100v150ad\r\nSAC>", b"")
    assert [pair.bench.axis(name).snapshot().pulses for name in ("s1", "s2")] == [0, 200]
    assert [packets(wire.read()) for wire in pair.wires] == [[(86, 85, b"m100v150ad")], [(85, 86, ACK)]]


def test_boards_without_crc_understand_each_other(pair):
    for port in (pair.s1, pair.s2):
        pair.type(port, "$H0")
    assert pair.type(pair.s1, "86m100v150ad", ms=3000) == (b"86m100v150ad\r\nSAC>", b"")
    assert [pair.bench.axis(name).snapshot().pulses for name in ("s1", "s2")] == [0, 200]
    assert [wire.read() for wire in pair.wires] == [b"\2\x56\x55m100v150ad\3\0", b"\2\x55\x56\x06\3\0"]


def test_two_people_chat(pair):
    assert pair.type(pair.s1, "86 hello")[1] == b"\r\nhello\r\nSAC>"
    assert pair.type(pair.s2, "\\ hello yourself")[0] == b"\r\nhello yourself\r\nSAC>"
    assert pair.type(pair.s1, "/.bye")[1] == b"\r\nbye\r\nSAC>"
    assert sum(len(packets(wire.read())) for wire in pair.wires) == 6  # three messages, three ACKs


def test_one_broadcast_starts_what_both_hold(pair):
    pair.type(pair.s1, "86m100v150ads")
    pair.type(pair.s1, "m100v150ads")
    edges = [pair.bench.device(name).pin("OP SA") for name in ("s1", "s2")]
    assert [pin.edges() for pin in edges] == [[], []]
    typed_ns = pair.bench.now_ns
    pair.type(pair.s1, "0y", ms=3000)
    pair.type(pair.s1, "y", ms=3000)  # a broadcast of its own does not reach itself
    heard_ns = typed_ns + characters_ns(len(b"0y\r")) + characters_ns(len(encode(0, 85, b"y")))
    started_ns = pair.bench.device("s2").pin("OP SA").edges()[0][0]
    assert 0 <= started_ns - heard_ns < 500  # the motion's clock has half-microseconds
    assert [pair.bench.axis(name).snapshot().pulses for name in ("s1", "s2")] == [200, 200]


def test_soft_ops_of_one_are_heard_and_start_no_storm(pair):
    pair.type(pair.s2, "$O1")
    pair.type(pair.s1, "86m10ad", ms=2000)
    assert packets(pair.wires[0].read()) == [(86, 85, b"m10ad")]
    assert packets(pair.wires[1].read()) == [(85, 86, ACK), (0, 86, DC1), (0, 86, DC2)]
    assert pair.s1.read() == b""
