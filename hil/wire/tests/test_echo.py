"""What an adapter echoes, on lines in simulated time."""

import pytest
from echo_rig import BAUD, READ, READ_ANSWER, TO_ALL, WRITE, EchoLine, pieces
from hypothesis import given
from hypothesis import strategies as st

from bridges.modbus.protocol.frame import encode
from hil.vocab.ports import EchoState, Sole
from hil.vocab.time import NS_PER_MS
from hil.wire.echo import LATE_NS, MISSES, PROOFS, Echo
from hil.wire.serial_line import character_ns

LATE = [0, 1 * NS_PER_MS, 16 * NS_PER_MS, 60 * NS_PER_MS]
lines = st.fixed_dictionaries(
    {
        "baud": st.sampled_from([1200, 9600, BAUD, 115200]),
        "late_ns": st.sampled_from(LATE),
        "in_one": st.booleans(),
    }
)
frames = st.builds(
    encode,
    st.integers(1, 247),
    st.sampled_from([1, 2, 3, 4, 5, 6, 8, 16, 22]),
    st.binary(min_size=4, max_size=9),
)


def here(unit: int) -> bool:
    return True


@given(lines)
def test_an_echo_of_a_read_is_dropped_from_the_first_on(shape) -> None:
    line = EchoLine(echoes=True, **shape)
    for count in range(1, 4):
        line.send(READ)
        line.answer(READ_ANSWER)
        assert line.rest(1000) == READ_ANSWER
        assert line.state is (EchoState.YES if count >= PROOFS else EchoState.UNKNOWN)
    assert line.echo.told.dropped_bytes == 3 * len(READ)
    assert line.echo.told.collisions == 0


@given(lines, st.lists(st.sampled_from([READ, WRITE, TO_ALL]), min_size=1, max_size=8))
def test_a_line_without_echo_loses_nothing(shape, sends) -> None:
    line = EchoLine(echoes=False, **shape)
    for sent in sends:
        line.send(sent)
        answer = {READ: READ_ANSWER, WRITE: WRITE, TO_ALL: b""}[sent]
        line.answer(answer)
        assert line.rest(1000) == answer
    assert line.state is not EchoState.YES


@given(lines)
def test_answers_that_equal_their_questions_fool_nobody(shape) -> None:
    """On a line of writes alone no answer is taken for an echo."""
    line = EchoLine(echoes=False, **shape)
    for _ in range(10):
        line.send(WRITE)
        line.answer(WRITE)
        assert line.rest(1000) == WRITE
        assert line.state is not EchoState.YES


@given(lines)
def test_where_an_echo_is_known_the_answer_that_equals_its_question_comes_through(shape) -> None:
    line = EchoLine(echoes=True, **shape).known()
    for _ in range(3):
        line.send(WRITE)
        line.answer(WRITE)
        assert line.rest(1000) == WRITE
    assert line.state is EchoState.YES


@given(lines, st.integers(1, 5))
def test_an_order_is_not_heard_again_at_a_door(shape, orders) -> None:
    """What equals the answer that was just given is its echo, known or not."""
    line = EchoLine(echoes=True, is_here=here, **shape)
    for _ in range(orders):
        line.send(WRITE)
        assert line.rest(1000) == b""


def test_a_master_that_repeats_its_order_later_is_heard() -> None:
    line = EchoLine(echoes=False, is_here=here)
    line.send(WRITE)
    assert line.rest(120) == b""
    line.answer(WRITE)
    assert line.rest() == WRITE


def test_a_door_that_is_known_to_have_no_echo_hears_each_order_at_once() -> None:
    line = EchoLine(echoes=False, is_here=here).known()
    assert line.state is EchoState.NO
    line.send(WRITE)
    line.answer(WRITE)
    assert line.rest() == WRITE


def test_a_broadcast_is_not_heard_again() -> None:
    line = EchoLine(echoes=True)
    line.send(TO_ALL)
    assert line.rest() == b""


@given(lines, st.lists(frames, min_size=2, max_size=5))
def test_several_sends_in_a_row(shape, sends) -> None:
    line = EchoLine(echoes=True, **shape).known()
    for sent in sends:
        line.send(sent)
    line.answer(READ_ANSWER)
    assert line.rest(3000) == READ_ANSWER


