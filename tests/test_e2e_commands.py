"""Every command of ``hil`` against running daemons: what it says and its exit code."""

import json
import os
import pty
import re
import select
import signal
import subprocess
import time
from contextlib import suppress
from pathlib import Path

import jsonschema
import pytest
import yaml
from e2e_support import HIL, PATIENCE_S, Place, config, until

from hil.sim.log_checks import without_checks

COMMANDS = (
    *("serve", "check", "schema", "list", "status", "monitor", "reset", "pin", "set", "replay"),
    *("plot", "step", "pulses", "doctor", "zero"),
)
TCP = {"port": {"kind": "tcp", "listen": 0}}


@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_help_fits_100_columns(place: Place, command: str) -> None:
    text = place.cli(*command.split(), "--help")
    assert "Usage: " in text
    assert max(map(len, text.splitlines())) <= 100
    if not command:
        assert all(re.search(rf"^  {name} +\S", text, re.MULTILINE) for name in COMMANDS)


def test_version_and_wrong_usage(place: Place) -> None:
    assert re.fullmatch(r"hil \d+\.\d+\.\d+\n", place.hil("--version"))
    assert "hil: there is no command 'serv'; did you mean \"serve\"?" in place.cli("serv", code=2)
    assert "hil: there is no option --wrong of `hil serve`" in place.hil("serve", "--wrong", code=2)


def test_list_and_status(place: Place) -> None:
    server = place.serve(config(devices={"m1": {}, "m2": TCP | {"hardware": "0.2"}})).ready()
    text = place.hil("list")
    assert f"process {server.pid}" in text
    assert str(place.runtime / "t" / "m1") in text
    assert "mechaduino 0.2" in text
    assert re.search(r"socket://127\.0\.0\.1:\d+", text)
    (listed,) = json.loads(place.cli("list", "--json"))
    assert [row["device"] for row in listed["devices"]] == ["m1", "m2"]

    with server.client("m1") as client:
        client.ask(b"p")
        status = json.loads(place.cli("status", "--json"))
        m1, m2 = status["devices"]
        assert (m1["clients"], m1["connects"], m1["rx_bytes"]) == (1, 1, 1)
        assert m1["tx_bytes"] > 40
        assert m2["unheard_bytes"] > 600  # its banner
        assert sum(status["wake_latency"]) >= status["ticks"] > 0
        assert sum(status["lag"]) > 0
        text = place.hil("status")
        assert re.search(r"wakes at 1000 Hz: \d+ ticks \+ \d+ missed in \d+\.\d+ s", text)
        assert "wake latency" in text
        assert "firmware lag" in text
        assert re.search(r"^ m1 +1 +1 ", text, re.MULTILINE)


@pytest.mark.parametrize("words", [("top",), ("status", "--watch")])
def test_top_redraws_until_ctrl_c(place: Place, words: tuple[str, ...]) -> None:
    place.serve(config())
    child, terminal = pty.fork()
    if child == 0:
        os.environ["COLUMNS"] = "120"
        os.execv(HIL, [HIL, *words, "--runtime-dir", str(place.runtime)])
    shown = b""
    deadline = time.monotonic() + PATIENCE_S
    while len(set(re.findall(rb"(\d+\.\d) s  speed", shown))) < 2:
        assert time.monotonic() < deadline, shown[-2000:]
        if select.select([terminal], [], [], 0.1)[0]:
            shown += os.read(terminal, 65536)
    os.write(terminal, b"\x03")
    assert exit_code(child, terminal) == 0


@pytest.mark.parametrize(("option", "wanted"), [((), rb"(\d+) ticks"), (("--json",), rb'"at_ns": (\d+)')])
def test_status_watch_goes_on_in_a_pipe_until_the_bench_ends(
    place: Place, option: tuple[str, ...], wanted: bytes
) -> None:
    server = place.serve(config())
    command = [HIL, "status", "--watch", "--runtime-dir", str(place.runtime), *option]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as watching:
        assert watching.stdout
        shown = b""
        while len(set(re.findall(wanted, shown))) < 3:
            piece = watching.stdout.readline()
            assert piece, shown[-2000:]
            shown += piece
        server.stop()
        rest = watching.stdout.read()
        assert watching.wait(PATIENCE_S) == 1
    assert b"Traceback" not in rest
    assert rest.rstrip().splitlines()[-1].startswith((b"hil: ", b'{"error"'))


def exit_code(child: int, terminal: int) -> int:
    """Exit code of a program under a terminal, whose output is read on until it ends."""
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        if select.select([terminal], [], [], 0.05)[0]:
            with suppress(OSError):  # it has closed its end
                os.read(terminal, 65536)
        pid, status = os.waitpid(child, os.WNOHANG)
        if pid:
            os.close(terminal)
            return os.waitstatus_to_exitcode(status)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    raise AssertionError("it did not end")


