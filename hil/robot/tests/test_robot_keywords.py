"""Keywords of Robot Framework: each as a suite uses it, at a bench in memory; some at one in real time."""

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("robot", reason="Robot Framework is not installed")
from robot import api

from hil.operations.table import OPERATIONS
from hil.robot.asked_keywords import KEYWORDS
from hil.robot.keyword_page import keyword_page
from hil.testing import live, served_bench

ROOT = Path(__file__).parents[3]
BENCH = """bench: t
speed: 5
devices:
  m1: {profile: mechaduino, flash: {table: identity}}
  s1: {profile: sac}
  s2: {profile: sac}
segments:
  bus0: {stations: [s1, s2], taps: {master: {port: pty}}}
"""
OF_PORTS = {"type", "send"}
NO_KEYWORD = {
    **dict.fromkeys(
        ("lease", "take_lease", "renew_lease", "give_lease", "break_lease"), "a suite's runner takes a bench"
    ),
    **dict.fromkeys(
        ("list", "verbs", "registers", "eds", "look", "packed", "read_text"), "for doors and programs"
    ),
    **dict.fromkeys(
        ("status", "health", "metrics", "segments", "buses", "about", "benches"), "reports of a daemon"
    ),
    **dict.fromkeys(("watch", "samples", "unwatch", "capture", "wait"), "streams and waits of a connection"),
    **dict.fromkeys(("reload", "stop", "part", "pause", "resume"), "the daemon itself"),
    **dict.fromkeys(
        ("past", "past_state", "past_samples", "past_bytes", "past_packets", "past_find"),
        "a daemon's recording",
    ),
    **dict.fromkeys(("run", "runs", "cancel_run", "pace_run", "drawing"), "runs: the kit has them"),
    **dict.fromkeys(
        ("processor", "load_program", "count", "counted", "debug"),
        "a program is in the configuration: `firmware:`; the others are for `hil sketch`",
    ),
    **dict.fromkeys(("events", "halt", "stop_site", "fault_places"), "for people who watch a bench"),
    **dict.fromkeys(("drive", "play", "attach", "detach", "transmit"), "rows of times or frames"),
}
"""Operations without a keyword, and why."""


class Suite:
    """Suites with one test each, run here; ``bench`` is the file of the configuration."""

    def __init__(self, folder: Path) -> None:
        self.bench = folder / "bench.yaml"
        self.bench.write_text(BENCH)

    def run(self, *tests: str, options: str = "") -> list[Any]:
        """Results of tests, each given by its rows."""
        named = (
            f"T{number}\n" + "\n".join(f"    {row}" for row in rows.strip().split("\n"))
            for number, rows in enumerate(tests)
        )
        text = f"*** Settings ***\nLibrary    hil.robot    {self.bench}    {options}\n*** Test Cases ***\n"
        suite = api.TestSuite.from_string(text + "\n".join(named))
        result = suite.run(output=None, stdout=io.StringIO(), stderr=io.StringIO())
        return list(result.suite.tests)

    def passes(self, *tests: str, options: str = "") -> None:
        for test in self.run(*tests, options=options):
            assert test.passed, test.message

    def failure(self, test: str, options: str = "") -> str:
        (result,) = self.run(test, options=options)
        assert result.failed, result.status
        message: str = result.message
        return message


@pytest.fixture
def suite(tmp_path: Path) -> Iterator[Suite]:
    return Suite(tmp_path)


def test_each_operation_is_a_keyword_or_says_why_not() -> None:
    assert KEYWORDS.keys() | OF_PORTS | NO_KEYWORD.keys() == OPERATIONS.keys()
    assert not KEYWORDS.keys() & NO_KEYWORD.keys()


def test_the_page_is_up_to_date() -> None:
    assert (ROOT / "docs/robot-keywords.md").read_text() == keyword_page(), "run: make keywords"


