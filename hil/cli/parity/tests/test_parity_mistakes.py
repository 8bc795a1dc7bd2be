"""Mistakes of ``hil parity`` that are said before anything is sent, its list, and its table."""

import json
import os
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

from hil.cli.framework.command_group import app
from hil.cli.framework.shown_view import ShownView
from hil.cli.parity.board_port import refuse_port
from hil.cli.parity.parity_views import PlayedSession, score_words, session_blocks, shown
from hil.testing.parity.parity_scores import scored
from hil.testing.parity.typed_session import StepAnswer, typed_session

TABLE = r"""mine: 0 of 2 commands equal, 76.7 %; times within 24.0 ms (p95)
                      first  first  first   last  last    last  stands  stands  stands
                      board   twin   late  board  twin    late   board    twin    late
    command  bytes       ms     ms     ms     ms    ms      ms      ms      ms      ms   score
 1  "a b\r"  90.0 %     2.0    1.0   +0.0   30.0   5.0  +24.0!       -       -       -  86.7 %
   parts at byte 7: expected "two\r\n", got "twO\r\n"
   last byte: 24.0 ms later than the twin, more than 20 ms
   the board                                        the twin
   one\r\n                                          one\r\n
   twO\r\n                                        | two\r\n
 2  go\r     1 equal    4.0    1.0   +2.0    5.0   2.0    +2.0    99.0   never       !  66.7 %
   end of motion: the twin did not stand within 0.005 s
  The quickest answer came 1.0 ms after the twin's: that is host and adapter, and not counted.
  Broken off at command 2 of 2: gone
  Recorded: r.json
"""
SAC = {"profile": "sac", "moves": False, "steps": [{"types": "vd\r", "for_ms": 10}]}


def said(*words: str) -> tuple[int, str]:
    done = CliRunner().invoke(app, ["parity", *words])
    return done.exit_code, done.output


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("", "name a session or a board; `hil parity --list` lists them"),
        ("sac", "--at says where the board is"),
        ("sac/moves --at /dev/null", "sac/moves may turn the shaft: --moves types them too"),
        ("sac/identfy --at x", """no session 'sac/identfy'; did you mean "sac/identify"?"""),
        ("nowhere.json --at x", "nowhere.json: No such file or directory"),
        ("uno --at x", "uno has no sessions; there are mechaduino/angle, "),
        ("sac/identify --profile nobody --at x", "no board 'nobody'; there are "),
        (
            "sac/identify mechaduino/menu --at x",
            "is a session of a mechaduino, and sac/identify one of a sac",
        ),
        ("mechaduino/menu --profile sac --at x", "is a session of a mechaduino, and --profile says sac"),
        ("sac --at /dev/nothing", "/dev/nothing: No such file or directory; "),
        ("sac --at .", ". is no serial port; "),
        ("sac --at /dev/null", "/dev/null is no serial port; "),
        ("sac --at socket://localhost:1", "nobody listens there"),
        ("sac --at telepathy://here", "protocol 'telepathy' not known"),
        ("sac --at /dev/null --baud 3", "write at least 50"),
        (
            "sac --at /dev/null --tolerance soon",
            "--tolerance soon: this is no time; write a number and s, ms, us or min",
        ),
        ("sac --at /dev/null --record /proc/nothing/x.json", "--record /proc/nothing/x.json: "),
    ],
)
def test_a_mistake_is_said_before_anything_is_sent(
    words: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    code, output = said(*words.split())
    assert code == 2
    assert message in output


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("[]", "a session is a JSON object"),
        ("{", "this is not JSON in UTF-8"),
        ("{}", "it has no steps: a session from a board's power-up on is played by"),
        (json.dumps({**SAC, "moves": "often"}), "moves: Input should be a valid boolean"),
        (json.dumps({**SAC, "profile": "nobody"}), "there is no board 'nobody'"),
        (json.dumps({**SAC, "board": {"nose": 1}}), "nose"),
        (json.dumps({**SAC, "profile": "easydriver"}), "a easydriver has no serial port"),
    ],
)
def test_a_file_that_is_no_session(content: str, message: str, tmp_path: Path) -> None:
    file = tmp_path / "s.json"
    file.write_text(content)
    end, own = os.openpty()
    try:
        code, output = said(str(file), "--at", os.ttyname(own))
    finally:
        os.close(end)
        os.close(own)
    assert code == 2
    assert message in output