def test_monitor_copies_standard_input(place: Place) -> None:
    place.serve(config(devices={"m1": {}, "m2": TCP})).ready()
    for device in ("m1", "m2"):
        text = place.hil("monitor", device, input=b"r90\np")
        assert text.startswith("Enter setpoint:\r\n90.00\r\nstepNumber: 0 , Angle: ")
        assert "raw encoder: " in text


def test_monitor_takes_more_input_than_the_board_reads_at_once(place: Place) -> None:
    """50 MB of answers: the monitor has to go on reading while its writes are held up."""
    server = place.serve(config(speed=100)).ready()
    text = place.hil("monitor", "m1", input=b"q" * 400 + b"#" * 20_000 + b"p", timeout_s=90)
    assert text.count("----Current Parameters-----") == 400
    assert "raw encoder: " in text
    assert server.status()["dropped_bytes"] == 0


def test_monitor_whose_reader_goes_away_ends(place: Place) -> None:
    place.serve(config(speed=100)).ready()
    command = f"printf qqqq | {HIL} monitor m1 --runtime-dir {place.runtime} | head -c 10"
    done = subprocess.run(command, shell=True, capture_output=True, timeout=PATIENCE_S, check=True)
    assert len(done.stdout) == 10
    assert b"Traceback" not in done.stderr


@pytest.mark.parametrize("device", ["m1", "m2"])
def test_monitor_says_that_its_port_has_gone(place: Place, device: str) -> None:
    server = place.serve(config(devices={"m1": {}, "m2": TCP})).ready()
    streams = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    command = [HIL, "monitor", device, "--runtime-dir", str(place.runtime)]
    with subprocess.Popen(command, **streams) as running:
        assert running.stdin
        until(lambda: server.status(device)["clients"], "the client")
        server.stop()
        assert running.stderr
        assert running.stderr.read().startswith(b"hil: the port has gone: ")
        assert running.wait(PATIENCE_S) == 0


@pytest.mark.parametrize("device", ["m1", "m2"])
def test_monitor_in_a_terminal(place: Place, device: str) -> None:
    place.serve(config(devices={"m1": {}, "m2": TCP})).ready()
    child, terminal = pty.fork()
    if child == 0:
        os.execv(HIL, [HIL, "monitor", device, "--runtime-dir", str(place.runtime)])
    shown = b""

    def shows(wanted: bytes) -> bool:
        nonlocal shown
        if select.select([terminal], [], [], 0)[0]:
            shown += os.read(terminal, 65536)
        return wanted in shown

    os.write(terminal, b"p")  # before it has begun: the terminal keeps it
    until(lambda: shows(b"Ctrl-] ends the monitor."), "the monitor's start")
    hint = f"\r\n{device} does not repeat what it said at power-up: type p to see it answer.\r\n"
    until(lambda: shows(hint.encode()), "what to type")
    until(lambda: shows(b"raw encoder: "), "an answer")
    os.write(terminal, b"\x03")  # Ctrl-C is a byte for the board, which ignores it
    os.write(terminal, b"m")
    until(lambda: shows(b"print main menu"), "the menu")
    os.write(terminal, b"\x1d")
    assert exit_code(child, terminal) == 0


