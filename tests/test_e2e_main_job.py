"""The main job through real ports: every byte of every answer, at every client's pace."""

import os
import subprocess
import sys
import termios
import time

import pytest
import serial
from e2e_support import LOOKUP_HEAD, PATIENCE_S, Q_BYTES, Client, Place, config, until

TCP = {"port": {"kind": "tcp", "listen": 0}}
EMPTY = {"flash": {"table": "stored"}}
READ_TO = 60  # seconds, for pyserial


def read_until(port: serial.SerialBase, marker: bytes) -> bytes:
    """Read as pyserial's read_until, but say what is missing."""
    got = port.read_until(marker)
    assert got.endswith(marker), got[-300:]
    return got


def table(answer: bytes) -> list[str]:
    """The numbers of the look-up table in an answer to q."""
    body = answer.split(LOOKUP_HEAD)[1].split(b"\r\n};")[0].decode()
    return body.rstrip(", ").split(", ")


@pytest.mark.parametrize("port", [{"port": "pty"}, TCP], ids=["pty", "tcp"])
def test_main_job_through_pyserial(place: Place, port: dict[str, object]) -> None:
    server = place.serve(config(speed=20, devices={"m1": EMPTY | port}))
    address = server.ask("list")["devices"][0]["address"]
    with serial.serial_for_url(address, baudrate=115200, timeout=READ_TO) as board:
        banner = read_until(board, b"WARNING: Lookup table is empty! Run calibration\r\n")
        assert banner.startswith(
            b"\r\n\r\n----- Mechaduino 0.X -----\r\nFirmware: 0.1.5\r\nIdentifier: x\r\n"
        )
        assert b"Beginning SPI communication with AS5047 encoder...\r\n" in banner

        board.write(b"c")
        calibration = read_until(board, b"non-volatile Flash memory!\r\n \r\n \r\n")
        assert calibration.startswith(b"Beginning calibration routine...\r\n")
        for percent in range(0, 100, 10):
            assert b"\r\n%d%% ..................." % percent in calibration
        assert b"Calibration complete!" in calibration

        board.write(b"x")
        board.write(b"y")
        assert read_until(board, b"\r\n").startswith(b"New setpoint ")
        board.write(b"r")
        assert read_until(board, b"\r\n") == b"Enter setpoint:\r\n"
        board.write(b"90\n")
        assert read_until(board, b"\r\n") == b"90.00\r\n"
        until(lambda: abs(server.status()["snapshot"]["yw"] - 90) < 0.5, "the shaft at 90 degrees")
        board.write(b"p")
        answer = read_until(board, b"\r\n").decode()
        angle = float(answer.split("Angle: ")[1].split(",")[0])
        assert answer.startswith("stepNumber: -200 , Angle: ")
        assert angle == pytest.approx(90, abs=1.0)

        board.write(b"j")
        head = read_until(board, b"1...\r\n")
        assert head.count(b"\r\n") == 15
        numbers = [int(read_until(board, b"\r\n")) for _ in range(650)]
        assert max(numbers) == pytest.approx(99_994, abs=8_000)
    row = server.status()
    assert (row["dropped_bytes"], row["connects"], row["flash"]) == (0, 1, "ok")
    server.stop()


@pytest.mark.parametrize("port", [{"port": "pty"}, TCP], ids=["pty", "tcp"])
def test_every_byte_of_q(place: Place, port: dict[str, object]) -> None:
    server = place.serve(config(speed=100, devices={"m1": port})).ready()
    with server.client() as client:
        client.write(b"q")
        answer = client.read_exactly(Q_BYTES)
        angles = [float(angle) for angle in table(answer)]
        assert angles == pytest.approx([i * 360 / 16384 for i in range(16384)], abs=0.0051)
        assert client.quiet(0.2) == b""

        # A client that reads little at a time, with pauses.
        client.write(b"q")
        assert client.read_exactly(Q_BYTES, piece=97) == answer
        assert client.quiet(0.2) == b""

        # 2.5 MB of answers to 20 commands in a row, of which nothing is read at first.
        taken = server.status()["tx_bytes"]
        os.write(client.fd, b"q" * 20)
        until(
            lambda: (row := server.status())["tx_bytes"] + row["backlog_bytes"] > taken + Q_BYTES, "a backlog"
        )
        assert client.read_exactly(20 * Q_BYTES) == 20 * answer
        assert client.quiet(0.2) == b""
    assert server.status()["dropped_bytes"] == 0


