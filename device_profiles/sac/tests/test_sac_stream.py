"""Long files: read, streamed into a board's queue on the virtual clock, and disturbed on the way."""

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from device_profiles.sac import companion
from device_profiles.sac.long_files import read_long_file
from device_profiles.sac.network import DC1, DC2
from device_profiles.sac.row_stream import MOST_IN_BOARD, RowStream
from hil.testing import Bench
from hil.vocab.dialogue import BoardRefusal, DialogueError, Heard, Listen, Progress, Refusal, Send

PULSES_PER_STEP = 2
LONGEST = 10_560


def content(count, seed=1, position=lambda n: n % 30 + 1):
    """Rows of a file of the companion; short ones, that a stream has to hurry with."""
    draw = random.Random(seed)
    lines = []
    for n in range(count):
        rpm = draw.choice([100, 150, 200, 300])
        lines.append(
            f" {position(n)} , {draw.randint(1, 8)} , {draw.randint(0, 1)} , 1 , {rpm} , {300000 // rpm} ,"
            f" {draw.randint(0, 1)} , {draw.choice(['1', '10.47', '999'])} , 999 , 0 , 0 , 0 \r\n"
        )
    return "".join(lines).encode()


def same(count, steps=200, **changes):
    row = {"steps": steps, "direction": 0, "sync": 0, "deltaT": 0} | changes
    text = "1 , {steps} , {direction} , 1 , 300 , 1000 , 0 , 999 , 999 , 0 , {sync} , {deltaT} "
    return read_long_file(
        "".join(f" {n % 30 + 1} , {text[4:].format(**row)}\r\n" for n in range(count)).encode(), "long.txt"
    )


def steps(file, end=None):
    return sum(-row.steps if row.is_ccw else row.steps for row in file.rows[:end])


def board(**device):
    bench = Bench({"bench": "long", "devices": {"s1": {"profile": "sac"} | device}})
    bench.run(ms=1500)
    return bench


def position(bench):
    """Where the pulses were to bring it, in steps."""
    return bench.axis("s1").snapshot().commanded_deg / 1.8


def disturbed(dialogue, *, sends=lambda data: data, hears=lambda data: data, at=None):
    """Run a dialogue over a line that changes bytes. ``at``: called before each step."""
    answer = None
    try:
        step = dialogue.send(None)
        while True:
            if at:
                at(step)
            if isinstance(step, Send):
                step = Send(sends(step.data))
            answer = yield step
            while isinstance(step, Listen) and answer.data:
                if heard := hears(answer.data):
                    answer = Heard(answer.at_ns, heard)
                    break
                answer = yield step
            step = dialogue.send(answer)
    except StopIteration as done:
        return done.value


# ---- files ----


@given(st.integers(1, 200), st.booleans())
def test_rows_are_read_in_order_with_either_positions(count, is_counted):
    data = content(count, position=(lambda n: n + 1) if is_counted else (lambda n: n % 30 + 1))
    file = read_long_file(data, "long.txt")
    assert len(file.rows) == count
    assert file.lines == list(range(1, count + 1))


BAD = [
    (lambda lines: lines.__setitem__(2, " 9 , 1"), "long.txt:3:1: 2 numbers; a row has 12"),
    (lambda lines: lines.insert(3, ""), "long.txt:4:1: an empty line; take it out"),
    (lambda lines: lines.pop(5), "long.txt:6:1: position 7 in row 6; rows run in the file's order: write 6"),
    (lambda lines: lines.pop(40), "long.txt:41:1: position 12 in row 41; .* write 41 or 11"),
    (lambda lines: lines.__setitem__(1, lines[1].replace(", 1 ,", ", x ,", 1)), r"long.txt:2:\d+: "),
    (lambda lines: lines.clear(), "long.txt:1:1: there are no rows"),
]


@pytest.mark.parametrize(("spoil", "said"), BAD)
def test_a_bad_row_of_a_long_file_has_its_place(spoil, said):
    lines = content(60).decode().split("\r\n")[:-1]
    spoil(lines)
    with pytest.raises(Refusal, match=f"^{said}"):
        read_long_file("\r\n".join(lines).encode(), "long.txt")


def test_all_problems_are_told_at_once_but_no_thousands():
    with pytest.raises(Refusal) as caught:
        read_long_file(content(LONGEST).replace(b" 1 ,", b" ? ,"), "long.txt")
    told = str(caught.value).splitlines()
    assert len(told) == 51
    assert told[-1].startswith("and ")
    assert told[-1].endswith(" more")


def test_contradictions_are_told_before_anything_moves():
    bench = board()
    file = read_long_file(content(40).replace(b" 100 , 3000 ", b" 100 , 3100 "), "long.txt")
    with pytest.raises(Refusal, match=r"^long.txt:\d+:1: RPM 100 and cycle 3100 .* write cycle 3000\n"):
        bench.talk("s1", RowStream(file).run())
    assert position(bench) == 0


