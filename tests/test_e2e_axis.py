"""``hil axis``: verbs of devices from the shell."""

import json
import re
from collections.abc import Iterator
from typing import Any

import pytest
from e2e_support import Place, Server, config, until

from hil.net.control_client import ask

DEVICES: dict[str, dict[str, Any]] = {
    "m-1": {"setpoints": {"timeout_ms": 500, "policy": "torque_off"}},
    "s1": {"profile": "sac", "flash": {}},
}


@pytest.fixture(scope="module")
def bench() -> Iterator[tuple[Place, Server]]:
    with Place() as place:
        yield place, place.serve(config(devices=DEVICES)).ready("m-1")


Bench = tuple[Place, Server]


def snapshot(server: Server, device: str = "m-1") -> dict[str, Any]:
    state: dict[str, Any] = server.status(device)["snapshot"]
    return state


def test_the_list_has_every_verb_with_its_parameters(bench: Bench) -> None:
    place, _ = bench
    lines = place.cli("axis", "m-1").splitlines()
    verbs = [line.partition(":")[0] for line in lines if not line.startswith(" ")]
    assert verbs == [
        *("position", "velocity", "torque", "mode", "enable", "disable", "gains", "calibrate"),
        *("move-abs", "move-rel", "stop", "pulses", "As any board"),
    ]
    doors = ("reset m-1", "pin m-1 NAME LEVEL", "zero m-1", "type m-1 TEXT", "stop m-1")
    for each in doors:
        assert f" {each}`" in lines[-1]
    at = lines.index("move-abs: go to an angle with ramps")
    assert lines[at + 1 : at + 3] == [
        "  position_deg: where to, -1000000 to 1000000 deg, needed",
        "  velocity_rpm: speed on the way, 0.001 to 3000 rpm, default 60.0",
    ]
    assert "queue: write an entry of the queue" in place.cli("axis", "s1")


def test_enable_and_move_and_what_they_answer(bench: Bench) -> None:
    place, server = bench
    said = place.cli("axis", "m-1", "enable")
    assert re.fullmatch(r"m-1: its control loop is on, and holds the shaft at [0-9.-]+ deg\n", said)
    answer = place.cli("axis", "m-1", "move-abs", "-90", "velocity_rpm=120")
    assert re.fullmatch(r"m-1 moves to -90\.00 deg, there in [0-9.]+ s\n", answer)
    until(lambda: abs(snapshot(server)["position_deg"] + 90) < 0.2, "the shaft")
    said = place.cli("axis", "m-1", "move_rel", "-10")
    assert said.startswith("m-1 moves by -10.00 deg to -100.00 deg, there in ")
    answer = place.cli("axis", "m-1", "gains", "pKi=0.25")
    assert ", pKi 0.25, " in answer
    place.cli("axis", "m-1", "stop", "prejudice")


def test_a_stepper_moves_by_whole_pulses(bench: Bench) -> None:
    place, server = bench
    answer = place.cli("axis", "s1", "move-rel", "-45", "velocity_rpm=120")
    assert answer == "s1 moves by -45.00 deg (-50 pulses) to -45.00 deg\n"
    until(lambda: snapshot(server, "s1")["pulses"] == -50, "the motor")
    assert place.cli("axis", "s1", "pulse") == "s1 gets 1 pulse cw\n"


@pytest.mark.parametrize("text", ["zz", "5", "1.0", "1e3", "nan", "a=b", "text=text", "text=-b5", "007"])
def test_a_text_is_typed_as_it_stands(bench: Bench, text: str) -> None:
    place, server = bench
    with server.client("s1") as client:  # a SAC echoes all but + and -
        place.cli("axis", "s1", "type", text)
        client.read_until(text.removeprefix("text=").replace("-", "").encode())


