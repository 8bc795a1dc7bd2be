"""Real boards in a bench: here they are twins of another bench, or scripted, behind serial ports."""

import os
import re
import shutil
import subprocess
import tty
from pathlib import Path
from typing import Any

import pytest
import serial
from e2e_support import HIL, PATIENCE_S, SAC_READY_NS, Client, Place, Server, config, free_port, until
from service_manager import Manager

SAC: dict[str, Any] = {"profile": "sac", "flash": {}}


def real_config(**devices: dict[str, Any]) -> str:
    import json

    return json.dumps({"bench": "r", "devices": devices})


@pytest.fixture
def pair(place: Place) -> tuple[Server, Server, str]:
    """Bench with a SAC, one to which that is a real board, and its address."""
    twins = place.serve(config(speed=5, devices={"s1": SAC}))
    with twins.client("s1") as terminal:
        terminal.read_until(b"SAC>")
    at = str(place.runtime / "t" / "s1")
    return twins, place.serve(real_config(s2={"profile": "sac", "at": at}), bench="r"), at


def hil(place: Place, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [HIL, *arguments, "--runtime-dir", str(place.runtime)]
    return subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S)


def test_a_program_talks_to_a_real_board_through_the_daemon(place: Place, pair: Any) -> None:
    twins, real, at = pair
    with real.client("s2") as terminal:
        assert terminal.ask(b"m100v150ad\r", b"SAC>") == b"m100v150ad\r\nSAC>"
        until(lambda: twins.status("s1")["snapshot"]["pulses"] == 200, "the motor")
        listing = terminal.ask(b"q\r", b"s sync\r\nSAC>")
    assert listing.count(b"\r\n") == 35
    row = real.status("s2")
    assert (row["at"], row["hardware"], row["note"]) == (at, "real", None)
    assert row["board"]["tx_bytes"] == len(b"m100v150ad\rq\r")
    assert row["board"]["rx_bytes"] == row["tx_bytes"] + row["unheard_bytes"]
    assert "real" in place.cli("status", "--bench", "r")


def test_verbs_go_through_the_terminal_or_are_refused_with_a_reason(place: Place, pair: Any) -> None:
    twins, real, _ = pair
    real.ask("send", device="s2", data=b"$Cd3.5\r".hex())
    until(lambda: twins.status("s1")["rx_bytes"] >= 7, "the bytes")
    assert hil(place, "reset", "s2", "--bench", "r").returncode == 0
    with real.client("s2") as terminal:
        assert b"acc\t3.50" in terminal.ask(b"cf\r", b"debug\t0\r\nSAC>")
    for command in (["pin", "s2", "sync", "0"], ["set", "s2", "load_torque_Nm", "1"], ["plot", "s2"]):
        refused = hil(place, *command, "--bench", "r")
        assert refused.returncode == 1
        assert "s2 is a real board: the daemon sees its terminal, not its pins" in refused.stderr


def test_a_dialogue_holds_a_client_up_and_loses_nothing(place: Place, pair: Any) -> None:
    _, real, _ = pair
    command = [HIL, "reset", "s2", "-b", "r", "--runtime-dir", str(place.runtime)]
    with real.client("s2") as terminal, subprocess.Popen(command) as resetting:
        until(lambda: real.status("s2")["board"]["tx_bytes"] > 0, "the dialogue")
        assert terminal.ask(b"vd\r", b"0\t0\r\nSAC>")
        assert resetting.wait(PATIENCE_S) == 0


