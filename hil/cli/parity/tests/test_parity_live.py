"""``hil parity`` with another daemon's twins in the place of real boards, some of them with a fault."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from hil.testing import ServedBench, live

pytestmark = pytest.mark.long
PROGRAM = "import sys; sys.argv[0] = 'hil'; from hil.cli.entry import main; main()"
HIL = [sys.executable, "-c", PROGRAM]
PROFILES = Path(__file__).parents[4] / "device_profiles"
CALIBRATED = {"profile": "mechaduino", "flash": {"table": "identity"}}
CONFIG = {
    "bench": "boards",
    "devices": {
        **{"m1": CALIBRATED, "m2": CALIBRATED, "s1": {"profile": "sac"}, "s2": {"profile": "sac"}},
        **{"s3": {"profile": "sac", "port": "rfc2217"}, "s4": {"profile": "sac", "port": "tcp"}},
    },
}
LOADED = ("--tolerance", "400ms")
"""Tolerance beside other tests: what is late here is this computer."""
VD = {"types": "vd\r", "shows": "\r\n0\t0\r\n", "within_ms": 10_000}
PATIENCE_S = 120.0


@pytest.fixture(scope="module")
def boards() -> Iterator[ServedBench]:
    with live(CONFIG, capture=False) as bench:
        yield bench


@pytest.fixture(autouse=True)
def without_faults(boards: ServedBench) -> Iterator[None]:
    yield
    boards.hil("fault", "clear")


def parity(*words: str, code: int = 0) -> dict[str, Any]:
    """Answer of ``hil parity --json``."""
    done = subprocess.run(
        [*HIL, "parity", *words, *LOADED, "--json"],
        capture_output=True, text=True, timeout=PATIENCE_S, check=False,
    )  # fmt: skip
    assert done.returncode == code, done.stdout + done.stderr
    answer: dict[str, Any] = json.loads(done.stdout)
    return answer


def check(profile: str, sessions: Path) -> subprocess.CompletedProcess[str]:
    words = ["profile", "check", str(PROFILES / profile), "--sessions", str(sessions)]
    return subprocess.run([*HIL, *words], capture_output=True, text=True, timeout=PATIENCE_S, check=False)


def parted(answer: dict[str, Any]) -> list[str]:
    return [row["types"] for each in answer["sessions"] for row in each["rows"] if not row["equal"]]


def session_file(folder: Path, *steps: dict[str, Any], **keys: Any) -> str:
    file = folder / "mine.json"
    file.write_text(json.dumps({"profile": "sac", "moves": False, "steps": list(steps)} | keys))
    return str(file)


def typed(text: str, **keys: Any) -> dict[str, Any]:
    return {"types": text, "for_ms": 100, **keys}


def test_a_board_like_its_twin_is_equal_and_its_recording_too(boards: ServedBench, tmp_path: Path) -> None:
    answer = parity("sac", "--at", boards.port("s1"), "--record", str(tmp_path / "s"))
    assert answer["equal"]
    assert [each["session"] for each in answer["sessions"]] == ["sac/identify", "sac/settings"]
    assert answer["left_out"] == ["sac/end_signals", "sac/moves"]
    assert answer["sessions"][0]["percent"] == 100.0
    row = answer["sessions"][0]["rows"][5]
    assert row["types"] == "q\r"
    assert row["last_byte"]["twin_ms"] == pytest.approx(355.5, abs=0.1)
    assert row["last_byte"]["board_ms"] > 355
    assert row["end_of_motion"] is None
    done = check("sac", tmp_path / "s")
    assert done.stdout.endswith("passes all checks, and 2 recorded sessions are as they were\n"), done.stderr
    kept = json.loads((tmp_path / "s" / "identify.json").read_text())
    assert boards.port("s1") in kept["recorded"]
    assert kept["tolerance_ms"] == 400


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["s3", "s4"])
def test_a_board_at_a_device_server(boards: ServedBench, tmp_path: Path, name: str) -> None:
    answer = parity(session_file(tmp_path, *[typed("vd\r")] * 8), "--at", boards.port(name))
    late_ms = [
        row["last_byte"]["board_ms"] - row["last_byte"]["twin_ms"] for row in answer["sessions"][0]["rows"]
    ]
    assert answer["equal"]
    assert min(late_ms) < 60  # pyserial's port of RFC 2217 took 0.2 s for each


def test_a_motion_has_its_end(boards: ServedBench, tmp_path: Path) -> None:
    file = session_file(tmp_path, typed("xm100v60a0d0u0f\r", stands=VD), moves=True)
    assert parity(file, "--at", boards.port("s1"), code=2)["error"]["message"].endswith(
        "may turn the shaft: --moves types them too"
    )
    answer = parity(file, "--at", boards.port("s1"), "--moves")
    (row,) = answer["sessions"][0]["rows"]
    assert row["equal"]
    assert row["end_of_motion"]["twin_ms"] == pytest.approx(500, abs=51)
    assert row["end_of_motion"]["board_ms"] == pytest.approx(500, abs=400)


@pytest.mark.thorough
def test_steps_of_a_shaft_that_stands_elsewhere_are_equal(boards: ServedBench, tmp_path: Path) -> None:
    record = tmp_path / "steps.json"
    for _ in range(2):
        answer = parity("mechaduino/steps", "--moves", "--at", boards.port("m1"), "--record", str(record))
        assert answer["equal"], parted(answer)
    assert check("mechaduino", record).returncode == 0


@pytest.mark.thorough
def test_a_frozen_encoder_parts_where_the_shaft_is_asked(boards: ServedBench, tmp_path: Path) -> None:
    boards.hil("fault", "inject", "encoder_freeze", "m2")
    record = tmp_path / "frozen.json"
    words = ("mechaduino/steps", "--moves", "--at", boards.port("m2"), "--record", str(record))
    answer = parity(*words, code=1)
    (session,) = answer["sessions"]
    assert [row["number"] for row in session["rows"] if row["equal"]] == [1, 6, 12]
    assert session["rows"][1]["parts"]["got"].startswith("stepNumber: ")
    done = check("mechaduino", record)
    assert done.returncode == 1
    assert "frozen: command 2, byte " in done.stderr


@pytest.mark.thorough
def test_another_gain_parts_at_the_menu_that_shows_it(boards: ServedBench) -> None:
    boards.hil("set", "m2", "pKp", "14")
    answer = parity("mechaduino/menu", "--at", boards.port("m2"), code=1)
    boards.hil("set", "m2", "pKp", "15")
    assert parted(answer) == ["kp"]
    (row,) = [row for row in answer["sessions"][0]["rows"] if not row["equal"]]
    assert row["parts"]["expected"].startswith("p ----- pKp = 15.0")
    assert row["parts"]["got"].startswith("p ----- pKp = 14.0")
    assert 95 < row["bytes_percent"] < 100


@pytest.mark.thorough
def test_a_noisy_encoder_parts(boards: ServedBench) -> None:
    boards.hil("fault", "inject", "encoder_noise", "m2", "counts=1000")
    assert set(parted(parity("mechaduino/angle", "--at", boards.port("m2"), code=1))) <= {"p", "ppp"}


@pytest.mark.thorough
def test_lost_bytes_part_and_the_rest_is_equal(boards: ServedBench) -> None:
    boards.hil("fault", "inject", "byte_drop", "s2", "rate=0.003", "seed=3")
    answer = parity("sac/identify", "--at", boards.port("s2"), code=1)
    assert "q\r" in parted(answer)
    assert 90 < answer["sessions"][0]["percent"] < 100


def test_a_cable_that_is_pulled_out_ends_it(boards: ServedBench, tmp_path: Path) -> None:
    file = session_file(tmp_path, *[typed("vd\r")] * 30)
    record = tmp_path / "kept.json"
    boards.hil("fault", "inject", "host_close", "s2", "start_s=4")
    words = (file, "sac/identify", "--at", boards.port("s2"), "--record", str(tmp_path / "kept"))
    answer = parity(*words, code=1)
    (session,) = answer["sessions"]
    assert session["broken"] == 'the board has stopped answering: nothing came of "vd\\r" and "vd\\r"'
    assert answer["not_typed"] == ["sac/identify"]
    assert 0 < session["commands_equal"] < 29
    record = tmp_path / "kept" / "mine.json"
    assert session["recording"] == str(record)
    assert len(json.loads(record.read_text())["steps"]) == len(session["rows"])


def test_another_baud_is_noticed_at_once(boards: ServedBench) -> None:
    (session,) = parity("sac/identify", "--at", boards.port("s2"), "--baud", "9600", code=1)["sessions"]
    assert session["broken"].endswith("is no answer of a sac: another board, or another baud?")
    assert session["rows"] == []


def test_the_board_of_another_profile_is_noticed_at_once(boards: ServedBench) -> None:
    (session,) = parity("mechaduino/menu", "--at", boards.port("s2"), "--baud", "38400", code=1)["sessions"]
    assert session["broken"].endswith("is no answer of a mechaduino: another board, or another baud?")
    assert [row["types"] for row in session["rows"]] == ["m"]  # a line end would make a SAC turn


def test_a_port_that_another_program_has_open(boards: ServedBench) -> None:
    port = os.open(boards.port("s2"), os.O_RDWR | os.O_NOCTTY)
    try:
        holder = subprocess.Popen(["sleep", "60"], pass_fds=(port,))
        message = parity("sac/identify", "--at", boards.port("s2"), code=2)["error"]["message"]
    finally:
        os.close(port)
        holder.kill()
        holder.wait()
    assert f"sleep (process {holder.pid})" in message
    assert "would get a part of the answers" in message


def test_ctrl_c_stops_the_board_and_keeps_the_recording(boards: ServedBench, tmp_path: Path) -> None:
    turning = typed("xm0v60a0d0\r", for_ms=60_000)
    file = session_file(tmp_path, typed("vd\r"), turning, moves=True, ends_by="S\r")
    record = tmp_path / "kept.json"
    words = [*HIL, "parity", file, "--moves", "--at", boards.port("s1"), "--record", str(record)]
    running = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    until_s = time.monotonic() + PATIENCE_S
    while boards.ask("state", device="s1")["motion_state"] == 0 and time.monotonic() < until_s:
        time.sleep(0.05)
    running.send_signal(signal.SIGINT)
    said, _ = running.communicate(timeout=PATIENCE_S)
    assert running.returncode == 130
    assert "Broken off at command 2 of 2: interrupted" in said
    assert boards.ask("state", device="s1")["motion_state"] == 0
    assert [step["types"] for step in json.loads(record.read_text())["steps"]] == ["vd\r"]


@pytest.mark.thorough
def test_a_board_that_goes_away(tmp_path: Path) -> None:
    file = session_file(tmp_path, *[typed("vd\r")] * 50)
    with live({"bench": "gone", "devices": {"s1": {"profile": "sac"}}}, capture=False) as bench:
        words = [*HIL, "parity", file, "--at", bench.port("s1"), "--json"]
        running = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        until_s = time.monotonic() + PATIENCE_S
        while bench.ask("status")["devices"][0]["rx_bytes"] < 30 and time.monotonic() < until_s:
            time.sleep(0.05)
        os.kill(bench.pid, signal.SIGKILL)
        said, _ = running.communicate(timeout=PATIENCE_S)
    (session,) = json.loads(said)["sessions"]
    assert running.returncode == 1
    assert "has gone" in session["broken"]
    assert 5 < session["commands_equal"] < 50