@pytest.mark.parametrize(("first", "last"), [(0, None), (41, None), (5, 4), (1, 41)])
def test_rows_that_a_file_does_not_have_are_refused(first, last):
    with pytest.raises(Refusal, match=r"^long\.txt: there are no rows"):
        RowStream(same(40), first, last)


# ---- to the end ----


@pytest.mark.parametrize("count", [1, 31, 1056, pytest.param(LONGEST, marks=pytest.mark.thorough)])
def test_a_long_file_moves_by_its_sum(count):
    bench = board()
    file = read_long_file(content(count), "long.txt")
    assert bench.talk("s1", RowStream(file).run()) == count
    assert position(bench) == pytest.approx(steps(file), abs=1e-6)
    assert bench.axis("s1").snapshot().motion_state == 0
    assert "soft_ops\t0" in bench.talk("s1", companion.commands(["cf"]))


def test_the_board_never_has_more_than_it_holds():
    """The pace is the board's: rows of 0.2 s, of which 29 fit in."""
    bench = board()
    most = 0
    stream = RowStream(same(80))

    def look(step):
        nonlocal most
        most = max(most, stream.sent - stream.ended)
        assert bench.axis("s1").snapshot().pending <= MOST_IN_BOARD

    assert bench.talk("s1", disturbed(stream.run(), at=look)) == 80
    assert most == MOST_IN_BOARD
    assert position(bench) == pytest.approx(80 * 200)


def test_a_part_of_a_file_runs():
    bench = board()
    file = read_long_file(content(100), "long.txt")
    assert bench.talk("s1", RowStream(file, 11, 60).run()) == 50
    assert position(bench) == pytest.approx(steps(file, 60) - steps(file, 10), abs=1e-6)


def test_progress_counts_the_rows():
    rows = [step.done for step in steps_of(RowStream(same(40, steps=10)).run()) if isinstance(step, Progress)]
    assert rows == list(range(1, 41))


def steps_of(dialogue):
    seen = []
    board().talk("s1", disturbed(dialogue, at=seen.append))
    return seen


def test_a_row_that_waits_for_its_sync_holds_the_stream_until_it_is_released():
    bench = board()
    file = same(40, sync=1, steps=20)
    count = 0

    def release(step):
        nonlocal count
        count += 1
        if bench.axis("s1").snapshot().motion_state == 0 and count % 50 == 0:
            bench.device("s1").pin("sync", 1)
            bench.device("s1").pin("sync", 0)

    assert bench.talk("s1", disturbed(RowStream(file).run(), at=release)) == 40
    assert position(bench) == pytest.approx(800)


def test_a_turning_motor_is_left_alone():
    bench = board()
    bench.port("s1").write(b"m\r")
    bench.run(ms=500)
    with pytest.raises(BoardRefusal, match="the motor runs"):
        bench.talk("s1", RowStream(same(3)).run())


# ---- disturbed lines ----


def lossy(rate, only=None, seed=3):
    draw = random.Random(seed)

    def pass_on(data):
        return bytes(b for b in data if (only and b not in only) or draw.random() >= rate)

    return pass_on


@pytest.mark.parametrize(
    "line",
    [
        {"sends": lossy(0.004)},
        {"hears": lossy(0.004)},
        {"sends": lossy(0.2, b"\r")},
        {"hears": lossy(0.3, DC2)},
        {"hears": lossy(0.3, DC1 + DC2)},
    ],
    ids=["characters to the board", "characters from it", "line ends", "ends", "signals"],
)
def test_what_a_line_loses_is_typed_again(line):
    bench = board()
    file = read_long_file(content(120), "long.txt")
    stream = RowStream(file)
    begun = False

    def begins(step):
        nonlocal begun
        begun = begun or stream.sent > 0

    line = {way: lambda data, change=change: change(data) if begun else data for way, change in line.items()}
    assert bench.talk("s1", disturbed(stream.run(), at=begins, **line)) == 120
    assert position(bench) == pytest.approx(steps(file), abs=1e-6)


def test_a_line_that_loses_all_ends_the_stream_and_says_where():
    bench = board()
    stream = RowStream(same(60, steps=50))
    with pytest.raises(DialogueError, match=r"^row 31 came back damaged 5 times.* go on with --from \d+$"):
        bench.talk(
            "s1",
            disturbed(
                stream.run(), sends=lambda data: data[1:] if stream.sent == 30 and data[:1] == b"m" else data
            ),
        )
    assert position(bench) == pytest.approx(stream.ended * 50)
    assert 0 < stream.ended <= 30


# ---- ends in the middle ----


class Broken(Exception):
    """End of a dialogue by who runs it, before a step."""