def test_what_is_typed_is_answered_and_no_more_time_passes(suite: Suite) -> None:
    suite.passes(
        r"""
${begin} =    Simulated Time
Type    m1    p
${line} =    Line Should Come    m1    raw encoder: \\d+    within=1 s    regexp=True
Should Be Equal    ${line}    stepNumber: 0 , Angle: 6.28, raw encoder: 286
${end} =    Simulated Time
Should Be True    0.09 < ${end} - ${begin} < 0.11
Type    s1    v\r
${all} =    Text Should Come    s1    SAC>
Should Be Equal    ${all}    v\r\nSAC>
Nothing Should Come    s1    within=100 ms
Type    s1    v\r
Pass Time    100 ms
${all} =    Read Port    s1
Should Be Equal    ${all}    v\r\nSAC>
"""
    )


def test_a_failure_shows_what_came_instead(suite: Suite) -> None:
    at = "Type    m1    p\n"
    line = "stepNumber: 0 , Angle: 6.28, raw encoder: 286"
    assert suite.failure(at + "Line Should Come    m1    Angle: 7    within=0.5 s") == (
        f"m1: no line with 'Angle: 7' within 0.5 s; what came:\n{line}"
    )
    assert suite.failure(at + "Text Should Come    m1    SAC>    200 ms") == (
        f"m1: 'SAC>' did not come within 0.2 s; what came:\n{line}"
    )
    assert suite.failure("Text Should Come    m1    SAC>    200 ms").endswith("0.2 s; nothing came")
    assert suite.failure(at + "Nothing Should Come    m1") == "m1: what came:\nstepNumber: 0 , Angle: "


def test_an_axis_reaches_or_does_not(suite: Suite) -> None:
    go = "Do Verb    m1    enable\nDo Verb    m1    move-abs    position_deg=90\n"
    suite.passes(
        go + "Axis Should Reach    m1    90    within=1 s\nPass Time    0.5 s\n"
        "Field Should Be    m1    position_deg    90    tolerance=0.2\n"
        "${state} =    Axis State    m1\nShould Be Equal As Integers    ${state}[loop_on]    1"
    )
    jam = "${fault} =    Inject Fault    m1    shaft_jam\n"
    assert suite.failure(jam + go + "Axis Should Reach    m1    90    within=0.2 s").startswith(
        "m1: position_deg is 6."
    )
    assert suite.failure("Field Should Be    m1    position_deg    90").startswith("m1: position_deg is 6.")
    suite.passes(go + "Wait Until    m1    position_deg > 89 and loop_on == 1    within=1 s")
    assert suite.failure(jam + go + "Wait Until    m1    position_deg > 89    within=0.2 s").startswith(
        "m1: position_deg > 89 did not hold within 0.2 s; position_deg 6."
    )
    assert suite.failure("Wait Until    m1    speed > 3").startswith("m1 has no field 'speed'")
    suite.passes(jam + go + "Pass Time    1 s\nClear Fault    ${fault}\nAxis Should Reach    m1    90")


def test_the_world_around_a_board(suite: Suite) -> None:
    suite.passes(
        """
Set Field    m1    load_torque_Nm    0.01
Field Should Be    m1    load_torque_Nm    0.01
Zero Axis    m1
Field Should Be    m1    position_deg    0
Set Pin    m1    D2    1
Field Should Be    m1    pin_enable    1
Open Port    m1
Power Cycle    m1
Line Should Come    m1    Mechaduino 0.X    within=5 s
Inject Fault    s1.network    packet_nak    rate=0.5    seed=3
Inject Fault    m1    byte_drop    rate=1    towards=board
${faults} =    Active Faults
Should Be Equal    ${faults}[0][parameters][rate]    ${0.5}
Clear Fault    all    on=m1
${faults} =    Active Faults
Length Should Be    ${faults}    1
Clear Fault    1
${faults} =    Active Faults
Should Be Empty    ${faults}
"""
    )


def test_packets_of_a_segment(suite: Suite) -> None:
    address = (
        "Type    s2    $CM86\\r\nText Should Come    s2    SAC>\nType    s2    $R\\r\nPass Time    1100 ms\n"
    )
    ask = "Type    bus0.master    \\x02\\x56\\x04v\\x03\\x00\nPass Time    200 ms\n"
    suite.passes(
        address
        + "Packets Should Be    bus0\n"
        + ask
        + "Packets Should Be    bus0    4 -> 86 v    86 -> 4 ACK"
    )
    assert (
        suite.failure("Packets Should Be    bus0    4 -> 86 v")
        == "bus0: not these packets; what came:\nnothing"
    )
    assert suite.failure("Packets Should Be    bus1") == (
        "there is no segment 'bus1'; did you mean \"bus0\"? there are bus0"
    )