def test_what_is_typed_is_done(bench: Bench) -> None:
    place, server = bench
    with server.client("m-1") as client:
        place.cli("axis", "m-1", "type", r"\x6d\r")
        assert b"Main menu" in client.read_until(b"Main menu")
    refused = place.cli("axis", "m-1", "type", r"\q", code=2)
    assert refused == "hil: text: \\q means nothing; write \\r, \\n, \\t, \\\\ or \\xHH\n"
    assert "a character is no byte" in place.cli("axis", "m-1", "type", "€", code=2)


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("m-1", "fly"), 2, "hil: m-1 has no 'fly'; there are position, velocity, torque, mode, "),
        (("m9", "stop"), 2, "hil: no device 'm9'; there are m-1, s1"),
        (("m-1", "move-abs"), 2, "hil: position_deg: this one is missing: where to"),
        (
            ("m-1", "move-abs", "far"),
            2,
            'hil: position_deg: "far" is no number; write -1000000',
        ),
        (("m-1", "move-abs", "nan"), 2, 'hil: position_deg: "nan" is no number; write'),
        (("m-1", "move-abs", "inf"), 2, 'hil: position_deg: "inf" is no number; write'),
        (
            ("m-1", "move-abs", "1", "2", "3", "4"),
            2,
            "hil: '4' is too much for move-abs; it takes position_deg, velocity_rpm",
        ),
        (("m-1", "move-abs", "1", "position_deg=2"), 2, "hil: position_deg is given twice"),
        (
            ("m-1", "move-abs", "1", "speed=2"),
            2,
            "hil: there is no parameter 'speed' of move-abs; it takes position_deg, ",
        ),
        (("m-1", "mov-abs"), 2, "hil: m-1 has no 'mov-abs'; did you mean \"move-abs\"? there are position, "),
        (
            ("m-1", "move-abs", "velocity=3"),
            2,
            "hil: there is no parameter 'velocity' of move-abs; did you mean \"velocity_rpm\"?",
        ),
        (("m-2", "enable"), 2, "hil: no device 'm-2'; did you mean \"m-1\"? there are m-1, "),
        (("m-1", "enable", "now"), 2, "hil: 'now' is too much for enable; it takes nothing"),
        (("m-1", "stop", "softly"), 2, 'hil: how: there is no "softly" here; write grace or prejudice'),
        (("m-1", "pin", "D9", "1"), 2, "hil: m-1 has no input 'D9'; there are D0, D1, D2, D3"),
        (("s1", "run", "31"), 2, "hil: position: 31 is too large; write 1 to 30"),
        (("s1", "loop", "3", "2"), 2, "hil: last: 2 comes before first, 3"),
    ],
)
def test_refusals_and_their_exit_codes(
    bench: Bench, arguments: tuple[str, ...], code: int, message: str
) -> None:
    place, _ = bench
    said = place.cli("axis", *arguments, code=code)
    assert said.startswith(message), said
    assert "Traceback" not in said


def test_waiting_for_the_end_of_a_motion(bench: Bench) -> None:
    place, server = bench
    place.cli("axis", "m-1", "enable")
    for verb in ("move-abs", "move_abs"):
        answer = json.loads(
            place.cli(
                "--runtime-dir",
                str(place.runtime),
                "--bench",
                "t",
                "axis",
                "m-1",
                verb,
                "45",
                "--wait",
                "--json",
            )
        )
        assert answer["done"] is True
        assert ask(server.control, "do", device="m-1", name=verb, parameters={"position_deg": 44})
    said = place.cli("axis", "m-1", "move-abs", "-45", "--wait")
    assert re.fullmatch(r"m-1 stands at -45\.00 deg after [0-9.]+ s\n", said)
    assert abs(snapshot(server)["position_deg"] + 45) < 0.5
    state = json.loads(place.cli("status", "m-1", "--json"))["m-1"]
    assert abs(state["position_deg"] + 45) < 0.5
    assert re.search(r"^position_deg +-4[45][0-9.]*$", place.cli("status", "m-1"), re.M)