def halted(stream, is_time):
    """Break a stream off as Ctrl-C does, and halt it."""

    def look(step):
        if is_time():
            raise Broken

    dialogue = stream.run()
    try:
        yield from disturbed(dialogue, at=look)
    except Broken:
        with pytest.raises(DialogueError, match=r"^interrupted; "):
            dialogue.throw(DialogueError("interrupted"))
    return (yield from stream.halt())


@pytest.mark.parametrize("row", [1, 17, 45])
def test_a_stream_is_halted_behind_a_row_and_goes_on(row):
    bench = board()
    file = read_long_file(content(60), "long.txt")
    stream = RowStream(file)
    said = bench.talk("s1", halted(stream, lambda: stream.ended >= row))
    assert said == f"rows up to {stream.ended} have run; go on with --from {stream.ended + 1}"
    bench.run(ms=3000)
    assert position(bench) == pytest.approx(steps(file, stream.ended), abs=1e-6)
    bench.talk("s1", RowStream(file, stream.ended + 1).run())
    assert position(bench) == pytest.approx(steps(file), abs=1e-6)


@pytest.mark.parametrize("at", range(0, 400, 37))
def test_it_can_be_halted_at_any_step(at):
    bench = board()
    file = read_long_file(content(60), "long.txt")
    stream = RowStream(file)
    count = 0

    def is_time():
        nonlocal count
        count += stream.sent > 5
        return count > at

    bench.talk("s1", halted(stream, is_time))
    bench.run(ms=1000)
    assert position(bench) == pytest.approx(steps(file, stream.ended), abs=1e-6)


def test_a_halt_drops_a_row_that_waits_for_its_sync():
    bench = board()
    stream = RowStream(same(40, sync=1))
    said = bench.talk("s1", halted(stream, lambda: stream.sent == MOST_IN_BOARD))
    assert said == "no row has run; go on with --from 1"
    bench.port("s1").write(b"y\r")
    bench.run(ms=3000)
    assert position(bench) == 0


def test_a_board_that_starts_again_is_not_typed_at_and_says_where():
    bench = board()
    bench.talk("s1", companion.commands(["$CK40"]))  # a factory restore would undo it
    stream = RowStream(same(60))
    was_reset = False

    def reset(step):
        nonlocal was_reset
        is_idle = isinstance(step, Listen) and step.timeout_ns == 10 * 10**9  # nothing is on the way
        if stream.ended == 12 and not was_reset and is_idle:
            was_reset = True
            bench.device("s1").reset()

    with pytest.raises(DialogueError, match=r"^the board has started again; where row 13 was cut is not kn"):
        bench.talk("s1", disturbed(stream.run(), at=reset))
    bench.run(ms=2000)
    assert "K pulse\t\t40" in "\n".join(bench.talk("s1", companion.commands(["cc"])))
    assert bench.talk("s1", RowStream(same(60), 13).run()) == 48


@pytest.mark.parametrize("line", [b"m20\r", b"S\r", b"$R\r", b"v50\r"])
def test_another_client_that_changes_something_ends_it(line):
    bench = board()
    stream = RowStream(same(60))
    was_typed = False

    def type_(step):
        nonlocal was_typed
        if stream.ended == 12 and not was_typed and stream.sent - stream.ended == MOST_IN_BOARD:
            was_typed = True
            bench.port("s1").write(line)

    with pytest.raises(DialogueError, match=r'^somebody else has typed ".*" .*; go on with --from \d+$'):
        bench.talk("s1", disturbed(stream.run(), at=type_))
    assert bench.axis("s1").snapshot().motion_state == 0


def test_another_client_may_ask():
    bench = board()
    file = read_long_file(content(100), "long.txt")
    stream = RowStream(file)
    asked = 0

    def ask(step):
        nonlocal asked
        if stream.ended // 10 > asked and isinstance(step, Listen) and stream.sent - stream.ended > 20:
            asked = stream.ended // 10
            bench.port("s1").write((b"q\r", b"vd\r", b"cf\r", b"\r")[asked % 4])

    assert bench.talk("s1", disturbed(stream.run(), at=ask)) == 100
    assert position(bench) == pytest.approx(steps(file), abs=1e-6)


def test_a_port_that_goes_says_what_the_board_still_runs():
    bench = board()
    stream = RowStream(same(60))
    dialogue = stream.run()

    def goes(step):
        if stream.ended == 5:
            raise Broken

    with pytest.raises(Broken):
        bench.talk("s1", disturbed(dialogue, at=goes))
    with pytest.raises(
        DialogueError,
        match=r"^it has gone; 28 more are in the board, which runs them; .* go on with --from 34$",
    ):
        dialogue.throw(DialogueError("it has gone"))
    bench.run(ms=30_000)
    assert position(bench) == pytest.approx(stream.sent * 200)
