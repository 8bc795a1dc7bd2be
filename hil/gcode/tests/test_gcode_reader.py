"""Reader of a program's text: to motions in machine coordinates, or to all its problems with their places."""

import pytest

from hil.gcode.canonical import (
    Arc,
    Dwell,
    End,
    Feed,
    Message,
    PathMode,
    Pause,
    Point,
    Program,
    Settings,
    Straight,
    Switch,
    TextPlace,
)
from hil.gcode.interpreter import MOST_REMARKS
from hil.gcode.reader import MOST_PROBLEMS, read_program


def read(*lines: str, settings: Settings | None = None) -> Program:
    return read_program(("\n".join(lines) + "\nM2\n").encode(), settings)


def ends(program: Program) -> list[tuple[float, ...]]:
    assert program.problems == ()
    return [tuple(motion.end[:3]) for motion in program.motions if isinstance(motion, Straight | Arc)]


def problems(*lines: str) -> list[tuple[int, int, str]]:
    return [(each.line, each.column, each.message) for each in read(*lines).problems]


def test_a_program_is_motions_in_order() -> None:
    program = read("G21 G90", "M3 S1000", "G0 X10", "G1 X10 Y5 F120", "G4 P1.5", "G64 P0.1", "M1")
    feed = Feed("per_minute", 120)
    assert program.problems == ()
    assert program.motions == (
        Switch(TextPlace(2, 1), "spindle", "cw", 1000),
        Straight(TextPlace(3, 1), True, Point(10), None),
        Straight(TextPlace(4, 1), False, Point(10, 5), feed),
        Dwell(TextPlace(5, 1), 1.5),
        PathMode(TextPlace(6, 1), "blend", 0.1),
        Pause(TextPlace(7, 1), True),
        Switch(TextPlace(8, 1), "spindle", "off", 0),
        End(TextPlace(8, 1)),
    )
    assert program.line_count == 8


def test_arcs_have_their_centre_in_the_machine() -> None:
    arc = Arc(TextPlace(3, 3), "xz", Point(22, 3, 10), (5, 17), -2, Feed("per_minute", 100))
    program = read("G0 X12 Z0", "G18 F100 G91", "Y3G2 X10 Z10 I5 K5 P2")
    assert program.motions[1] == arc._replace(place=TextPlace(3, 3))


def test_a_motion_stands_where_its_word_is() -> None:
    program = read("G0", "  N10 (one) X1 Y1", "n20 y2 g 0 1 f9")
    assert [motion.place for motion in program.motions[:2]] == [TextPlace(2, 13), TextPlace(3, 8)]


def test_inches_become_millimetres_and_angles_stay() -> None:
    program = read("G20", "G1 F10 X1 A90", "A180", "G21 X0")
    assert [motion.end[:4] for motion in program.motions[:3]] == [
        (25.4, 0, 0, 90),
        (25.4, 0, 0, 180),
        (0, 0, 0, 180),
    ]
    feeds = [motion.feed for motion in program.motions[:3]]
    assert feeds == [Feed("per_minute", 254), Feed("per_minute", 10), Feed("per_minute", 254)]


def test_axes_beside_the_first_ones() -> None:
    program = read("G20 G10 L2 P1 U1", "G0 U1 V2 W5 B4 C5")
    assert program.motions[0] == Straight(
        TextPlace(2, 1), True, Point(0, 0, 0, 0, 4, 5, 50.8, 50.8, 127), None
    )


def test_the_machine_is_where_its_state_says() -> None:
    parameters = {5161: 1.0, 5220: 2.0, 5241: 100.0, 5210: 1.0, 5211: 0.5}
    settings = Settings(position=Point(7, 8, 9), parameters=parameters)
    assert ends(read("G0 X1", "G28", settings=settings)) == [(101.5, 8, 9), (1, 0, 0)]
    assert ends(read("G91 G0 X1", settings=settings)) == [(8, 8, 9)]


def test_the_caller_keeps_its_parameters() -> None:
    parameters = {5221: 1.0}
    read("G10 L2 P1 X5", settings=Settings(parameters=parameters))
    assert parameters == {5221: 1.0}