def test_the_bench_of_the_environment(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    place, _ = bench
    monkeypatch.setenv("HIL_BENCH", "nowhere")
    assert "bench 'nowhere' is not running" in place.cli("status", "m-1", code=1)
    assert "position_deg" in place.cli("status", "m-1", "-b", "t")
    assert "position_deg" in place.cli("--runtime-dir", str(place.runtime), "-b", "t", "state", "m-1")
    monkeypatch.setenv("HIL_BENCH", "t")
    assert "position_deg" in place.cli("status", "m-1")


def test_pins_and_power(bench: Bench) -> None:
    place, server = bench
    place.cli("axis", "m-1", "pin", "D3", "1")
    assert snapshot(server)["pin_d3"] == 1
    at_ns = int(json.loads(place.cli("reset", "m-1", "--json"))["effective_at_ns"])
    server.ready("m-1", at_ns)
    said = place.cli("axis", "m-1", "move-rel", "5", code=1)
    assert said.startswith("hil: m-1: the control loop is off; enable it first: `hil ")
    assert said.endswith("axis m-1 enable`\n")


def test_a_stream_that_stops_is_in_the_status(bench: Bench) -> None:
    place, server = bench
    place.cli("axis", "m-1", "enable")
    place.cli("axis", "m-1", "velocity", "-30")
    until(lambda: snapshot(server)["loop_on"] == 0, "the time-out")
    assert "no set-point for 500 ms: torque_off (1 times)" in str(server.status("m-1")["note"])
    assert "no set-point for 500 ms" in place.cli("status")


def test_a_real_board_has_only_what_its_terminal_can(place: Place) -> None:
    twins = place.serve(config(devices={"s1": {"profile": "sac", "flash": {}}, "m1": {}})).ready("m1")
    ports = {name: str(place.runtime / "t" / name) for name in ("s1", "m1")}
    real = {
        "bench": "r",
        "devices": {
            "s2": {"profile": "sac", "at": ports["s1"]},
            "m2": {"profile": "mechaduino", "at": ports["m1"]},
        },
    }
    server = place.serve(json.dumps(real), bench="r")
    listed = place.cli("axis", "s2", "-b", "r")
    assert [line.partition(":")[0] for line in listed.splitlines() if line[0] != " "] == [
        "stop",
        "As any board",
    ]
    assert "type s2 TEXT" in listed
    listed = place.cli("axis", "m2", "-b", "r")
    assert [line.partition(":")[0] for line in listed.splitlines() if line[0] != " "] == [
        "enable",
        "disable",
        "As any board",
    ]
    said = place.cli("axis", "s2", "move-rel", "90", "-b", "r", code=2)
    assert said == "hil: s2 has no 'move-rel'; there are stop, type, reset\n"
    refused = place.cli("axis", "s2", "reset", "now", "-b", "r", code=2)
    assert refused == "hil: 'now' is too much for reset; it takes nothing\n"
    place.cli("axis", "s2", "type", r"xm50p\r", "-b", "r")
    until(lambda: snapshot(twins, "s1")["pulses"] == 50, "the motor")
    place.cli("axis", "s2", "reset", "-b", "r")
    with server.client("m2") as client:
        place.cli("axis", "m2", "type", "m", "-b", "r")
        client.read_until(b"Main menu")
    for verb, loop_on in (("enable", 1), ("disable", 0)):
        place.cli("axis", "m2", verb, "-b", "r")
        until(lambda loop_on=loop_on: snapshot(twins, "m1")["loop_on"] == loop_on, verb)  # type: ignore[misc]


def test_a_run_with_verbs_is_repeated_from_its_log(place: Place) -> None:
    log = place.folder / "run.jsonl"
    server = place.serve(config(speed=5, devices=DEVICES), "--log", str(log)).ready("m-1")
    place.cli("axis", "m-1", "move-abs", "5", code=1)
    place.cli("axis", "m-1", "enable")
    place.cli("axis", "s1", "velocity", "-120")
    with server.client("m-1") as client:
        for angle in ("30", "-30", "15"):
            place.cli("axis", "m-1", "move-rel", angle)
            client.ask(b"q", b"};\r\n")
        place.cli("axis", "m-1", "velocity", "60")
        until(lambda: snapshot(server)["loop_on"] == 0, "the time-out")
        client.ask(b"p")
    place.cli("axis", "s1", "stop")
    with server.client("s1") as terminal:
        terminal.ask(b"vd\r", b"SAC>")
    server.stop()
    assert log.read_text().count('"input":"do"') == 8
    assert place.cli("replay", str(log)).startswith("identical: ")