@pytest.mark.thorough
def test_faults_come_and_go(place: Place, pair: Any) -> None:
    _, real, _ = pair
    with real.client("s2") as terminal:
        assert hil(place, "fault", "inject", "byte_drop", "s2", "rate=1", "-b", "r").stdout == "fault 1\n"
        terminal.write(b"vd\r")
        until(
            lambda: real.ask("faults")[0]["changed_bytes"] == len(b"vd\r\n0\t0\r\nSAC>"), "the answer's loss"
        )
        assert terminal.quiet(0.2) == b""
        assert hil(
            place, "fault", "inject", "byte_duplicate", "s2", "rate=1", "towards=board", "-b", "r"
        ).stdout
        assert (
            "1 byte_drop s2 rate=1 towards=client seed=0, 13 bytes"
            in hil(place, "fault", "list", "-b", "r").stdout
        )
        assert hil(place, "fault", "clear", "1", "-b", "r").returncode == 0
        assert terminal.ask(b"q\r", b"SAC>\r\nSAC>") == b"qq\r\nSAC>\r\nSAC>"
        assert hil(place, "fault", "clear", "-b", "r").returncode == 0
        assert terminal.ask(b"vd\r", b"SAC>") == b"vd\r\n0\t0\r\nSAC>"
        assert hil(place, "fault", "list", "-b", "r").stdout == "no fault is active\n"
    for parameters, said in (
        (("byte_dop", "s2"), "there is no fault"),
        (("byte_drop", "s9", "rate=1"), "there is no 's9'"),
        (("byte_drop", "s2"), "rate: this one is missing"),
        (("byte_drop", "s2", "rate=2"), "rate: 2 is too large; write 0 to 1"),
        (
            ("byte_drop", "s2", "rate=1", "x=1"),
            "x: there is no such parameter; parameters of byte_drop are rate, towards, seed",
        ),
        (
            ("byte_drop", "s2", "rate=1", "towards=up"),
            'towards: there is no "up" here; write board or client',
        ),
    ):
        refused = hil(place, "fault", "inject", *parameters, "-b", "r")
        assert refused.returncode == 2
        assert said in refused.stderr, refused


@pytest.mark.thorough
@pytest.mark.skipif(not shutil.which("tshark"), reason="needs tshark")
def test_a_capture_has_every_byte_both_ways(place: Place, pair: Any) -> None:
    _, real, _ = pair
    path = place.folder / "cap.pcapng"
    command = [HIL, "capture", "s2", "-w", str(path), "-b", "r", "--runtime-dir", str(place.runtime)]
    with real.client("s2") as terminal, subprocess.Popen(command) as capture:
        until(lambda: path.exists() and path.stat().st_size > 0, "the capture's beginning")
        answer = terminal.ask(b"q\r", b"s sync\r\nSAC>")
        assert hil(place, "capture", "nope", "-w", "-", "-b", "r").returncode == 2
        fields = ["-T", "fields", "-e", "rtacser.eventtype", "-e", "data.data"]

        def both() -> tuple[bytes, bytes]:
            out = subprocess.run(["tshark", "-r", str(path), *fields], capture_output=True, text=True).stdout
            rows = [line.split("\t") for line in out.splitlines() if line.count("\t") == 1]
            return tuple(  # type: ignore[return-value]
                b"".join(bytes.fromhex(data) for event, data in rows if int(event, 0) == kind)
                for kind in (1, 2)
            )

        until(lambda: both() == (b"q\r", answer), "the capture")
        capture.terminate()


def test_a_board_that_is_away_is_said_and_comes_back(place: Place) -> None:
    link = place.folder / "ttyUSB0"
    real = place.serve(real_config(s2={"profile": "sac", "at": str(link)}), bench="r")
    assert "away, tried again each second" in real.output
    assert "is away" in real.status("s2")["note"]
    refused = hil(place, "reset", "s2", "-b", "r")
    assert (refused.returncode, "is away" in refused.stderr) == (1, True)
    with real.client("s2") as terminal:
        for _ in range(2):
            master, slave = os.openpty()
            tty.setraw(slave)
            link.symlink_to(os.ttyname(slave))
            os.close(slave)
            until(lambda: real.status("s2")["note"] is None, "the board")
            with Client.__new__(Client) as board:
                board._socket, board.fd, board.got = None, master, bytearray()
                terminal.write(b"hello")
                assert board.read_exactly(5) == b"hello"
                board.write(b"world")
                assert terminal.read_exactly(5) == b"world"
                link.unlink()
            until(lambda: real.status("s2")["note"], "the loss")