PROGRAM = """
import sys, serial
with serial.Serial(sys.argv[1], timeout=20) as port:
    for word in sys.argv[2:]:
        port.write(word.encode())
        print(port.readline().decode(), flush=True)
sys.exit(len(sys.argv) - 2)
"""


@pytest.mark.parametrize("options", ["", pytest.param("kind=live", marks=pytest.mark.long)])
def test_a_program_at_the_bench(suite: Suite, options: str) -> None:
    program = suite.bench.parent / "asks.py"
    program.write_text(PROGRAM)
    suite.passes(
        f"Start Program    {program}    m1    p\n"
        "Program Should Say    Angle: 6.28    within=10 s\n"
        "${said} =    Program Should End    code=1\n"
        "Should Contain    ${said}    raw encoder: 286",
        f"Start Program    {program}    /dev/ttyUSB0    p    p    map={{'/dev/ttyUSB0': 'm1'}}\n"
        "Program Should End    code=2",
        options=options,
    )
    start = f"Start Program    {program}    m1    p\n"
    ended, late, other, short, none, unknown = (
        suite.failure(each, options=options)
        for each in (
            start + "Program Should Say    Angle: 7    within=30 s",
            start + "Inject Fault    m1    byte_drop    rate=1    towards=board\n"
            "Program Should Say    Angle: 6    within=1 s",
            start + "Program Should End",
            f"Start Program    {program}    s1    p\nProgram Should End    within=0.1 s",
            "Program Should End",
            "Start Program    ask.py    m1",
        )
    )
    assert ended.startswith("the program has ended with 1; what it said:\nstepNumber: 0 , Angle: 6.28")
    assert late == "'Angle: 6' did not come within 1 s; it said nothing"
    assert other.startswith("the program has ended with 1, not with 0; what it said:\nstepNumber")
    assert short.startswith("the program has not ended within 100 ms")
    assert none == "no program was started: `Start Program` comes first"
    assert unknown == "ask.py: there is no such program, here or on PATH; write its path"


def test_each_test_has_a_bench_of_its_own(suite: Suite) -> None:
    suite.passes(
        "Inject Fault    m1    shaft_jam\nPass Time    3 s",
        "${faults} =    Active Faults\nShould Be Empty    ${faults}\n${now} =    Simulated Time\n"
        "Should Be Equal As Numbers    ${now}    4",
    )


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        (
            "Type    m2    p",
            """there is no port 'm2'; there are m1, s1, s1.network, s2, s2.network, bus0.master""",
        ),
        ("Type    m1    €", "Argument 'text' got value '€' that cannot be converted to bytes"),
        (
            "Set Pin    m1    D2    high",
            "Argument 'level' got value 'high' that cannot be converted to integer.",
        ),
        ("Set Pin    m1    D9    1", "m1 has no pin 'D9'; there are"),
        ("Set Pin    m1    D2    2", "level: 2 is too large; write 0 or 1"),
        ("Pass Time    long", "Argument 'duration' got value 'long' that cannot be converted to timedelta"),
        ("Do Verb    m1    moves", "m1 has no 'moves'; "),
        ("Do Verb    m1    move_abs", "position_deg: this one is missing"),
        (
            "Do Verb    m1    move_abs    position_deg=far",
            'position_deg: "far" is no number; write -1000000 to 1000000 deg',
        ),
        ("Do Verb    m1    move_abs    position_deg=90", "the control loop is off; enable it first"),
        ("Axis State    x1", "there is no axis 'x1'; there are m1, s1, s2"),
        ("Set Field    m1    colour    3", "there is no field to set 'colour'; there are"),
        ("Field Should Be    m1    colour    3", "m1 has no field 'colour'; there are at_ns, "),
        ("Inject Fault    m1    shaft_jm", "there is no fault 'shaft_jm'; did you mean"),
        ("Clear Fault    7", "there is no fault 7; there are none"),
        (
            "Clear Fault    each",
            "Argument 'number' got value 'each' that cannot be converted to integer or 'all'",
        ),
        ("Power Cycle    m3", "there is no device 'm3'; "),
    ],
)
def test_a_slip_is_told_in_a_sentence(suite: Suite, rows: str, said: str) -> None:
    message = suite.failure(rows)
    assert said in message, message
    assert message.startswith("ValueError: Argument") or "Error:" not in message