@given(lines, st.binary(min_size=1, max_size=20))
def test_bytes_of_another_before_the_echo_come_through(shape, others) -> None:
    line = EchoLine(echoes=True, **shape).known()
    line.answer(others, 0)
    line.wait(line.now_ns + character_ns(len(others), shape["baud"]) // 2)
    line.send(READ)
    line.answer(READ_ANSWER)
    assert line.rest(1000) == others + READ_ANSWER
    assert line.state is EchoState.YES


@given(lines, st.integers(0, len(READ) - 1), st.integers(1, 255))
def test_a_damaged_echo_is_a_collision_and_costs_no_answer(shape, place, flip) -> None:
    line = EchoLine(echoes=True, **shape).known()
    spoilt = bytearray(READ)
    spoilt[place] ^= flip
    line.send(READ, bytes(spoilt))
    line.answer(WRITE)
    assert line.rest(1000) == spoilt + WRITE
    assert line.echo.told.collisions == 1
    assert line.state is EchoState.YES


@given(lines, st.integers(1, len(READ) - 1), st.booleans())
def test_a_part_of_an_echo_is_a_collision_and_costs_no_answer(shape, count, is_tail) -> None:
    line = EchoLine(echoes=True, **shape).known()
    part = READ[count:] if is_tail else READ[:count]
    line.send(READ, part)
    line.answer(READ_ANSWER)
    assert line.rest(1000) == part + READ_ANSWER
    assert line.echo.told.collisions == 1


def test_a_damaged_write_costs_no_answer_that_equals_it() -> None:
    line = EchoLine(echoes=True).known()
    line.send(WRITE, WRITE[:3] + b"\xff" + WRITE[4:])
    line.answer(WRITE)
    assert line.rest().endswith(WRITE)


@given(lines, st.lists(st.integers(1, 4), max_size=8), st.lists(st.integers(0, 3), min_size=9, max_size=9))
def test_what_is_sent_in_pieces_is_one_thing(shape, sizes, gaps_ms) -> None:
    line = EchoLine(echoes=True, in_pieces=True, is_here=here, **shape)
    for sent in (READ_ANSWER, WRITE, READ_ANSWER, WRITE):
        for piece, gap_ms in zip(pieces(sent, sizes), gaps_ms, strict=False):
            line.send(piece)
            line.wait(line.now_ns + gap_ms * NS_PER_MS)
        assert line.rest(1000) == b""
    assert line.state is EchoState.YES


@given(st.lists(st.integers(1, 4), max_size=8))
def test_a_real_node_answers_a_write_in_pieces(sizes) -> None:
    line = EchoLine(echoes=False, in_pieces=True)
    for _ in range(3):
        for piece in pieces(WRITE, sizes):
            line.send(piece)
        line.answer(WRITE)
        assert line.rest(30) == WRITE


def test_an_adapter_that_echoes_no_more_is_learned_again() -> None:
    line = EchoLine(echoes=True).known()
    line.echoes = False
    for _ in range(2 * MISSES):
        assert line.state is not EchoState.NO
        line.send(READ)
        line.answer(READ_ANSWER)
        assert line.rest() == READ_ANSWER
    assert line.state is EchoState.NO


def test_an_adapter_that_echoes_now_is_learned_without_an_echo_heard() -> None:
    line = EchoLine(echoes=False).known()
    line.echoes = True
    for _ in range(PROOFS):
        line.send(READ)
        assert line.rest() == b""
    assert line.state is EchoState.YES


def test_a_line_that_is_opened_again_is_not_known() -> None:
    line = EchoLine(echoes=True).known()
    line.send(READ)
    line.echo.reopened()
    assert line.state is EchoState.UNKNOWN
    assert line.echo.received(READ) == READ


@pytest.mark.parametrize("is_wanted", [True, False])
def test_a_setting_is_believed(is_wanted) -> None:
    line = EchoLine(echoes=not is_wanted, wanted=is_wanted)
    state = line.state
    for _ in range(5):
        line.send(READ)
        line.answer(READ_ANSWER)
        assert line.rest() == (b"" if is_wanted else READ) + READ_ANSWER
        assert line.state is state is (EchoState.YES if is_wanted else EchoState.NO)


def test_a_terminal_is_not_looked_at_unless_somebody_says_so() -> None:
    echo = Echo(BAUD)
    echo.sent(b"m 90\r", 0)
    assert echo.received(b"m 90\r\n> ") == b"m 90\r\n> "
    assert echo.told.state is EchoState.UNSOUGHT
    echo = Echo(BAUD, wanted=True, in_pieces=True)
    for byte in b"m 90\r":
        echo.sent(bytes((byte,)), 0)
    assert echo.received(b"m 90\rm 90\r\n> ") == b"m 90\r\n> "


@given(
    st.lists(st.tuples(st.booleans(), st.binary(min_size=1, max_size=6), st.integers(0, 40)), max_size=30),
    st.sampled_from([None, True, False]),
    st.sampled_from(list(Sole)),
    st.booleans(),
)
def test_each_byte_comes_out_once_in_order_or_is_an_echo(steps, wanted, sole, in_pieces) -> None:
    echo = Echo(BAUD, wanted=wanted, sole=lambda data: sole, in_pieces=in_pieces)
    now_ns, sent, came, out = 0, b"", b"", b""
    for is_sent, data, ms in steps:
        now_ns += ms * NS_PER_MS
        out += echo.advance(now_ns)
        if is_sent:
            echo.sent(data, now_ns)
            sent += data
        else:
            came += data
            out += echo.received(data)
    out += echo.advance(now_ns + 2 * LATE_NS)
    out += echo.advance(now_ns + 4 * LATE_NS)
    assert len(came) == len(out) + echo.told.dropped_bytes
    rest = iter(came)
    assert all(byte in rest for byte in out)
    assert echo.told.dropped_bytes <= len(sent)
    assert out == came or wanted is not False
