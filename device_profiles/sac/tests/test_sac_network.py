"""The SAC as a node: bytes at its network port, and two of them on one wire, on the virtual clock."""

import pytest

from hil.testing import Bench
from hil.wire.packet import Malformed, Packet, PacketDecoder, encode

ONE = {"bench": "one", "devices": {"s1": {"profile": "sac"}}}
TWO = {
    "bench": "two",
    "devices": {"s1": {"profile": "sac"}, "s2": {"profile": "sac"}},
    "segments": {"bus0": {"stations": ["s1", "s2"]}},
}


def characters_ns(count):
    return count * 10 * 10**9 // 38400


ACK, NAK, DC1, DC2 = b"\x06", b"\x15", b"\x11", b"\x12"


class Board:
    """One SAC past its cold start, with a device of the test's own at its network port."""

    def __init__(self, *setup: str, config=ONE, name="s1"):
        self.bench = Bench(config)
        self.terminal = self.bench.port(name)
        self.network = self.bench.port(name, "network")
        self.axis = self.bench.axis(name)
        self.bench.run(ms=1100)
        for line in setup:
            self.type(line)
        self.terminal.read()
        self.network.read()

    def type(self, line, ms=300.0):
        """What the terminal shows then."""
        self.terminal.write(line.encode() + b"\r")
        self.bench.run(ms=ms)
        return self.terminal.read()

    def packet(self, data, origin=1, destination=85, crc=True, ms=100.0):
        """The packets that a packet is answered with, as (destination, origin, data)."""
        return self.raw(encode(destination, origin, data, crc=crc), ms)

    def raw(self, data, ms=100.0):
        self.network.write(data)
        self.bench.run(ms=ms)
        return self.heard()

    def heard(self):
        return packets(self.network.read())


def packets(data):
    decoder = PacketDecoder()
    items = decoder.feed(data)
    assert decoder.pending == b""
    assert not any(isinstance(item, Malformed) for item in items)
    assert all(item.is_good for item in items)
    return [(item.destination, item.origin, item.data) for item in items if isinstance(item, Packet)]


@pytest.fixture
def board():
    return Board()


def pulses(board):
    return board.axis.snapshot().pulses


# ---- commands and their answers ----


def test_a_command_is_acknowledged_and_runs(board):
    assert board.packet(b"m300v150ad", ms=3000) == [(1, 85, ACK)]
    assert pulses(board) == 600
    assert board.terminal.read() == b""


def test_the_acknowledgement_begins_two_characters_after_the_packet(board):
    start_ns = board.bench.now_ns
    raw = encode(85, 1, b"y")
    board.network.write(raw)
    board.bench.run(ms=100)
    [(at_ns, ack)] = board.network.read_timed()
    assert ack == encode(1, 85, ACK)
    assert at_ns == start_ns + characters_ns(len(raw)) + characters_ns(2)


def test_a_broadcast_runs_and_is_not_answered(board):
    assert board.packet(b"m10ad", destination=0, ms=1000) == []
    assert pulses(board) == 20


@pytest.mark.parametrize("destination", [86, 1, 4, 255])
def test_other_units_packets_do_nothing(board, destination):
    assert board.packet(b"m10ad", destination=destination, ms=1000) == []
    assert pulses(board) == 0


def test_a_wrong_crc_is_refused_and_nothing_runs(board):
    raw = bytearray(encode(85, 1, b"m10ad"))
    raw[-2] ^= 0x40
    assert board.raw(bytes(raw), ms=1000) == [(1, 85, NAK)]
    assert pulses(board) == 0


UNCHECKED = [b"\2\x55\1m10ad\3\0", b"\2\x55\1m10ad\3\0\0"]


@pytest.mark.parametrize("raw", UNCHECKED)
@pytest.mark.parametrize("is_in_one", [True, False])
def test_a_nul_behind_etx_ends_a_packet_that_is_not_checked(board, raw, is_in_one):
    start_ns = board.bench.now_ns
    count = raw.index(b"\3") + 2
    if is_in_one:
        board.network.write(raw)
        heard_ns = start_ns + characters_ns(count)
    else:
        for byte in raw:
            board.network.write(bytes((byte,)))
        heard_ns = start_ns + count * characters_ns(1)  # each write begins at a whole nanosecond
    board.bench.run(ms=1000)
    assert board.network.read_timed() == [(heard_ns + characters_ns(2), encode(1, 85, ACK))]
    assert pulses(board) == 20