def test_block_delete() -> None:
    lines = ("G0 X1", "/ X2 (MSG,two)", "X3 /X4")
    kept = read(*lines)
    assert [(each.line, each.column) for each in kept.problems] == [(3, 4)]
    skipped = read(*lines[:2], settings=Settings(is_block_delete=True))
    assert ends(skipped) == [(1, 0, 0)]
    assert not any(isinstance(motion, Message) for motion in skipped.motions)


def test_what_is_off_is_not_switched_off_again() -> None:
    program = read("M5 M9", "M8", "M7", "M9", "M9", "M4", "S5", "M6", "M8")
    switches = [each[1:] for each in program.motions if isinstance(each, Switch)]
    assert switches == [
        ("flood", "on", None),
        ("mist", "on", None),
        ("flood", "off", None),
        ("mist", "off", None),
        ("spindle", "ccw", 0),
        ("spindle", "ccw", 5),
        ("spindle", "off", 0),
        ("flood", "on", None),
        ("flood", "off", None),
    ]


def test_messages_and_tools() -> None:
    program = read("(MSG, Clamp it)(msg,twice)", "T3 M6", "(other)")
    assert program.motions[:4] == (
        Message(TextPlace(1, 1), "Clamp it"),
        Message(TextPlace(1, 16), "twice"),
        Message(TextPlace(2, 4), "change to tool 3"),
        Pause(TextPlace(2, 4), False),
    )


def test_every_problem_has_its_place() -> None:
    found = read("G1 X10", "G0 X1 Q2", "G0 X[1/0] Y#<a>", "G2 X1 I9 F5", "M17", "G0 X1 (c")
    assert [(each.line, each.column) for each in found.problems] == [
        (1, 1),
        (2, 7),
        (3, 7),
        (3, 12),
        (5, 1),
        (6, 7),
    ]
    assert found.motions == ()
    assert all(each.remedy and each.message and each.file == "program" for each in found.problems)


def test_what_follows_from_a_problem_is_not_one_more() -> None:
    assert len(problems("G1 X1", "X2", "X3")) == 1
    assert len(problems("G1 X! F100", "X2", "X3")) == 1
    assert len(problems("#<a> = ]", "G0 X#<a>")) == 1
    assert len(problems("G77 X1", "X2")) == 1
    assert (
        len(problems("G1 X10 Y10", "G2 X20 Y10 R2")) == 2
    )  # where the axes are is known in spite of the first
    assert len(problems("G0 X[1/0]", "G2 X5 I1 F100", "G0 X0 Y0", "G2 X5 I1")) == 2


def test_columns_count_characters_of_the_line() -> None:
    assert problems("(ä) G0 (b) X 1 . 5 ; c", "G0  X1\tY2 Y3") == [(2, 11, "Y stands twice in the line")]
    assert problems("/ N5 G0 Q1") == [(1, 9, "nothing takes Q")]


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        (b"", (1, 1), "the program has no end"),
        (b"G0 X1\nG1 X2 F1", (2, 9), "the program has no end"),
        (b"%\nG0 X1\n", (2, 6), "the program has no end"),
        ("G0 X1\nM2\n".encode("utf-16"), (1, 1), "the file is UTF-16"),
        ("G0 X1\nM2\n".encode("utf-16-le"), (1, 2), "the file has a byte 0: it is binary or UTF-16"),
        (b"G0 X1\nG0 \0 X\nM2", (2, 4), "the file has a byte 0: it is binary or UTF-16"),
        (b"G0 X1 \xe4\nM2\n", (1, 7), "the byte 0xe4 is not UTF-8 text"),
        (b"G0 X1\n" + b"X" * 1_000_000 + b"\nM2\n", (2, 257), "the line has 1000000 characters"),
        (b"G0 X1\r5\nM2\n", (1, 6), "no word begins with '\\r'"),
        (b"G0 X1,5\nM2\n", (1, 6), "no word begins with ','"),
        (b"G0 X" + b"[" * 60 + b"1" + b"]" * 60 + b"\nM2\n", (1, 45), "brackets are more than 40 deep"),
        (b"G0 X" + b"#" * 200 + b"1\nM2\n", (1, 46), "brackets are more than 40 deep"),
    ],
)
def test_files_that_are_no_program(text: bytes, place: tuple[int, int], message: str) -> None:
    problem = read_program(text, Settings("a.ngc")).problems[0]
    assert ((problem.line, problem.column), problem.message) == (place, message)
    assert str(problem).startswith(f"a.ngc:{place[0]}:{place[1]}: ")


