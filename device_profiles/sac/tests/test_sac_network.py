"""The SAC as a node: bytes at its network port, on the virtual clock."""

import pytest
from network_board import ACK, DC1, DC2, NAK, Board, characters_ns, packets, pulses

from device_profiles.sac.packet import encode
from hil.testing import Bench


@pytest.fixture
def board():
    return Board()


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
    """Expect no error of the line and no wait: a segment counts none, and the next packet is heard."""
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
