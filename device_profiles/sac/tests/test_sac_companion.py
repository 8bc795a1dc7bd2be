"""The companion's files, and the dialogues that carry them to a board, on the virtual clock."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from device_profiles.sac import companion
from device_profiles.sac.companion_files import (
    QueueFile,
    Row,
    read_one_shot,
    read_queue,
    write_queue,
)
from hil.testing import Bench
from hil.vocab.dialogue import BoardRefusal, DialogueError, Heard, Listen, Progress, Refusal, Send

# Rows of a file that the companion program saved, and others in its form.
FORM = [
    " 1 , 800 , 0 , 1 , 150 , 2000 , 0 , 1 , 1 , 0 , 0 , 3000 ",
    " 2 , 600 , 1 , 1 , 50 , 6000 , 0 , 1 , 1 , 0 , 0 , 3000 ",
    " 3 , 2000 , 1 , 1 , 100 , 3000 , 1 , 10.47 , 10.47 , 0 , 0 , 0 ",
    " 4 , 10 , 0 , 1 , 69 , 4321 , 0 , .5 , 999 , 0 , 0 , 2400000 ",
    " 5 , 200 , 0 , 0 , 999 , 300 , 1 , .05 , 12.3 , 255 , 1 , 4294967295 ",
]
LINES = FORM + [
    f" {position} , 200 , 0 , 1 , 100 , 3000 , 0 , 1 , 1 , 0 , 0 , 0 " for position in range(6, 31)
]
FILE = "".join(f"{line}\r\n" for line in LINES).encode()


def board():
    bench = Bench({"bench": "files", "devices": {"s1": {"profile": "sac"}}})
    bench.run(ms=1500)
    return bench


def as_saved(row):
    return " " + row.replace(",", " , ") + " " if row.strip() else row


def changed(line, text):
    return b"".join(
        f"{text if number == line else old}\r\n".encode()
        for number, old in enumerate(LINES, 1)
        if text or number != line
    )


# ---- files ----


def test_a_file_is_written_as_it_was_read():
    assert write_queue(read_queue(FILE, "q.txt").rows) == FILE


def test_a_hand_made_file_needs_no_blanks_and_no_carriage_returns():
    lenient = FILE.replace(b" ", b"").replace(b"\r", b"").replace(b",.5,", b",0.50,").removesuffix(b"\n")
    assert read_queue(lenient, "q.txt").rows == read_queue(FILE, "q.txt").rows


ROWS = st.builds(
    Row,
    position=st.just(1),
    steps=st.integers(1, 2**32 - 1),
    is_ccw=st.integers(0, 1),
    is_full=st.integers(0, 1),
    rpm=st.integers(1, 1000),
    cycle_us=st.integers(2, 300000),
    is_linear=st.integers(0, 1),
    acc_hundredths=st.integers(0, 9999) | st.integers(100, 999).map(lambda whole: whole * 100),
    dec_hundredths=st.integers(0, 9999),
    extra_pulses=st.integers(0, 255),
    is_sync=st.integers(0, 1),
    wait_us=st.integers(0, 2**32 - 1),
)


@pytest.mark.long
@given(st.lists(ROWS, min_size=30, max_size=30))
def test_any_rows_survive_a_file(rows):
    rows = [row._replace(position=position) for position, row in enumerate(rows, 1)]
    written = write_queue(rows)
    assert read_queue(written, "q.txt").rows == rows
    assert write_queue(read_queue(written, "q.txt").rows) == written


ROW_3 = [  # a bad third row, and what is said of it
    ("3,20x0,1,1,100,3000,0,1,1,0,0,0", '3:6: steps is "20x0"; write a whole number'),
    ("3,-2,1,1,100,3000,0,1,1,0,0,0", '3:6: steps is "-2"; write a whole number'),
    ("3,, 1,1,100,3000,0,1,1,0,0,0", '3:7: steps is ""; write a whole number'),
    ("3,2000,1,1,100,3000,0,1,1,0,0", "3:1: 11 numbers; a row has 12"),
    ("3,2000,2,1,100,3000,0,1,1,0,0,0", "3:13: direction is 2; 1 is the largest"),
    ("31,2000,1,1,100,3000,0,1,1,0,0,0", "3:2: position is 31; 30 is the largest"),
    ("0,2000,1,1,100,3000,0,1,1,0,0,0", "3:1: position 0 is not of the queue"),
    ("2,2000,1,1,100,3000,0,1,1,0,0,0", "3:1: position 2 stands twice"),
    ("3,2000,1,1,0,3000,0,1,1,0,0,0", "3:1: RPM and cycle cannot be 0"),
    ("3,0,1,1,100,3000,0,1,1,0,0,0", "3:1: no steps"),
    ("3,2000,1,1,100,3000,0,1.234,1,0,0,0", "3:38: acc is 1.234; a board keeps two decimals"),
    ("3,2000,1,1,100,3000,0,150.5,1,0,0,0", "3:38: acc is 150.5; a board keeps two decimals"),
    ("3,2000,1,1,100,3000,0,1000,1,0,0,0", "3:38: acc is 1000; 999 is the largest"),
    ("3,2000,1,1,100,3000,0,1,nan,0,0,0", '3:42: dec is "nan"; write a number'),
    ("3,2000,1,1,100,3000,0,1,1,256,0,0", "3:46: u is 256; 255 is the largest"),
    ("3,2000,1,1,100,3000,0,1,1,0,0,4294967296", "3:54: deltaT is 4294967296; 4294967295 is"),
    (" ", "3:1: an empty line"),
    ("", "29:1: no row for position 3; a queue has 30"),
]
BAD = [(f"q.txt:{message}", changed(3, as_saved(row))) for row, message in ROW_3] + [
    ("q.txt:1:1: no row for position 1, 2, 3", b""),
    ("q.txt:2:3: the byte 0xff is not UTF-8 text", FILE.replace(b" 2 , 6", b" 2\xff, 6")),
    ("q.txt:1:1: 100,001 bytes", b"1" * 100_001),
]


@pytest.mark.parametrize(("message", "data"), BAD)
def test_a_bad_row_is_told_with_its_place(message, data):
    with pytest.raises(Refusal) as caught:
        read_queue(data, "q.txt")
    assert str(caught.value).startswith(message)


def test_all_problems_are_told_at_once():
    bad = FILE.replace(b" 800 ", b" x ").replace(b" 600 ", b" y ").replace(b"10.47", b"z")
    with pytest.raises(Refusal) as caught:
        read_queue(bad, "q.txt")
    assert [line.split(" is ")[0] for line in str(caught.value).splitlines()] == [
        "q.txt:1:6: steps", "q.txt:2:6: steps", "q.txt:3:38: acc", "q.txt:3:42: dec",
    ]  # fmt: skip


ONE_SHOTS = b"xm1200v150ad\r\n\r\nv159\r\n" + b"\r\n" * 97


def test_one_shots_are_lines():
    assert read_one_shot(ONE_SHOTS, "o.txt", 1) == "xm1200v150ad"
    assert read_one_shot(ONE_SHOTS, "o.txt", 3) == "v159"
    for number, message in (
        (2, "o.txt:2:1: one-shot 2 is empty; filled are 1, 3"),
        (0, "there is no one-shot 0"),
        (101, "there is no one-shot 101"),
    ):
        with pytest.raises(Refusal, match=message):
            read_one_shot(ONE_SHOTS, "o.txt", number)
    with pytest.raises(Refusal, match="no command"):
        read_one_shot(b"m" * 81, "o.txt", 1)


# ---- a board ----


def test_what_was_loaded_is_saved_back_byte_for_byte():
    bench = board()
    assert bench.talk("s1", companion.load(read_queue(FILE, "q.txt"), store=False)) == 30
    assert write_queue(bench.talk("s1", companion.save())) == FILE


def test_a_stored_queue_is_there_after_a_restart():
    bench = board()
    bench.talk("s1", companion.load(read_queue(FILE, "q.txt"), store=True))
    bench.device("s1").reset()
    assert write_queue(bench.talk("s1", companion.save())) == FILE


def test_a_dialogue_waits_for_a_board_that_starts_up():
    bench = Bench({"bench": "files", "devices": {"s1": {"profile": "sac"}}})
    assert len(bench.talk("s1", companion.save())) == 30
    assert b"SAC 1.0\r\nSAC>" in b"".join(data for _, data in bench.port("s1").timeline)


def test_a_dialogue_leaves_an_open_program_mode():
    bench = board()
    bench.port("s1").write(b"qp\r")
    bench.run(ms=1500)
    bench.talk("s1", companion.load(read_queue(FILE, "q.txt"), store=False))
    assert write_queue(bench.talk("s1", companion.save())) == FILE


def test_numbers_that_contradict_each_other_are_refused_before_anything_is_written():
    bench = board()
    before = bench.talk("s1", companion.save())
    bad = changed(3, " 3 , 2000 , 1 , 1 , 100 , 3100 , 0 , 1 , 1 , 0 , 0 , 0 ")
    with pytest.raises(Refusal, match=r"^q.txt:3:1: RPM 100 .* at 200 steps .* write cycle 3000$"):
        bench.talk("s1", companion.load(read_queue(bad, "q.txt"), store=False))
    assert bench.talk("s1", companion.save()) == before


def test_a_turning_motor_is_left_alone():
    bench = board()
    bench.port("s1").write(b"m\r")
    bench.run(ms=500)
    with pytest.raises(BoardRefusal, match="the motor runs"):
        bench.talk("s1", companion.load(read_queue(FILE, "q.txt"), store=False))


def test_a_one_shot_runs():
    bench = board()
    assert bench.talk("s1", companion.commands(["xm100v150ad"])) == []
    bench.run(ms=3000)
    assert bench.axis("s1").snapshot().pulses == 200
    assert bench.talk("s1", companion.commands(["vd"])) == ["0\t0"]


def test_a_calibration_takes_a_minute_and_finds_the_twin_exact():
    bench = board()
    found = bench.talk("s1", companion.calibrate(150))
    assert found.nominal_ns == 60 * 10**9
    assert found.measured_ns == found.nominal_ns
    assert (found.factor, found.correction_us) == (1.0, 0)
    assert bench.axis("s1").snapshot().pulses == 60_000
    bench.port("s1").write(b"cf\r")
    bench.run(ms=300)
    assert b"soft_ops\t0" in bench.port("s1").read()


def test_a_calibration_sees_what_xclk_adds():
    bench = board()
    for line in ("$CI5", "$O1"):
        bench.port("s1").write(f"{line}\r".encode())
        bench.run(ms=200)
    bench.port("s1").write(b"$R\r")
    bench.run(ms=500)
    found = bench.talk("s1", companion.calibrate(150))
    assert found.measured_ns - found.nominal_ns == 60_000 * 5000
    assert (found.clock_correction_us, found.correction_us) == (5, -5)


@pytest.mark.parametrize("rpm", [0, -5, 10**9])
def test_no_speed_is_refused(rpm):
    with pytest.raises(Refusal, match="no speed"):
        board().talk("s1", companion.calibrate(rpm))


# ---- boards that are none, and ports that go ----


def played(dialogue, answer):
    """Run a dialogue against a function from what was sent to what comes back, or to an error."""
    unread, now_ns = b"", 0
    step = next(dialogue)
    while True:
        reply = None
        if isinstance(step, Send):
            answered = answer(step.data)
            if isinstance(answered, Exception):
                step = dialogue.throw(answered)
                continue
            unread += answered
        elif isinstance(step, Listen):
            now_ns += 0 if unread else step.timeout_ns
            reply, unread = Heard(now_ns, unread), b""
        try:
            step = dialogue.send(reply)
        except StopIteration as done:
            return done.value


def test_silence_and_strangers_are_told_apart():
    with pytest.raises(DialogueError, match="nothing answers"):
        played(companion.save(), lambda data: b"")
    with pytest.raises(DialogueError, match="not from a SAC at its prompt: b'login: '"):
        played(companion.save(), lambda data: b"login: ")


def test_a_port_that_goes_in_the_middle_says_where_it_stopped():
    sent = []

    def board_that_goes(data):
        sent.append(data)
        line = data.removesuffix(b"\r")
        if line.startswith(b"q12m"):
            return DialogueError("/dev/ttyUSB0 has gone")
        answers = {b"cc": b"a sprf\t\t200\r\n", b"vd": b"0\t0\r\n"}
        return line + b"\r\n" + answers.get(line, b"") + b"SAC>"

    with pytest.raises(DialogueError, match=r"^stopped at row 12 of 30: /dev/ttyUSB0 has gone; "):
        played(companion.load(read_queue(FILE, "q.txt"), store=True), board_that_goes)
    assert b"qs\r" not in sent


def interrupted(dialogue, at):
    """Run a dialogue until a step of it for which ``at`` is true, and break it off there."""
    step = next(dialogue)
    while not at(step):
        step = dialogue.send((yield step))
    dialogue.throw(DialogueError("interrupted"))


def has_sent(line):
    return lambda step: isinstance(step, Send) and step.data == line


@pytest.mark.parametrize(
    ("at", "said"),
    [
        (lambda step: isinstance(step, Progress), r"^stopped at row 1 of 30: interrupted; .* load it again$"),
        (
            lambda step: isinstance(step, Progress) and step.done == 30,
            r"^stopped at row 30 of 30: interrupted; .* load it again$",
        ),
        (has_sent(b"q\r"), "^all rows were sent, but could not be read back: interrupted; load them again$"),
        (
            has_sent(b"qs\r"),
            "^all rows are in the board, but perhaps not in its EEPROM: interrupted; store them again$",
        ),
    ],
    ids=["first row", "last row", "reading back", "storing"],
)
def test_a_load_that_is_broken_off_says_what_is_in_the_board(at, said):
    with pytest.raises(DialogueError, match=said):
        board().talk("s1", interrupted(companion.load(read_queue(FILE, "q.txt"), store=True), at))


def test_a_board_that_kept_something_else_is_not_believed():
    def board_that_lies(data):
        line = data.removesuffix(b"\r")
        answers = {
            b"cc": b"a sprf\t\t200\r\n",
            b"vd": b"0\t0\r\n",
            b"q": b"".join(b"%d\t200\t CW\t100\t3000\t 1.00\t1.00\t0\t  0\r\n" % n for n in range(1, 31)),
        }
        return line + b"\r\n" + answers.get(line, b"") + b"SAC>"

    with pytest.raises(DialogueError, match="the board does not have what was sent:\nrow 1: "):
        played(companion.load(read_queue(FILE, "q.txt"), store=True), board_that_lies)


def test_characters_lost_on_the_line_stop_it():
    def deaf(data):
        line = data.removesuffix(b"\r").replace(b"m", b"", 1)
        answers = {b"cc": b"a sprf\t\t200\r\n", b"vd": b"0\t0\r\n"}
        return line + b"\r\n" + answers.get(line, b"") + b"SAC>"

    with pytest.raises(DialogueError, match=r'row 1 of 30: "q1m800.*" came back as "q1800'):
        played(companion.load(read_queue(FILE, "q.txt"), store=False), deaf)


def test_a_queue_file_keeps_where_its_rows_stand():
    swapped = b"".join(f"{line}\r\n".encode() for line in [LINES[1], LINES[0], *LINES[2:]])
    read = read_queue(swapped, "q.txt")
    assert isinstance(read, QueueFile)
    assert read.where[:2] == ["q.txt:2", "q.txt:1"]
    assert [row.position for row in read.rows] == list(range(1, 31))
