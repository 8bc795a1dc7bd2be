"""``hil type`` and ``hil wait`` at running benches: what they print, and their exit codes."""

import json
import subprocess
import time

import pytest
from e2e_support import HIL, PATIENCE_S, Place, config, until

TCP = {"port": {"kind": "tcp", "listen": 0}}


def both(place: Place) -> None:
    place.serve(config(devices={"m1": {}, "m2": TCP, "s1": {"profile": "sac", "flash": {}}})).ready()


def test_type_ends_when_the_text_has_come(place: Place) -> None:
    both(place)
    for device in ("m1", "m2"):
        said = place.cli("type", device, "p", "--until", "encoder", "--within", "20s")
        assert said.startswith("stepNumber: 0 , Angle: ")
        assert said.endswith(", raw encoder\n")
    answer = json.loads(
        place.cli("type", "m1", r"r90\n", "--until", r"90.00\r\n", "--within", "20s", "--json")
    )
    assert answer == {"came": True, "text": "Enter setpoint:\r\n90.00\r\n"}


def test_type_prints_all_that_comes_in_its_time(place: Place) -> None:
    both(place)
    assert place.cli("type", "m1", "pp", "--within", "5s").count("raw encoder: ") == 2
    assert place.cli("type", "s1", "?", "--enter", "--until", "SAC>", "--within", "20s").startswith("?")


def test_type_exits_with_1_and_what_came_instead(place: Place) -> None:
    both(place)
    done = subprocess.run(
        [HIL, "type", "m1", "p", "--until", ">", "--within", "5s", "--runtime-dir", str(place.runtime)],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )
    assert done.returncode == 1
    assert done.stdout.endswith("raw encoder: 286\n")
    assert done.stderr == "hil: m1: '>' did not come within 5 s\n"
    answer = json.loads(place.hil("type", "m1", "p", "--until", ">", "--within", "5s", "--json", code=1))
    assert answer["came"] is False
    assert answer["text"].endswith("raw encoder: 286\r\n")


def test_a_board_that_never_stops_talking_does_not_hold_type_up(place: Place) -> None:
    place.serve(config(speed=100)).ready()
    begin_s = time.monotonic()
    assert len(place.cli("type", "m1", "q" * 1000, "--within", "100s")) > 10_000
    assert time.monotonic() - begin_s < PATIENCE_S


def test_type_refuses_a_port_that_another_program_has(place: Place) -> None:
    server = place.serve(config()).ready()
    with server.client("m1"):
        until(lambda: server.status("m1")["clients"], "the client")
        assert "another program has " in place.cli("type", "m1", "p", code=1)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["m9", "p"], 2, "no device 'm9'; "),
        (["m1", r"\q"], 2, r"\q means nothing; write \r, \n, \t, \\ or \xHH"),
        (["m1", "p", "--until", ""], 2, "--until has no text"),
        (
            ["m1", "p", "--within", "2h"],
            2,
            "--within 2h: this is no time; write a number and s, ms, us or min",
        ),
        (["u1", "p"], 1, "has no serial port"),
    ],
)
def test_what_type_refuses(place: Place, words: list[str], code: int, said: str) -> None:
    place.serve(config(devices={"m1": {}, "u1": {"profile": "modbus_drive", "port": None, "flash": {}}}))
    assert said in place.cli("type", *words, code=code)


def test_wait_until_a_condition_holds(place: Place) -> None:
    both(place)
    place.cli("type", "m1", r"xyr90\n", "--until", "90.00", "--within", "20s")
    said = place.cli("wait", "m1", "yw > 89 and loop_on == 1", "--within", "20s")
    assert said.startswith("m1: yw > 89 and loop_on == 1 after ")
    assert "loop_on is 1" in said
    assert place.cli("wait", "s1", "motion_state == 0").startswith("s1: motion_state == 0 after 0.000 s")


def test_wait_sees_what_is_over_before_anybody_could_ask(place: Place) -> None:
    """The shaft passes 45 degrees within milliseconds of the computer's clock."""
    server = place.serve(config(speed=20)).ready()
    server.ask("send", device="m1", data=b"xyr0\n".hex())
    place.cli("wait", "m1", "yw < 1 and loop_on == 1", "--within", "20s")
    command = [HIL, "wait", "m1", "yw > 20 and yw < 70", "--within", "1200s", "--json"]
    with subprocess.Popen(
        [*command, "--runtime-dir", str(place.runtime)], stdout=subprocess.PIPE, text=True
    ) as waiting:
        while waiting.poll() is None:
            for text in (b"r90\n", b"r0\n"):
                server.ask("send", device="m1", data=text.hex())
                time.sleep(0.3)
        assert waiting.stdout
        answer = json.loads(waiting.stdout.read())
    assert answer["holds"]
    assert 20 < answer["state"]["yw"] < 70


def test_wait_exits_with_1_and_the_last_state(place: Place) -> None:
    both(place)
    begin_ns = json.loads(place.cli("status", "m1", "--json"))["m1"]["at_ns"]
    answer = json.loads(place.hil("wait", "m1", "position_deg > 1e6", "--within", "10s", "--json", code=1))
    assert (answer["holds"], answer["after_s"]) == (False, 10)
    assert answer["state"]["at_ns"] - begin_ns > 10e9
    assert answer["state"]["position_deg"] < 360
    said = place.cli("wait", "m1", "position_deg > 1e6", "--within", "500ms", code=1)
    assert "m1: position_deg > 1e6 did not hold within 0.5 s; the last state:" in said
    assert "\nvelocity_rpm " in said


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["m9", "position_deg > 1"], "no device 'm9'; "),
        (["m1", "positon_deg > 1"], """m1 has no field 'positon_deg'; did you mean "position_deg"?"""),
        (["m1", "at_ns > 1"], "m1 has no field 'at_ns'"),
        (["m1", "position_deg = 1"], "write ==, not ="),
        (["m1", "position_deg > 1", "--within", "0s"], "--within 0s: write more than 0"),
    ],
)
def test_what_wait_refuses(place: Place, words: list[str], said: str) -> None:
    place.serve(config())
    assert said in place.cli("wait", *words, code=2)
