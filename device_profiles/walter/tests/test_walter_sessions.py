"""The twin beside what the firmware itself did: sessions to the microsecond, motions bit for bit."""

import json
import math
import shutil
from pathlib import Path
from struct import pack
from typing import Any

import pytest

from hil.core._native import JointReplay
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


def a_case(folder: Path, about: dict[str, Any], **tables: str) -> Path:
    """A recorded motion of its own: a row of an index, and tables by their ends."""
    index = json.loads((DATA / "INDEX.json").read_text())
    index["motion"]["cases"].append(about)
    (folder / "INDEX.json").write_text(json.dumps(index))
    for end, text in tables.items():
        (folder / f"{about['name']}_{end}.csv").write_text(text)
    return folder / about["name"]


CALLS = [[0, "S", 2000], [0, "A", 4000], [0, "T", 30]]


def test_looks_for_pulses_are_as_far_apart_as_the_case_says(tmp_path: Path) -> None:
    about = {"name": "rare", "poll_us": 37, "end_ms": 1000, "ops": CALLS}
    # The first step comes 22,360 us after the start, 30 in all; looks are at multiples of 37 us.
    case = a_case(tmp_path, about, steps="t_us,dir\n22385,1\n")
    (found,) = replay_motion(case)
    assert (found.where, found.expected) == ("step 2", None)
    assert found.got is not None
    assert int(found.got.split()[0]) % 37 == 0
    (tmp_path / "rare_steps.csv").write_text("t_us,dir\n22360,1\n")
    assert replay_motion(case)[0].got == "22385 us, +1"


def test_looks_are_as_far_apart_as_the_index_says(tmp_path: Path) -> None:
    case = a_case(tmp_path, {"name": "rare", "end_ms": 30, "ops": CALLS}, steps="t_us,dir\n22400,1\n")
    index = json.loads((tmp_path / "INDEX.json").read_text())
    index["motion"]["poll_us"] = 100
    (tmp_path / "INDEX.json").write_text(json.dumps(index))
    assert replay_motion(case) == []


def test_calls_are_those_of_the_case_that_a_name_begins_with(tmp_path: Path) -> None:
    shutil.copy(DATA / "motion" / "accel_trapezoid_ops.csv", tmp_path)
    steps = (DATA / "motion" / "accel_trapezoid_steps.csv").read_text()
    case = a_case(tmp_path, {"name": "accel_trapezoid_again", "end_ms": 4000}, steps=steps)
    assert replay_motion(case) == []


def test_a_case_without_calls_is_refused(tmp_path: Path) -> None:
    case = a_case(tmp_path, {"name": "nothing", "end_ms": 10}, steps="t_us,dir\n")
    with pytest.raises(SessionRefused, match=r"there is no nothing_ops\.csv, INDEX\.json has no ops of it"):
        replay_motion(case)


def test_a_case_with_nothing_to_compare_is_refused(tmp_path: Path) -> None:
    case = a_case(tmp_path, {"name": "bare", "ops": CALLS, "end_ms": 100})
    with pytest.raises(SessionRefused, match=r"nothing to compare: no bare_steps\.csv, and no states"):
        replay_motion(case)


@pytest.mark.parametrize("poll_us", [0, -10, 2.5, True, "10"])
def test_looks_that_are_no_whole_microseconds_are_refused(tmp_path: Path, poll_us: object) -> None:
    case = a_case(tmp_path, {"name": "odd", "poll_us": poll_us, "end_ms": 10, "ops": CALLS})
    with pytest.raises(SessionRefused, match=r"poll_us is .*; write a whole number"):
        replay_motion(case)


def blocked_law(replay: JointReplay, until_ms: int) -> list[dict[str, str]]:
    """Samples of a hip that is asked for 30 deg and does not move, from the law itself."""
    rows = []
    at_us = 1_000_000
    for sample_us in range(1_020_100, until_ms * 1000, 20_000):
        replay.steps(at_us, sample_us)
        at_us = sample_us
        replay.place(0.0)
        replay.sample(math.nan, sample_us // 1000)
        row = replay.row()
        rows.append(
            {"t_us": str(sample_us), "measured_hex": pack(">f", row["measured_deg"]).hex()}
            | {"integral_hex": pack(">f", row["integral"]).hex(), "targetPos": str(row["target"])}
            | {"joint_deg_true": "0.000000"}
        )
    return rows


def test_a_joint_that_is_blocked_stays_where_it_was_recorded(tmp_path: Path) -> None:
    joint = json.loads((DATA / "INDEX.json").read_text())["motion"]["joint_config"]["hip"]
    replay = JointReplay({**joint, "start_deg": 0.0}, 1_000_000, 10)
    replay.set_up()
    replay.sample(0.0, 1000)
    replay.move(0.0, 1000, 1)
    replay.move(30.0, 1000, 1000)
    rows = blocked_law(replay, 1500)
    assert int(rows[-1]["targetPos"]) > 100  # it is pulsed in vain
    table = "\n".join(",".join(each) for each in ([*rows[0]], *(row.values() for row in rows)))
    about = {"name": "law_hip_blocked", "joint": "hip", "start_deg": 0.0}
    about["commands_setAngle_tms_deg_durms"] = [[0, 30.0, 1000]]
    case = a_case(tmp_path, about, samples=table + "\n")
    assert replay_motion(case) == []
    free = table.replace(",joint_deg_true", "").replace(",0.000000", "")
    (tmp_path / "law_hip_blocked_samples.csv").write_text(free + "\n")
    assert replay_motion(case)[0].where == "measured_hex"