@pytest.mark.parametrize(
    "text",
    [
        b"G0 X1\r\nX2\r\nM2\r\n",
        b"G0 X1\rX2\rM2",
        b"\xef\xbb\xbfG0 X1\nX2\nM30 ignored",
        b"%\nG0 X1\nX2\n%\n]]] not read",
        b"\n \n % \nG0 X1 (\xe4)\nX2\n%",
        b"G0 X1\nX2\nM2\n]]] not read\n",
        b"%\nO1234 (a name)\nG0 X1\nX2\nM30\n%",
    ],
)
def test_files_that_are_one(text: bytes) -> None:
    if b"ignored" in text:
        text = text.replace(b" ignored", b"")
    assert ends(read_program(text)) == [(1, 0, 0), (2, 0, 0)]


def test_a_file_that_is_no_program_at_all_ends_early() -> None:
    program = read_program(b"hello world\n" * 5000)
    assert len(program.problems) == MOST_PROBLEMS
    assert program.motions == ()


def test_the_nearest_word_is_offered() -> None:
    assert "G61.1" in read("G61.2").problems[0].remedy
    assert "COS" in read("G0 X COSS[0]").problems[0].remedy


def test_remarks_say_what_is_done_otherwise_than_meant() -> None:
    program = read("G20 F10 G1 X1", "M49")
    assert program.problems == ()
    assert [(each.line, each.column) for each in program.remarks] == [(1, 5), (2, 1)]
    assert read("G21 F10 G1 X1").remarks == ()


def test_a_comment_does_not_join_what_it_parts() -> None:
    assert problems("G0 X1(c)2") == [(1, 9, "no word begins with '2'")]
    assert problems("G0 X(c)1", "G0 X[1 (c) + 2]") == [
        (1, 5, "a comment stands inside a word"),
        (2, 8, "a comment stands inside a word"),
    ]


def test_messages_do_not_command_a_terminal() -> None:
    assert read("(MSG, a\x1b[2Jb\x07)").motions[0] == Message(TextPlace(1, 1), "a\ufffd[2Jb\ufffd")


def test_an_axis_that_goes_nowhere_stays() -> None:
    """A remainder of a millionth of a millionth would be a path of its own to a plan."""
    program = read("G0 X76.2", "G20", "G1 F10 X3 A90", "G3 X3 Y0 I1", "G91 G1 A5 X[0.1 + 0.2 - 0.3]")
    first, turn, whole, last = program.motions[:4]
    assert turn.end.x == first.end.x == whole.end.x == last.end.x
    assert turn.feed == last.feed == Feed("per_minute", 10)
    assert whole.feed == Feed("per_minute", 254)


def test_a_motion_off_gives_way_to_a_motion() -> None:
    assert ends(read("G0 G17 G21 G40 G49 G80 G90 G94", "X1")) == [(1, 0, 0)]
    assert problems("G0 X1", "G80", "X2") == [(3, 1, "axis words without a motion")]


def test_an_arc_of_almost_no_angle_is_no_whole_circle_silently() -> None:
    message = "the arc ends almost where it begins: a whole circle, or none?"
    assert problems("F9 G2 X0 Y0.000001 I5") == [(1, 4, message)]
    assert problems("F9 G2 X0 Y0 I5", "G3 Y0.000001 I5") == []
    assert problems("F9 G3 X0.000001 R5") == [(1, 4, message)]


def test_the_number_of_a_program_stands_alone() -> None:
    assert read("O1234", "N5 o7 (name)").problems == ()
    for line in ("G0 O5", "#<a>=1 O5", "O5 G0", "O<sub> call"):
        assert "O words" in read(line).problems[0].message
        assert read(line).motions == ()


def test_what_is_behind_the_end_is_not_read_and_said() -> None:
    program = read("G0 X1", "M2", "", " X2", "X3")
    assert ends(program) == [(1, 0, 0)]
    assert [(each.line, each.column) for each in program.remarks] == [(4, 2)]
    assert read_program(b"%\nM30\n%\n\n").remarks == ()


def test_remarks_have_an_end() -> None:
    assert len(read(*["M49"] * 3000).remarks) == MOST_REMARKS