def test_monitor_pipes_what_the_board_says_and_no_more(place: Place) -> None:
    place.serve(config()).ready()
    terminal, inner = pty.openpty()
    streams = {"stdin": inner, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    command = [HIL, "monitor", "m1", "--runtime-dir", str(place.runtime)]
    with subprocess.Popen(command, **streams) as process:
        os.close(inner)
        assert process.stdout
        assert process.stderr
        os.write(terminal, b"p")
        piped = process.stdout.readline()
        os.write(terminal, b"\x1d")
        piped += process.stdout.read()
        assert process.stderr.read().startswith(b"Ctrl-] ends the monitor.\r\n")
    os.close(terminal)
    assert process.returncode == 0
    assert re.fullmatch(rb"stepNumber: 0 , Angle: [^\n]*raw encoder: [^\n]*\r\n", piped)


def test_reset_boots_again_and_keeps_the_shaft(place: Place) -> None:
    server = place.serve(config()).ready()
    with server.client() as client:
        client.write(b"s" * 8)
        until(lambda: b"stepNumber: 8 " in client.read_until(b"\r\n"), "eight steps")
        shaft = server.status()["snapshot"]["position_deg"]
        place.cli("reset", "m1")
        answer = client.read_until(b"SPI communication with AS5047 encoder...\r\n")
        assert answer.startswith(b"\r\n\r\n----- Mechaduino 0.X -----\r\n")
        assert server.status()["snapshot"]["position_deg"] == pytest.approx(shaft, abs=3.6)
        assert client.ask(b"p").startswith(b"stepNumber: 0 ")


def test_pin_steps_the_setpoint(place: Place) -> None:
    server = place.serve(config()).ready()
    with server.client() as client:
        client.write(b"xy")
        client.read_until(b"\r\n")
        setpoint_deg = server.status()["snapshot"]["r"]
        for _ in range(4):
            place.cli("pin", "m1", "D1", "1")
            place.cli("pin", "m1", "D1", "0")
        assert server.status()["snapshot"]["r"] == pytest.approx(setpoint_deg - 4 * 0.05625, abs=1e-3)
    assert "m1 has no input 'D9'; there are D0, D1, D2, D3" in place.cli("pin", "m1", "D9", "1", code=2)
    assert "level: 2 is too large; write 0 or 1" in place.cli("pin", "m1", "D1", "2", code=2)


def test_set_loads_the_shaft_and_the_encoders_registers(place: Place) -> None:
    server = place.serve(config()).ready()
    with server.client() as client:
        client.write(b"xy")
        client.read_until(b"\r\n")
        for torque_Nm in ("0.1", "-0.1"):
            place.cli("set", "m1", "load_torque_Nm", torque_Nm)
            assert server.status()["snapshot"]["load_torque_Nm"] == float(torque_Nm)
        place.cli("set", "m1", "diaagc", "2432")
        client.write(b"ne")
        assert b"MAGH" in client.read_until(b"ERRFL")
    assert "load_torque_Nm, diaagc, errfl" in place.cli("set", "m1", "wrap_count", "1", code=2)
    for wrong in ("-1", "1e9", "1e308"):
        said = place.cli("set", "m1", "diaagc", wrong, code=2)
        assert re.search("diaagc: .* is too (large|small); write 0 to 32767", said)
    for wrong in ("nan", "inf"):
        said = place.cli("set", "m1", "diaagc", wrong, code=2)
        assert said == f'hil: diaagc: "{wrong}" is no number; write a number\n'
    refused = place.cli("set", "m1", "load_torque_Nm", "99", code=2)
    assert "write -4.95 to 4.95, 10 times what this motor holds (0.495 Nm)" in refused
    said = place.cli("set", "m1", "diaagc", "much", code=2)
    assert said == 'hil: diaagc: "much" is no number; write a number\n'
    place.cli("set", "m1", "load_torque_Nm", "0")
    said = place.cli("zero", "m1")
    assert re.fullmatch(r"m1: the shaft's angle is 0 now; it was -?\d+\.\d\d deg\n", said)
    assert "no device 'm9'; there are m1" in place.cli("zero", "m9", code=2)
    assert {"was_deg", "board_deg"} < json.loads(place.cli("zero", "m1", "--json")).keys()


def test_a_board_without_an_encoder_has_no_registers_and_the_log_none_of_them(place: Place) -> None:
    log = place.folder / "inputs.log"
    server = place.serve(config(devices={"s1": {"profile": "sac", "flash": {}}}), "--log", str(log))
    for field in ("diaagc", "errfl"):
        said = place.cli("set", "s1", field, "1", code=2)
        there = "there are load_torque_Nm, position_deg, clock_Hz"
        assert said == f"hil: s1 has no field '{field}' that can be set; {there}\n"
    place.cli("set", "s1", "load_torque_Nm", "0.01")
    server.stop()
    assert place.cli("replay", str(log)).startswith("identical: ")


def test_unknown_device_and_no_daemon(place: Place) -> None:
    for command in (["status"], ["monitor", "m1"], ["reset", "m1"], ["pin", "m1", "D0", "1"]):
        assert "no bench is running here" in place.cli(*command, code=1)
    nowhere = f"No bench is running here: there is no folder {place.runtime}; `hil --runtime-dir"
    assert place.cli("list").startswith(nowhere)
    assert place.cli("list", "--json") == "[]\n"
    place.serve(config())
    for command in (
        ["monitor", "m9"],
        ["reset", "m9"],
        ["pin", "m9", "D0", "1"],
        ["set", "m9", "errfl", "0"],
    ):
        assert "no device 'm9'; there are m1" in place.cli(*command, code=2)
    assert "bench 'u' is not running here; running: t" in place.cli("status", "--bench", "u", code=1)


def test_two_daemons_need_bench(place: Place) -> None:
    first = place.serve(config("t"))
    second = place.serve(config("u", devices={"m5": {}}), bench="u")
    assert "several benches are running (t, u): choose one with --bench" in place.cli("status", code=2)
    why = "several benches are running (t, u), and none has m9: choose one with --bench"
    assert why in place.cli("reset", "m9", code=2)
    assert "m5: on bench u" in place.cli("reset", "m5")
    assert "bench u" in place.cli("status", "--bench", "u")
    place.cli("reset", "m5", "-b", "u")
    assert [b["bench"] for b in json.loads(place.cli("list", "--json"))] == ["t", "u"]
    # What a killed one leaves behind is not a second bench.
    second.kill()
    assert "bench t" in place.cli("status")
    assert [b["bench"] for b in json.loads(place.cli("list", "--json"))] == ["t"]
    first.kill()
    assert "no bench is running here" in place.cli("status", code=1)


def test_check_says_all_problems_at_once(place: Place) -> None:
    wrong = """\
bench: t
spede: 2
devices:
  m1:
    profile: mechaduno
    port: pty
  m2:
    profile: mechaduino
    port: {kind: pty, mod: "0660"}
    baud: fast
"""
    path = place.write(wrong)
    for run, command in (
        (place.cli, ["check", str(path)]),
        (place.hil, ["serve", str(path), *place.folders()]),
    ):
        text = run(*command, code=2)
        assert re.search(rf"^{path}:2:1: .*spede.*speed", text, re.MULTILINE), text
        assert re.search(rf"^{path}:5:14: .*mechaduno.*mechaduino", text, re.MULTILINE)
        assert re.search(rf"^{path}:9:\d+: .*mod.*mode", text, re.MULTILINE)
        assert re.search(rf"^{path}:10:11: .*", text, re.MULTILINE)
    assert not place.runtime.exists()
    assert not place.state.exists()


def test_check_of_files_that_are_no_configuration(place: Place) -> None:
    assert "No such file" in place.cli("check", str(place.folder / "none.yaml"), code=2)
    assert "Is a directory" in place.cli("check", str(place.folder), code=2)
    binary = place.folder / "binary.yaml"
    binary.write_bytes(b"\xff\xfe\x00bench")
    assert f"{binary}:" in place.cli("check", str(binary), code=2)
    for text in ("", "- 1\n", "bench: [", "a: &a [*a]\n", "\t"):
        assert "bench.yaml:" in place.cli("check", str(place.write(text)), code=2)


def test_check_and_diff(place: Place) -> None:
    old = place.write(config(devices={"m1": {}, "m2": {}, "m3": {}}), "old.yaml")
    new = place.write(config(devices={"m1": {}, "m2": {"baud": 9600}, "m4": {}}), "new.yaml")
    assert "3 devices, no problems" in place.cli("check", str(new))
    lines = place.cli("check", str(new), "--diff", str(old)).splitlines()
    words = {tuple(line.split()[:2]) for line in lines}
    assert {("keep", "m1"), ("restart", "m2"), ("add", "m4"), ("remove", "m3")} <= words


def test_schema_accepts_what_check_accepts(place: Place) -> None:
    schema = json.loads(place.cli("schema"))
    jsonschema.validate(yaml.safe_load(config()), schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(yaml.safe_load(config(spede=1)), schema)


def test_replay_of_a_run(place: Place) -> None:
    log = place.folder / "run.log"
    server = place.serve(config(devices={"m1": {}, "m2": {"baud": 115200}}), "--log", str(log)).ready()
    for name in ("m1", "m2"):
        with server.client(name) as client:
            client.ask(b"p")
            client.write(b"xy")
            client.read_until(b"\r\n")
            client.ask(b"r12.5\n", b"12.50\r\n")
    place.cli("pin", "m1", "D2", "1")
    place.cli("set", "m2", "load_torque_Nm", "0.02")
    place.cli("reset", "m1")
    server.stop()
    text = place.cli("replay", str(log))
    assert re.fullmatch(r"identical: \d+ inputs, \d+ bytes in \d+ pieces, \d+ states of axes\n", text)

    changed = log.read_text().replace(b"12.50".hex(), b"12.51".hex(), 1)
    damaged = place.write(changed, "damaged.log")
    assert "its checksum is that of other lines" in place.cli("replay", str(damaged), code=2)
    other = place.write("".join(without_checks(changed)), "other.log")
    said = place.cli("replay", str(other), code=1)
    assert re.search(
        r"^hil: different: m[12], piece \d+: logged b'.*12\.51.*' at \d+ ns.*, now b'.*12\.50", said
    )
    assert len(said) < 400


def test_replay_of_what_is_no_log(place: Place) -> None:
    assert "No such file" in place.cli("replay", str(place.folder / "none"), code=2)
    for wrong in (b"", b"bench: t\n", b'{"format":"hil-inputs","version":99}\n', b"\xff\xfe\n", b"[]\n"):
        path = Path(place.folder / "wrong.log")
        path.write_bytes(wrong)
        assert place.cli("replay", str(path), code=2).startswith("hil: ")