@pytest.mark.parametrize("port", [{"port": "pty"}, TCP], ids=["pty", "tcp"])
def test_commands_that_wait_for_the_board_lose_nothing(place: Place, port: dict[str, object]) -> None:
    """The host is held up while the board boots; later each of its commands has its whole answer."""
    server = place.serve(config(speed=2, devices={"m1": port}))
    with server.client() as client:
        client.write(b"q" * 100)
        assert server.ask("status")["sim_ns"] < 3_900_000_000
        client.read_until(b"encoder...\r\n")
        answer = client.read_exactly(Q_BYTES)
        assert client.read_exactly(99 * Q_BYTES) == 99 * answer
        assert client.quiet(0.2) == b""
    row = server.status()
    assert (row["dropped_bytes"], row["failed"]) == (0, None)


def test_unpaced_at_any_baud(place: Place) -> None:
    server = place.serve(config(speed=100)).ready()
    path = server.ask("list")["devices"][0]["address"]
    for baud in (300, 9600, 115200, 1_000_000, 123_456):
        with serial.Serial(path, baud, timeout=READ_TO) as board:
            board.write(b"p")
            assert read_until(board, b"\r\n").startswith(b"stepNumber: 0 , Angle: ")


def test_pacing_takes_the_lines_time(place: Place) -> None:
    """Ask for the menu of 579 bytes."""
    server = place.serve(config(speed=1, devices={"m1": {"baud": 9600}})).ready()
    path = server.ask("list")["devices"][0]["address"]
    with serial.Serial(path, 9600, timeout=READ_TO) as board:
        board.reset_input_buffer()
        start = time.monotonic()
        board.write(b"m")
        menu = read_until(board, b"print main menu\r\n")
        elapsed_s = time.monotonic() - start
        line_s = len(menu) * 10 / 9600
        assert line_s > 0.5
        assert line_s < elapsed_s < line_s + PATIENCE_S
    assert server.status()["overrun_bytes"] == 0


def test_wrong_baud_is_resampled_both_ways(place: Place) -> None:
    """A board at 38,400 baud and a client at 19,200: `m` and CR arrive as E6 9E E6 80, none of which is
    a command; what the board says arrives as another set of bytes."""
    server = place.serve(
        config(speed=20, devices={"m1": {"baud": 38400}}), "--log", str(place.folder / "log")
    ).ready()
    path = server.ask("list")["devices"][0]["address"]
    with serial.Serial(path, 19200, timeout=0.5) as wrong:
        wrong.write(b"m\r")
        assert wrong.read(100) == b""
        place.cli("reset", "m1")
        wrong.timeout = READ_TO
        wrong.read(1)
        wrong.timeout = 0.5
        garbled = wrong.read(4096)
        assert len(garbled) > 50
        assert b"Mechaduino" not in garbled
    with serial.Serial(path, 38400, timeout=READ_TO) as right:
        right.write(b"m")
        assert b"----- Mechaduino 0.X -----" in read_until(right, b"print main menu\r\n")
    server.stop()
    assert '"data":"6d0d","client_baud":19200' in (place.folder / "log").read_text()
    assert "identical" in place.cli("replay", str(place.folder / "log"))


def test_a_terminal_program_that_echoes_does_not_echo(place: Place) -> None:
    """The port is raw for a client that sets nothing: no echo, no translation of line ends."""
    server = place.serve(config(speed=100)).ready()
    address = server.ask("list")["devices"][0]["address"]
    with Client(address) as client:
        settings = termios.tcgetattr(client.fd)
        assert not settings[3] & (termios.ECHO | termios.ICANON)
        client.write(b"\r\n\x03\x04p")
        assert client.read_until(b"\r\n").startswith(b"stepNumber: 0 ")


def test_the_printed_lines_work(place: Place) -> None:
    """The commands that `hil serve` prints can be pasted into a shell."""
    server = place.serve(config(speed=20, devices={"m1": {}, "m2": TCP})).ready()
    lines = [line.strip() for line in server.output.splitlines() if " -c " in line]
    assert len(lines) == 2
    for line in lines:
        assert sys.executable in line or os.path.realpath(sys.executable) in line
        done = subprocess.run(line, shell=True, capture_output=True, timeout=READ_TO, check=True)
        assert b"stepNumber: 0 , Angle: " in done.stdout
