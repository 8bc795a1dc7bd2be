"""Texts of a SAC as data: its screens, files of its companion, rows of a spreadsheet."""

import json
import re
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from device_profiles.sac.readers import READERS
from hil.testing import Bench
from hil.vocab.dialogue import DialogueError, Refusal

# Rows in the form in which the companion program saves them.
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
FILE = "".join(f"{line}\r\n" for line in LINES)
ROW_5 = {
    "steps": 200,
    "is_ccw": False,
    "is_full": False,
    "rpm": 999,
    "cycle_us": 300,
    "is_linear": True,
    "acc_hundredths": 5,
    "dec_hundredths": 1230,
    "extra_pulses": 255,
    "is_sync": True,
    "wait_us": 4294967295,
}


def read(reader, text, file=""):
    data = READERS[reader](text, file)
    return json.loads(json.dumps(data))


def refusal(reader, text, file=""):
    with pytest.raises((DialogueError, Refusal)) as caught:
        READERS[reader](text, file)
    return str(caught.value).split("\n")


# ---- files ----


def test_a_long_file_is_told_as_moves():
    moves = read("long_file", "200\n" + FILE * 3, "long.txt")["moves"]
    assert len(moves) == 90
    assert moves[:2] == ["m800v150a1d1l0fu0t3000", "m-600v50a1d1l0fu0t3000"]
    assert moves[4] == "m200v999a.05d12.3l1pu255st4294967295"
    assert refusal("long_file", "200\n" + FILE.replace(" 600 ", " x "), "long.txt") == [
        'long.txt:2:6: steps is "x"; write a whole number'
    ]
    assert refusal("long_file", "400\n" + FILE, "long.txt")[0].startswith(
        "long.txt:1:1: RPM 150 and cycle 2000"
    )
    assert refusal("long_file", "0\n" + FILE, "long.txt") == ["long.txt: no motor has '0' steps a turn"]


def test_rows_of_a_file_are_told_in_the_queue_s_order():
    rows = read("queue", FILE, "q.txt")["rows"]
    assert (len(rows), rows[4]) == (30, ROW_5)
    assert read("queue", "\xef\xbb\xbf" + FILE)["rows"] == rows
    swapped = "".join(f"{line}\r\n" for line in [LINES[1], LINES[0], *LINES[2:]])
    assert read("queue", swapped)["rows"] == rows
    lenient = FILE.replace("\r", "").replace(" ", "").replace(",.5,", ",0.50,")
    assert read("queue", lenient)["rows"] == rows


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (
            " 3 , 5\xc3\xa9 , 0 ",
            "q.txt:3:7: the byte 0xc3 is not ASCII text; take it out",
        ),
        (
            " 3 , 5 , 2 , 1 , 150 , 2000 , 0 , 1 , 1 , 0 , 0 , 0 ",
            "q.txt:3:10: direction is 2; 1 is the largest",
        ),
        (
            " 3 , 5 , 0",
            "q.txt:3:1: 3 numbers; a row has 12: position, steps, direction, full step, RPM, cycle, ramp,"
            " acc, dec, u, sync, deltaT",
        ),
    ],
)
def test_a_bad_row_is_told_with_its_place(line, message):
    assert refusal("queue", FILE.replace(LINES[2], line), "q.txt")[0] == message


def test_a_file_that_is_cut_off_is_refused_wherever_the_cut_is():
    cut = "the file ends in the middle of this row; it was cut off, copy it again"
    for length in range(0, len(FILE) - 3, 13):
        assert re.match(r"q\.txt:\d+:\d+: .", refusal("queue", FILE[:length], "q.txt")[0])
    assert refusal("queue", FILE[:-3], "q.txt")[0] == f"q.txt:30:{len(LINES[29])}: {cut}"
    assert refusal("queue", f"{LINES[0]}\r\n 2 , 60", "q.txt")[0] == f"q.txt:2:8: {cut}"
    after_2 = refusal("queue", f"{LINES[0]}\r\n{LINES[1]}\r\n", "q.txt")[0]
    assert after_2.startswith("q.txt:2:1: no row for position 3, 4,")
    assert len(read("queue", FILE[:-2])["rows"]) == 30


def test_what_is_no_such_file_is_refused():
    too_long = "q.txt:1:1: 100,001 bytes; a file of the companion has some thousand"
    assert refusal("queue", "\0" * 100_001, "q.txt") == [too_long]
    assert len(refusal("queue", "\x89P\0\xff", "p.png")) == 3
    assert len(refusal("queue", "\0" * 99, "p.png")) == 10


SHOTS = "xm1200v150ad\r\n\r\nv159\r\nxm400ads\r\n" + "\r\n" * 95 + "xm400v200\r\n"


def test_one_shots_are_a_hundred_lines():
    lines = read("one_shots", SHOTS)["lines"]
    assert (len(lines), lines[:3], lines[99]) == (100, ["xm1200v150ad", "", "v159"], "xm400v200")
    assert read("one_shots", "v1\r\nv2\r\n")["lines"] == ["v1", "v2"] + [""] * 98


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "xm1200v150ad\r\n\r\nv15",
            "o.txt:3:4: the file ends in the middle of one-shot 3; it was cut off, copy it again",
        ),
        ("", "o.txt:1:1: the file is empty"),
        (f"v1\r\n{'m' * 81}\r\n", "o.txt:2:81: 81 characters; a board takes 80 a line"),
        ("\r\n" * 100 + "v1\r\n", "o.txt:101:1: a command behind the last; a file has 100"),
        ("v1\r\nv\t2\r\n", "o.txt:2:2: a TAB; a command has printable characters only"),
        ("v\x1b[2J\r\n", "o.txt:1:2: the byte 0x1b is not ASCII text; take it out"),
        ("\x89" * 100_001, "o.txt:1:1: 100,001 bytes; a file of the companion has some thousand"),
    ],
)
def test_one_shots_that_no_board_takes_are_refused(text, message):
    assert refusal("one_shots", text, "o.txt") == [message]