def test_the_crc_of_m13_is_zero_and_it_runs_with_and_without_it(board):
    with_crc = encode(85, 1, b"m13")
    assert with_crc[-3:] == b"\3\0\0"
    for count, raw in enumerate((with_crc, encode(85, 1, b"m13", crc=False)), start=1):
        assert board.raw(raw, ms=5000) == [(1, 85, ACK)]
        assert pulses(board) == count * 26


def test_packets_without_crc_one_after_the_other_are_all_answered(board):
    raw = b"".join(
        encode(85, origin, b"y", crc=False) + idle for origin, idle in ((1, b""), (4, b"\0"), (5, b""))
    )
    assert board.raw(raw) == [(1, 85, ACK), (4, 85, ACK), (5, 85, ACK)]


def test_packets_without_crc_that_come_while_the_board_is_busy_are_answered_after(board):
    board.terminal.write(b"cc\r")
    board.bench.run(ms=2)
    for origin in (1, 4):
        board.network.write(encode(85, origin, b"y", crc=False))
    board.bench.run(ms=3000)
    assert board.heard() == [(1, 85, ACK), (4, 85, ACK)]


def test_a_nul_behind_the_end_costs_nothing():
    """Neither an error of the line nor a wait: a segment counts none, and the next packet is heard."""
    bench = Bench(
        {
            "bench": "one",
            "devices": {"s1": {"profile": "sac"}},
            "segments": {"bus0": {"stations": ["s1"], "taps": {"m": {"port": "memory"}}}},
        }
    )
    bench.run(ms=1100)
    tap = bench.tap("bus0.m")
    for raw in UNCHECKED:
        for piece in (raw, raw[:-1], raw[-1:]):  # in one burst, and cut before its last byte
            tap.write(piece)
            bench.run(ms=500)
    assert packets(tap.read()) == [(1, 85, ACK)] * 4
    assert bench.axis("s1").snapshot().pulses == 80
    stats = bench.segment("bus0").stats
    assert (stats.packets, stats.errors, stats.collisions) == (8, {}, 0)


def test_a_wrong_crc_of_a_broadcast_is_silence(board):
    assert board.raw(b"\2\0\1m10ad\3\x41\0", ms=1000) == []
    assert pulses(board) == 0


def test_data_without_a_command_is_acknowledged_alone(board):
    for data in (b"", b"?", b"85m10", b"\\m10", b"/m10", b"k"):
        assert board.packet(data, ms=500) == [(1, 85, ACK)]
    assert pulses(board) == 0
    assert board.terminal.read() == b""


@pytest.mark.parametrize("signal", [ACK, NAK, DC1, DC2])
def test_what_answers_is_never_answered(board, signal):
    assert board.packet(signal) == []
    raw = bytearray(encode(85, 1, signal))
    raw[-2] ^= 1
    assert board.raw(bytes(raw)) == []


def test_acknowledgements_can_be_switched_off(board):
    board.type("$K0")
    assert board.packet(b"m10ad", ms=1000) == []
    assert pulses(board) == 20
    board.type("$K")
    assert board.packet(b"y") == [(1, 85, ACK)]


def test_without_crc_packets_carry_none_and_are_still_checked(board):
    board.type("$H0")
    board.network.write(encode(85, 1, b"y"))
    board.bench.run(ms=100)
    assert board.network.read() == b"\2\1\x55\x06\3\0"
    raw = bytearray(encode(85, 1, b"y"))
    raw[-2] ^= 1
    board.network.write(bytes(raw))
    board.bench.run(ms=100)
    assert board.network.read() == b"\2\1\x55\x15\3\0"
    board.type("86m13")
    assert board.network.read() == b"\2\x56\x55m13\3\0"
    board.type("$H1")
    board.type("86m13")
    assert board.network.read() == b"\2\x56\x55m13\3\0\0"


def test_queries_are_acknowledged_and_print_nothing(board):
    for data in (b"q", b"cc", b"cf", b"$E", b"vd", b"xd", b"$C", b"qp", b"xp"):
        assert board.packet(data, ms=1500) == [(1, 85, ACK)]
    assert board.terminal.read() == b""
    assert board.type("vd") == b"vd\r\n0\t0\r\nSAC>"  # in no program mode


def test_a_pulse_by_packet(board):
    seen = []
    for data in (b"+", b"-", b"+", b"+"):
        board.packet(data)
        seen.append(pulses(board))
    assert seen == [1, 0, 1, 2]


