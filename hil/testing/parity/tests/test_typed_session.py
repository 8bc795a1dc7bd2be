"""Sessions by steps as files: mistakes with their places, recordings, and those that are shipped."""

import json
from pathlib import Path
from typing import Any

import pytest

import device_profiles
from hil.testing import SessionRefused, play
from hil.testing.parity.twin_player import twin_answers
from hil.testing.parity.typed_session import as_text, recording_of, typed_session

SHIPPED = sorted(Path(device_profiles.__path__[0]).glob("*/sessions/*.json"))
STEP = {"types": "vd\r", "for_ms": 200}
SESSION = {"profile": "sac", "moves": False, "steps": [STEP]}


def recorded(session: dict[str, Any]) -> dict[str, Any]:
    """A session with the twin's answers."""
    typed = typed_session(session)
    text = as_text(recording_of(typed, twin_answers(typed), "the twin", 0.0, 20.0))
    kept: dict[str, Any] = json.loads(text)
    return kept


def played(tmp_path: Path, session: dict[str, Any], **options: Any) -> list[str]:
    file = tmp_path / "s.json"
    file.write_text(json.dumps(session))
    return [str(each) for each in play(file, **options)]


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"moves": None}, "moves: Input should be a valid boolean"),
        ({"steps": []}, "steps: .* at least 1 item"),
        ({"steps": [STEP, {"types": "x"}]}, "step 2.for_ms: this is missing"),
        ({"steps": [{**STEP, "fro_ms": 1}]}, "step 1.fro_ms: there is no such key"),
        ({"steps": [{**STEP, "types": "€"}]}, r"step 1.types: one character is one byte"),
        ({"steps": [{**STEP, "types": ""}]}, "step 1.types: .* at least 1 character"),
        ({"steps": [{**STEP, "for_ms": -1}]}, "step 1.for_ms: .* greater than 0"),
        ({"steps": [{**STEP, "for_ms": float("nan")}]}, "step 1.for_ms: .* finite"),
        ({"steps": [{**STEP, "stands": {"shows": "x"}}]}, "step 1.stands.within_ms: this is missing"),
        ({"measured": {"v ": {"within": -1}}}, "measured.v .within: .* greater than or equal to 0"),
        ({"steps": [{**STEP, "for_ms": 0}], "extra": 1}, "step 1.for_ms.*; extra: there is no such key"),
    ],
)
def test_mistakes_are_said_with_their_places(keys: dict[str, Any], said: str) -> None:
    with pytest.raises(SessionRefused, match=said):
        typed_session(SESSION | keys)


def test_a_recording_of_the_twin_is_as_it_was(tmp_path: Path) -> None:
    session = recorded(SESSION)
    assert session["steps"][0]["answer"] == "vd\r\n0\t0\r\nSAC>"
    assert played(tmp_path, session) == []
    assert played(tmp_path, session, profile="sac") == []


def test_what_a_recording_has_otherwise_is_said(tmp_path: Path) -> None:
    session = recorded(SESSION)
    session["steps"][0]["answer"] = "vd\r\n5\t0\r\nSAC>"
    session["steps"][0]["last_ms"] += 25
    assert played(tmp_path, session) == [
        "s: command 1, byte 4: expected '5\\t0\\r\\n', got '0\\t0\\r\\n'",
        "s: command 1, last byte: expected '28.646 ms', got '3.646 ms'",
    ]
    assert len(played(tmp_path, session, tolerance_ms=25.1)) == 1


def test_a_motion_that_never_ended_is_said(tmp_path: Path) -> None:
    stands = {"types": "vd\r", "shows": "\r\n0\t0\r\n", "within_ms": 3000}
    session = recorded({**SESSION, "steps": [{**STEP, "types": "xm20v60a0d0u0f\r", "stands": stands}]})
    assert played(tmp_path, session) == []
    del session["steps"][0]["stood_ms"]
    assert played(tmp_path, session) == ["s: command 1, end of motion: expected 'never', got 'in its time'"]


@pytest.mark.parametrize(
    ("session", "options", "said"),
    [
        (SESSION, {}, "step 1: it has no answer: this is no recording"),
        (SESSION, {"profile": "mechaduino"}, "it is a session of a sac, no mechaduino"),
        ({**SESSION, "profile": "nobody"}, {}, "it is a session of a nobody, no "),
        ({**SESSION, "board": {"baud": -3}, "steps": [{**STEP, "answer": ""}]}, {}, "its board: .*baud"),
        ({**SESSION, "moves": 3}, {}, "s.json: moves: "),
    ],
)
def test_what_is_no_recording_of_this_board(
    session: dict[str, Any], options: dict[str, Any], said: str, tmp_path: Path
) -> None:
    with pytest.raises(SessionRefused, match=said):
        played(tmp_path, session, **options)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: f"{path.parent.parent.name}/{path.stem}")
def test_what_is_shipped_is_what_the_twin_does(path: Path) -> None:
    session = typed_session(json.loads(path.read_text()))
    assert session.profile == path.parent.parent.name
    assert session.about
    assert as_text(session) == path.read_text()
    assert play(path, tolerance_ms=0.001) == []


def test_what_may_move_is_marked_and_stops() -> None:
    """Commands that turn a shaft: `c`, `s`, `y`, `j` and `a` of a Mechaduino, `m`, `x`, pulses and loops of
    a SAC."""
    moving = {"mechaduino": set("csyjarw"), "sac": {"m", "+", "-", "xm", "l"}}
    for path in SHIPPED:
        session = typed_session(json.loads(path.read_text()))
        typed = [step.types for step in session.steps]
        turns = any(each.startswith(tuple(moving[session.profile])) for each in typed)
        assert session.moves == turns, path
        assert bool(session.ends_by) == session.moves
        assert not any(
            each.startswith(("$C", "qs", "qc", "qp", "c")) for each in typed if each[:2] not in ("cf", "cc")
        ), f"{path}: it writes what lasts"


def test_there_are_sessions_for_both_boards() -> None:
    found = {(path.parent.parent.name, path.stem) for path in SHIPPED}
    assert found >= {("mechaduino", "menu"), ("mechaduino", "step_response"), ("sac", "identify")}