def test_rows_are_pasted_from_a_file_or_a_spreadsheet():
    text = "".join(f"{line}\r\n" for line in FORM[3:])
    assert read("pasted", text)["rows"] == read("queue", FILE)["rows"][3:5]
    assert read("pasted", text.replace(" , ", "\t")) == read("pasted", text)
    assert refusal("pasted", "\nhello")[0].startswith("line 2, column 1: 1 numbers; a row has 12")
    assert refusal("pasted", f"{FORM[0]}\n{FORM[1].replace(' 600 ', ' x ')}") == [
        'line 2, column 6: steps is "x"; write a whole number'
    ]
    assert refusal("pasted", " \n") == ["there are no rows in the clipboard"]


# ---- screens ----

RULE = "=" * 70
LISTING = [
    "Q\tSteps\t\tRPM\tCycle\t Acc\tDec\tusteps\t deltaT",
    RULE,
    "1\t800\t CW\t150\t2000\t 1.00\t1.00\t0\t  3000",
    "2\t600\t+CCW\t69\t4321\t*10.47\t0.50\t255\ts 4294967295",
    *(f"{n}\t200\t CW\t100\t3000\t 1.00\t1.00\t0\t  0" for n in range(3, 31)),
    RULE,
    "Q is at 7\t+ pulse \t\t* linear\t\ts sync",
]


def test_a_listing_is_read():
    data = read("q", "\n".join(LISTING))
    assert (len(data["rows"]), data["at"]) == (30, 7)
    assert data["rows"][1] == {
        **{"steps": 600, "is_ccw": True, "is_full": False, "rpm": 69, "cycle_us": 4321, "is_linear": True},
        **{"acc_hundredths": 1047, "dec_hundredths": 50, "extra_pulses": 255, "is_sync": True},
        "wait_us": 4294967295,
    }


def test_debug_s_first_entry_is_passed_over_and_a_gap_is_told():
    debug = [*LISTING[:2], LISTING[4].replace("3", "0", 1), *LISTING[2:]]
    assert read("q", "\n".join(debug)) == read("q", "\n".join(LISTING))
    without_5 = [line for line in LISTING if not line.startswith("5\t")]
    garbled = [line.replace("\t100\t", "\t1..0\t").replace("1.00", "1..0") for line in LISTING]
    for lines, message in (
        (without_5, "row 5 is missing in the listing"),
        (LISTING[:20], "the listing has 18 rows that can be read, not 30"),
        (garbled, "row 1 is missing in the listing"),
        (LISTING[:-1], "the listing does not say where the queue is"),
    ):
        assert refusal("q", "\n".join(lines)) == [message]


def test_configuration_session_and_speed_are_read():
    screen = (
        "Config:\nA autorun\t0\ta sprf\t\t400\nE network\t0\te dec\t\t1.00\nH ihd\t\t8\th ops\t\t100100\n"
        "I xclk\t\t3\ti soft_ops\t0\nJ ustep\t\t2\tj ACK\t\t1\nL slow\t\t10"
    )
    assert read("cc", screen) == {
        "steps_per_rev": 400,
        "microstep_exponent": 2,
        "interrupt_overhead_us": 8,
        "clock_correction_us": 3,
        "slow_rpm": 10,
        "is_network_swapped": False,
    }
    assert read("cc", screen.replace("network\t0", "network\t1"))["is_network_swapped"]
    for bad in ("login:", screen.replace("\t400", "\t0"), screen.replace("\t400", "\t" + "9" * 5000)):
        assert refusal("cc", bad)
    assert read("cf", "v\t100\nsoft_ops\t1\n?") == {"v": "100", "soft_ops": "1"}
    assert read("vd", "150\t2000") == {"rpm": 150, "period_us": 2000}
    assert refusal("vd", "what") == ["this is no speed: 'what'"]


def test_screens_of_a_twin_are_read():
    bench = Bench({"bench": "readers", "devices": {"s1": {"profile": "sac"}}})
    bench.run(ms=1500)

    def shown(line):
        bench.port("s1").read()
        bench.port("s1").write(f"{line}\r".encode())
        bench.run(ms=600)
        text = bench.port("s1").read().decode("latin-1")
        return read(line, "\n".join(text.split("\r\n")[1:-1]))

    assert (len(shown("q")["rows"]), shown("q")["at"]) == (30, 1)
    assert shown("cc")["steps_per_rev"] == 200
    assert shown("cf")["soft_ops"] == "0"
    assert shown("vd") == {"rpm": 0, "period_us": 0}


@pytest.mark.long
@given(
    st.sampled_from([FILE, SHOTS, "\n".join(LISTING)]), st.lists(st.tuples(st.integers(0, 1500), st.text()))
)
def test_any_text_is_data_or_refused(text, changes):
    for place, what in changes:
        text = text[:place] + what + text[place + len(what) :]
    for reader in READERS.values():
        with suppress(DialogueError, Refusal):
            json.dumps(reader(text, "any.txt"))
