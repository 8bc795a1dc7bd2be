"""The twin beside what the firmware itself did: sessions to the microsecond, motions bit for bit."""

import json
from pathlib import Path

import pytest

from hil.testing import SessionRefused, play, replay_motion

DATA = Path(__file__).parent / "data"
SESSIONS = sorted((DATA / "sessions").glob("*.json"))
MOTIONS = ["accel_trapezoid", "law_ellbow_back_forth", "law_hip_move30"]
US_MS = 0.001


@pytest.mark.parametrize("path", SESSIONS, ids=lambda path: path.stem)
def test_a_session_is_as_it_was(path: Path) -> None:
    assert play(path, tolerance_ms=US_MS / 2) == []


@pytest.mark.parametrize("name", MOTIONS)
def test_a_motion_is_as_it_was(name: str) -> None:
    assert replay_motion(DATA / "motion" / name) == []


def test_all_motions_of_a_folder_are_replayed() -> None:
    assert replay_motion(DATA) == replay_motion(DATA / "motion") == []


def test_a_changed_session_differs_where_it_was_changed(tmp_path: Path) -> None:
    session = json.loads((DATA / "sessions" / "get.json").read_text())
    session["timeline"][2][1] = session["timeline"][2][1].replace("-90.00", "-91.00")
    session["timeline"][4][0] += 5
    session["log"] = "log nothing\r\n"
    (tmp_path / "changed.json").write_text(json.dumps(session))
    text, late, log = play(tmp_path / "changed.json")[:3]
    assert (text.at_ms, text.where) == (session["timeline"][2][0], "command port")
    assert (late.at_ms, late.where) == (session["timeline"][4][0], "command port, time")
    assert (log.where, log.expected, log.got) == ("logger, line 1", "log nothing\r", "")


def test_a_changed_motion_differs_where_it_was_changed(tmp_path: Path) -> None:
    (tmp_path / "INDEX.json").write_text((DATA / "INDEX.json").read_text())
    for kind in ("ops", "steps"):
        name = f"accel_trapezoid_{kind}.csv"
        lines = (DATA / "motion" / name).read_text().splitlines()
        if kind == "steps":
            lines[2] = lines[2].replace(",1", ",-1")
        (tmp_path / name).write_text("\n".join(lines) + "\n")
    (found,) = replay_motion(tmp_path / "accel_trapezoid_steps.csv")
    assert (found.where, found.expected, found.got) == ("step 2", "35780 us, -1", "35780 us, +1")


@pytest.mark.parametrize(
    ("harness", "said"),
    [
        (["servo_gone"], "harness 'servo_gone' is unknown"),
        (["absent 0 7F"], "there is nothing at address 0x7F of bus 0"),
        (["joint nine 4"], "harness 'joint nine 4' cannot be read"),
    ],
)
def test_unknown_surroundings_are_refused(tmp_path: Path, harness: list[str], said: str) -> None:
    session = {"mode": "full", "harness": harness, "exchanges": [], "end_ms": 10, "timeline": []}
    (tmp_path / "s.json").write_text(json.dumps(session))
    with pytest.raises(SessionRefused, match=said):
        play(tmp_path / "s.json")


@pytest.mark.parametrize(
    ("text", "said"),
    [("nothing", "not JSON"), ("[]", "a JSON object"), ("{}", "no board reads such a session")],
)
def test_what_is_no_session_is_refused(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "s.json").write_text(text)
    with pytest.raises(SessionRefused, match=said):
        play(tmp_path / "s.json")


def test_a_motion_without_an_index_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SessionRefused, match=r"INDEX\.json"):
        replay_motion(tmp_path / "accel_trapezoid")