@pytest.mark.thorough
def test_a_real_mechaduino_beside_a_twin_and_a_log_that_leaves_it_out(place: Place) -> None:
    twins = place.serve(config(devices={"m1": {"port": "tcp"}})).ready()
    at = twins.ask("list")["devices"][0]["address"]
    log = place.folder / "log.jsonl"
    text = config(bench="r", devices={"m1": {}})
    text = text.replace('"devices": {', f'"devices": {{"m2": {{"profile": "mechaduino", "at": "{at}"}}, ')
    real = place.serve(text, "--log", str(log), bench="r").ready()
    answer = rb"stepNumber: 0 , Angle: 6.28, raw encoder: \d+\r\n"
    for device in ("m1", "m2"):
        with real.client(device) as terminal:
            assert re.fullmatch(answer, terminal.ask(b"p")), device
    refused = hil(place, "reset", "m2", "-b", "r")
    assert "m2 is a real mechaduino: its terminal has no reset; do it at the board" in refused.stderr
    twins.stop()
    until(lambda: real.status("m2")["note"], "the loss")
    real.stop()
    replayed = subprocess.run([HIL, "replay", str(log)], capture_output=True, text=True, timeout=PATIENCE_S)
    assert replayed.stdout.startswith("identical: "), replayed


@pytest.mark.filterwarnings("ignore:set(Daemon|Name)")
def test_a_board_at_our_own_rfc2217_port_goes_and_comes_back(place: Place) -> None:
    port = {"kind": "rfc2217", "listen": free_port()}
    text = config(speed=5, devices={"s1": SAC | {"port": port}})
    at = f"rfc2217://127.0.0.1:{port['listen']}"
    twins = place.serve(text)
    real = place.serve(real_config(s2={"profile": "sac", "at": at}), bench="r")
    with real.client("s2") as terminal:
        for turn in range(2):
            until(lambda: "is away" not in (real.status("s2")["note"] or ""), "the board")
            twins.ready(boot_ns=SAC_READY_NS)
            terminal.quiet(0.1)
            assert terminal.ask(b"vd\r", b"0\t0\r\nSAC>").endswith(b"vd\r\n0\t0\r\nSAC>")
            if turn == 0:
                twins.stop()
                until(lambda: "is away" in (real.status("s2")["note"] or ""), "the loss")
                twins = place.serve(text)


def away(place: Place, at: str, **launch: Any) -> tuple[str, str]:
    """Problem of a bench with a real board there, and the remedy."""
    server = place.serve(real_config(r1={"profile": "sac", "at": at}), bench="r", **launch)
    (problem,) = [each for each in server.ask("status")["health"]["problems"] if each["about"] == "r1"]
    server.stop()
    return problem["what"].removeprefix(f"{at}: "), problem["remedy"].removesuffix(
        "; it is tried again each second"
    )


def test_why_a_board_is_away_and_what_brings_it_back(place: Place) -> None:
    assert away(place, "/dev/ttyUSB97") == (
        "No such file or directory",
        "plug it in",
    )
    said, remedy = away(place, "/dev/null")
    assert "Inappropriate ioctl" in said
    assert remedy == "this is no serial port: correct `at:`"
    said, remedy = away(place, "socket://127.0.0.1:1")
    assert "Connection refused" in said
    assert remedy == "start what listens there"
    main, terminal = os.openpty()
    with serial.Serial(os.ttyname(terminal), exclusive=True):
        said, remedy = away(place, os.ttyname(terminal))
        assert re.search(rf"^in use by \S+ \(process {os.getpid()}\)", said)
        assert remedy == "end the program that has it open"
    os.close(main)
    os.close(terminal)


def test_a_service_that_is_closed_to_adapters_says_what_opens_it(place: Place, tmp_path: Path) -> None:
    manager = Manager(tmp_path)
    said, remedy = away(place, "/dev/ttyUSB97", env=manager.env)
    manager.close()
    assert said.startswith("No such file or directory")
    assert "adapters.conf" in remedy
