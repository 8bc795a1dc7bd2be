"""Decoders of sigrok read what is exported as VCD: UARTs, Modbus, step and direction, CAN."""

import shutil
import subprocess
from pathlib import Path

import pytest
from exported_bench import READ, opened, recorded

from hil.recorded.exports.signal_sources import signal_sources
from hil.recorded.exports.vcd_export import write_vcd
from hil.sim.input_log import InputLog
from hil.sim.inputs import Bytes
from hil.vocab.time import SimTimeNs

pytest.importorskip("vcd", reason="pyvcd is not installed: make .venv/.dev")
pytestmark = pytest.mark.skipif(shutil.which("sigrok-cli") is None, reason="sigrok-cli is not installed")


@pytest.fixture(scope="module")
def log() -> InputLog:
    return recorded()


@pytest.fixture(scope="module")
def vcd(log: InputLog, tmp_path_factory: pytest.TempPathFactory) -> Path:
    run, end_ns = opened(log)
    sources = signal_sources(run, usb_baud=115200)
    file = tmp_path_factory.mktemp("vcd") / "run.vcd"
    with file.open("wb") as out:
        names = [name for each in sources for name in each.names]
        assert write_vcd(out, run, sources, names, SimTimeNs(0), end_ns) > 3000
    return file


def decoded(vcd: Path, decoders: str, shown: str) -> list[str]:
    """Annotations of decoders, one line each, without the decoder's name. 10 MHz are enough for them."""
    program = ["sigrok-cli", "-i", str(vcd), "-I", "vcd:downsample=100", "-P", decoders, "-A", shown]
    done = subprocess.run(program, capture_output=True, text=True, timeout=120, check=True)
    assert "rror" not in done.stderr, done.stderr
    return [line.partition(": ")[2] for line in done.stdout.splitlines()]


def uart_bytes(vcd: Path, options: str) -> bytes:
    return bytes(int(each, 16) for each in decoded(vcd, f"uart:{options}", "uart=rx-data"))


@pytest.mark.parametrize(("port", "baud"), [("s1", 38400), ("m1", 115200)])
def test_uarts_carry_the_bytes_of_the_log(log: InputLog, vcd: Path, port: str, baud: int) -> None:
    given = b"".join(
        each.input.data for each in log.inputs if each.device == port and isinstance(each.input, Bytes)
    )
    sent = b"".join(each.data for each in log.sent if each.device == port and not each.port)
    assert given
    assert uart_bytes(vcd, f"rx={port}.rx:baudrate={baud}") == given
    heard = uart_bytes(vcd, f"rx={port}.tx:baudrate={baud}")
    assert len(heard) > 20
    # What is printed at time 0 has no edge before it: its first characters are read wrong. The end of what is
    # printed last is after the run's.
    begin = sent.index(b"\n") + 1
    assert sent[begin:].startswith(heard[heard.index(b"\n") + 1 :])


@pytest.mark.thorough
def test_modbus_frames_of_a_line_with_parity(vcd: Path) -> None:
    raw = uart_bytes(vcd, "rx=bus1:baudrate=19200:parity=even")
    assert raw.startswith(READ)
    stack = "uart:rx=bus1:baudrate=19200:parity=even,modbus:cschannel=RX"  # both ways on one line
    request = decoded(vcd, stack, "modbus=cs-server-id:cs-function:cs-length:cs-crc")
    read = ["Slave ID: 1", "Function 4: Read Input Registers"]
    assert request[:4] == [*read, "Read 1 units of data", "CRC correct"]
    answer = decoded(vcd, stack, "modbus=sc-server-id:sc-function:sc-data:sc-crc")
    assert answer[-4:] == [*read, "0x0001 / 1", "CRC correct"]


def test_packets_of_a_segment(log: InputLog, vcd: Path) -> None:
    assert uart_bytes(vcd, "rx=bus0:baudrate=38400") == bytes.fromhex("55aa0011")


def test_steps_are_counted_at_both_ends_of_a_wire(vcd: Path) -> None:
    said = {
        name: decoded(vcd, f"stepper_motor:step={name}.{step}:dir={name}.dir", "stepper_motor=position")
        for name, step in (("s1", "clk"), ("m1", "step"))
    }
    positions = [int(each.split()[0]) for each in said["s1"]]
    assert said["m1"] == said["s1"]
    assert len(positions) == pytest.approx(200 + 40, abs=1)  # two pulses a step; the last has no next one
    assert max(map(abs, positions)) == pytest.approx(200, abs=1)
    assert abs(positions[-1]) == pytest.approx(160, abs=1)


def test_frames_of_a_can_bus(vcd: Path) -> None:
    decoder = "can:can_rx=can0:nominal_bitrate=500000"
    said = decoded(vcd, decoder, "can=id:ack-slot")
    boot_ups = [line for line in said if line.startswith("Identifier")]
    assert sorted(each.split()[1] for each in boot_ups) == ["1797", "1798"]  # of nodes 5 and 6
    assert said.count("ACK slot: ACK") == 2
    assert decoded(vcd, decoder, "can=warnings") == []