def test_a_bad_configuration_fails_with_all_its_problems(suite: Suite) -> None:
    suite.bench.write_text("bench: t\ndevices:\n  m1: {profile: mechadunio}\n  s1: {profile: sac, port: 3}\n")
    message = suite.failure("Pass Time    1 s")
    assert f"{suite.bench}:3:17: " in message
    assert f"{suite.bench}:4:" in message
    suite.bench.unlink()
    assert "No such file or directory" in suite.failure("Pass Time    1 s")


def test_what_simulated_time_cannot_have_is_skipped(suite: Suite) -> None:
    suite.bench.write_text("bench: t\ndevices: {m1: {profile: mechaduino, at: /dev/ttyACM0}}\n")
    (result,) = suite.run("Pass Time    1 s")
    assert result.status == "SKIP"
    assert result.message.startswith("kind=virtual: real boards (at:) know no simulated time: m1")


def test_arguments_of_the_library_that_are_wrong(suite: Suite) -> None:
    assert suite.failure("Simulated Time", options="kind=vritual") == (
        "there is no kind of bench 'vritual'; did you mean \"virtual\"? there are virtual, live, real"
    )
    assert suite.failure("Simulated Time", options="seed=x") == "seed: write a whole number, not 'x'"


@pytest.mark.long
def test_the_same_keywords_in_real_time(suite: Suite) -> None:
    fine, skipped, wrong = suite.run(
        """
Type    m1    p
Line Should Come    m1    Angle: 6.28    within=10 s
Do Verb    m1    enable
Do Verb    m1    move_abs    position_deg=90
${fault} =    Inject Fault    s1    shaft_jam
Clear Fault    ${fault}
Axis Should Reach    m1    90    within=10 s
Set Pin    m1    D2    1
Field Should Be    m1    pin_enable    1
${begin} =    Simulated Time
Pass Time    1 s
${end} =    Simulated Time
Should Be True    1 <= ${end} - ${begin} < 20
""",
        "Packets Should Be    bus0",
        "Power Cycle    m3",
        options="kind=live",
    )
    assert fine.passed, fine.message
    assert skipped.status == "SKIP"
    assert skipped.message == "kind=live: packets are not kept; `hil capture` has them"
    assert wrong.message.startswith("no device 'm3'; ")
    assert served_bench.OPEN == []  # each has ended with its test


@pytest.mark.long
def test_the_same_keywords_at_a_real_board(suite: Suite, tmp_path: Path) -> None:
    desk = {"bench": "desk", "speed": 5, "devices": {"s1": {"profile": "sac"}}}
    with live(desk, capture=False) as board:
        at = board.port("s1")
        suite.bench.write_text(f"bench: rig\ndevices: {{s1: {{profile: sac, at: {at}}}}}\n")
        fine, jammed, unseen = suite.run(
            r"""
Type    s1    vd\r
Text Should Come    s1    SAC>    within=10 s
${fault} =    Inject Fault    s1    byte_drop    rate=1
Clear Fault    ${fault}
Power Cycle    s1
""",
            "Inject Fault    s1    shaft_jam",
            "Axis State    s1",
            options="kind=real",
        )
    assert fine.passed, fine.message
    assert (jammed.status, unseen.status) == ("SKIP", "SKIP")
    assert jammed.message.startswith("kind=real: s1 is real, and hil cannot give it shaft_jam")
    assert unseen.message.startswith("kind=real: s1 is a real board: the daemon sees its terminal")


@pytest.mark.long
def test_a_real_board_that_is_absent_fails_its_tests(suite: Suite) -> None:
    suite.bench.write_text("bench: rig\ndevices: {s1: {profile: sac, at: /nowhere/ttyACM7}}\n")
    assert "s1 is not there: /nowhere/ttyACM7: No such file" in suite.failure("Pass Time    1 s", "kind=real")
    suite.bench.write_text(BENCH)
    assert "no device has at:, the place of a real board" in suite.failure("Pass Time    1 s", "kind=real")