def test_a_folder_without_sessions(tmp_path: Path) -> None:
    assert said(str(tmp_path), "--at", "x") == (2, f"hil: {tmp_path}: there is no session in it (*.json)\n")


def test_a_recording_never_takes_the_place_of_its_session(tmp_path: Path) -> None:
    file = tmp_path / "s.json"
    file.write_text(json.dumps(SAC))
    for record in (file, tmp_path):
        code, output = said(str(file), "--at", "/dev/null", "--record", str(record))
        assert code == 2
        assert "is the session itself" in output


@pytest.mark.skipif(os.geteuid() == 0, reason="root may open each port")
def test_a_port_without_rights_says_whose_it_is(capsys: pytest.CaptureFixture[str]) -> None:
    end, own = os.openpty()
    name = os.ttyname(own)
    Path(name).chmod(0)
    try:
        with pytest.raises(typer.Exit):
            refuse_port(name)
    finally:
        os.close(end)
        os.close(own)
    assert f"hil: {name}: you may not open it; it belongs to " in capsys.readouterr().err


def test_the_list_says_what_moves() -> None:
    code, output = said("--list", "--json")
    rows = {row["session"]: row for row in json.loads(output)}
    assert code == 0
    assert [name for name, row in rows.items() if not row["moves"]] == [
        "mechaduino/angle", "mechaduino/menu", "sac/identify", "sac/settings"
    ]  # fmt: skip
    assert all(row["commands"] and row["about"] for row in rows.values())
    code, output = said("--list", "sac/moves")
    assert output.startswith("sac/moves: 15 commands, MAY TURN THE SHAFT. ")


def test_a_board_of_ones_own_has_its_sessions(tmp_path: Path) -> None:
    assert CliRunner().invoke(app, ["profile", "new", "pinger", "--folder", str(tmp_path)]).exit_code == 0
    (tmp_path / "pinger" / "sessions").mkdir()
    (tmp_path / "pinger" / "sessions" / "all.json").write_text(json.dumps({**SAC, "profile": "pinger"}))
    code, output = said("--list", "--folder", str(tmp_path), "--profile", "pinger")
    assert (code, output) == (0, "pinger/all: 1 command. \n")


def played(board: list[StepAnswer], twin: list[StepAnswer], **keys: Any) -> PlayedSession:
    steps = [
        {"types": "a b\r", "for_ms": 10},
        {"types": "go\r", "for_ms": 10, "stands": {"shows": "!", "within_ms": 5}},
    ]
    session = typed_session({**SAC, "steps": steps})
    score = scored(session, board, twin, lambda line: False, 20.0)
    return PlayedSession(name="mine", session=session, score=score, **keys)


def test_the_table() -> None:
    board = [StepAnswer("one\r\ntwO\r\n", 2.0, 30.0), StepAnswer("x", 4.0, 5.0, 99.0)]
    twin = [StepAnswer("one\r\ntwo\r\n", 1.0, 5.0), StepAnswer("x", 1.0, 2.0)]
    view = ShownView(*session_blocks(played(board, twin, broken="gone", recording=Path("r.json")), True))
    assert [each.rstrip() for each in str(view).splitlines()] == TABLE.splitlines()


def test_a_sum_of_several() -> None:
    same = [StepAnswer("x", 1.0, 2.0), StepAnswer("!", 1.0, 2.0, 3.0)]
    other = [StepAnswer("y", 1.0, 2.0), StepAnswer("!", 1.0, 2.0, 3.0)]
    both = [played(same, same), played(same, other)]
    assert score_words(both) == "3 of 4 commands equal, 87.5 %; times within 0.0 ms (p95)"
    assert [each.is_equal for each in both] == [True, False]
    assert not played(same, same, broken="gone").is_equal


def test_what_is_typed_is_shown_in_a_line() -> None:
    assert shown("a\\b\r\n\x12é") == "a\\\\b\\r\\n\\x12é"