def test_a_parameter_can_be_set_over_the_network(board):
    assert board.packet(b"$CM90") == [(1, 85, ACK)]
    assert board.packet(b"$R") == [(1, 85, ACK)]
    assert board.packet(b"y") == []
    assert board.packet(b"y", destination=90) == [(1, 90, ACK)]


def test_packets_one_after_the_other_are_all_answered(board):
    raw = b"".join(encode(85, origin, b"y") for origin in (1, 4, 5))
    assert board.raw(raw) == [(1, 85, ACK), (4, 85, ACK), (5, 85, ACK)]


@pytest.mark.parametrize("number", [0, 2, 3])
def test_an_address_that_nobody_can_reach_is_told_to_the_operator(board, number):
    board.type(f"$CM{number}")
    board.type("$R")
    assert board.bench.device("s1").notes["id"] == f"d_id is {number}: no packet reaches it"
    board.type("$CM90")
    board.type("$R")
    assert "id" not in board.bench.device("s1").notes


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


# ---- soft_ops ----


def test_soft_ops_tell_beginning_and_end_with_their_times(board):
    board.type("$O1")
    edges_before = len(board.bench.device("s1").pin("OP SA").edges())
    board.type("m10v150ad", ms=2000)
    begun, ended = board.bench.device("s1").pin("OP SA").edges()[edges_before:]
    sent = board.network.read_timed()
    assert [(at_ns, packets(data)) for at_ns, data in sent] == [
        (begun[0], [(0, 85, DC1)]),
        (ended[0], [(0, 85, DC2)]),
    ]


def test_soft_ops_reach_the_terminal_as_bytes(board):
    board.type("$O1")
    assert board.type("m10v150ad", ms=2000) == b"m10v150ad\r\nSAC>\x11\x12"
    board.type("$O0")
    assert board.type("m10v150ad", ms=2000) == b"m10v150ad\r\nSAC>"
    assert board.heard()[2:] == []


def test_txen_is_high_while_either_port_sends(board):
    tx_enable = board.bench.device("s1").pin("TxEn")
    before = len(tx_enable.edges())
    start_ns = board.bench.now_ns
    board.packet(b"y")
    sent_ns = start_ns + characters_ns(7) + characters_ns(2)
    assert tx_enable.edges()[before:] == [(sent_ns, 1), (sent_ns + characters_ns(7), 0)]
    start_ns = board.bench.now_ns
    board.type("")
    heard_ns = start_ns + characters_ns(1)
    assert tx_enable.edges()[before + 2 :] == [
        (heard_ns, 1),
        (heard_ns + characters_ns(2) + characters_ns(4), 0),
    ]


# ---- overrun, floods, malformed packets ----


def test_a_long_listing_makes_the_network_overrun(board):
    board.terminal.write(b"q\r")
    board.bench.run(ms=20)
    for _ in range(30):
        board.network.write(encode(85, 1, b"y"))
    board.bench.run(ms=3000)
    answers = board.heard()
    assert answers
    assert len(answers) < 30
    assert set(answers) == {(1, 85, ACK)}
    assert board.packet(b"y") == [(1, 85, ACK)]


MALFORMED = [
    b"\2\x55\1y\x64\0",
    b"\2\x55\1y\3\x64",
    b"\2\x55\1y\3\x64.",
    b"\2\x55\1y",
    b"\2\x55",
    b"\2",
    b"\2\2\1y\3\x64\0",
    b"\2\3\1y\3\x64\0",
    b"\2\x55\2y\3\x64\0",
    b"\2\x55\3y\3\x64\0",
    b"\2\x55\1" + b"y" * 81 + b"\3\0\0",
    b"\2\x55\1y\0\3\x64\0",
    b"y",
    b"\0\0\0\3\3\3",
    b"\xff" * 500,
]


@pytest.mark.parametrize("stream", MALFORMED)
def test_what_is_malformed_is_silence_and_the_next_packet_is_heard(board, stream):
    assert board.raw(stream, ms=500) == []
    assert board.packet(b"m10ad", ms=1000) == [(1, 85, ACK)]
    assert pulses(board) == 20
    assert board.terminal.read() == b""


def test_a_flood_of_anything_leaves_a_node_that_answers(board):
    for stream in MALFORMED * 20:
        board.network.write(stream)
    board.bench.run(ms=60_000)
    assert board.heard() == []
    assert board.packet(b"y") == [(1, 85, ACK)]


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
