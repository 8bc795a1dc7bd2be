"""A drive with a map of its own behind the Modbus door: the example as it stands, a changed map, a replay."""

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from e2e_support import PATIENCE_S, Place, Server, free_port, until
from markdown_blocks import block, fits
from pymodbus.client import ModbusTcpClient

EXAMPLE = Path(__file__).parents[1] / "examples" / "modbus"
ANGLE = r" *-?\d+\.\d\d$"
PAGE, SECTION = "docs/how-to/modbus.md", "A drive of your own"
READY_NS = 200_000_000


@pytest.fixture
def place() -> Iterator[Place]:
    with Place() as place:
        place.write((EXAMPLE / "lathe.yaml").read_text(), "lathe.yaml")
        yield place


def serve(place: Place, port: int, *options: str) -> Server:
    bench = (EXAMPLE / "bench.yaml").read_text()
    bench = bench.replace("modbus: {}", f"modbus: {{listen: 127.0.0.1:{port}}}")
    return place.serve(bench, *options, bench="shop").ready(boot_ns=READY_NS)


def test_the_example_prints_what_stands_beside_it(place: Place) -> None:
    """Where the shaft stands varies by the noise of its loop."""
    port = free_port()
    serve(place, port)
    program = EXAMPLE / "point_table.py"
    command = [sys.executable, str(program), str(port)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    assert done.stderr == ""
    shown = program.with_suffix(".txt").read_text()
    assert [re.sub(ANGLE, "", line) for line in done.stdout.splitlines()] == [
        re.sub(ANGLE, "", line) for line in shown.splitlines()
    ]
    said, wanted = (
        [float(line.split()[-1]) for line in text.splitlines() if line.startswith("point")]
        for text in (done.stdout, shown)
    )
    assert said == pytest.approx(wanted, abs=0.3)


def test_the_page_shows_the_example() -> None:
    assert block(PAGE, SECTION) == (EXAMPLE / "bench.yaml").read_text()
    assert block(PAGE, SECTION, 1) == (EXAMPLE / "lathe.yaml").read_text()


def test_a_fault_is_made_and_cleared_as_the_page_says(place: Place) -> None:
    port = free_port()
    serve(place, port)
    with ModbusTcpClient("127.0.0.1", port=port) as plc:
        plc.write_register(20, 1)
        place.hil("set", "x1", "errfl", "1")
        until(lambda: plc.read_discrete_inputs(7, count=1).bits[0], "the fault")
        assert plc.read_input_registers(4, count=2).registers == [0, 2]
        assert "fault 2: the encoder reports an error" in place.hil("status")
        assert plc.write_register(20, 0).isError() is False
        assert plc.write_register(20, 1).exception_code == 6
        plc.write_coil(3, True)
        assert plc.write_register(20, 1).isError() is False
        assert plc.read_input_registers(4, count=2).registers == [1, 0]
        place.hil("axis", "x1", "move-abs", "45")
        until(lambda: plc.read_input_registers(4, count=1).registers == [1], "the move's end")
        assert plc.read_holding_registers(10, count=2).registers == [4500, 0]


def test_the_example_is_as_short_as_it_says() -> None:
    assert len((EXAMPLE / "point_table.py").read_text().splitlines()) < 40
    assert len((EXAMPLE / "lathe.yaml").read_text().splitlines()) == 20


def test_a_map_is_shown_and_a_changed_one_is_there_after_a_reload(place: Place) -> None:
    port = free_port()
    server = serve(place, port)
    shown = place.hil("modbus", "map", "x1", "--runtime-dir", str(place.runtime))
    command, _, page = block(PAGE, SECTION, 2).partition("\n")
    assert command == "$ hil modbus map x1"
    assert fits(page.replace("1502", str(port)), shown), shown
    text = (EXAMPLE / "lathe.yaml").read_text()
    with ModbusTcpClient("127.0.0.1", port=port) as plc:
        assert plc.read_holding_registers(12, count=1).registers == [60]
        place.write(text.replace("{holding: 12}", "{holding: 12, type: i8}"), "lathe.yaml")
        refused = place.hil("reload", "--runtime-dir", str(place.runtime), code=2)
        assert "lathe.yaml:14:39: set_velocity_rpm.type:" in refused
        assert plc.read_holding_registers(12, count=1).registers == [60]
        place.write(text.replace("{holding: 12}", "{holding: 112}"), "lathe.yaml")
        place.hil("reload", "--runtime-dir", str(place.runtime))
        server.ready(since_ns=server.ask("status")["sim_ns"], boot_ns=READY_NS)
        assert plc.read_holding_registers(12, count=1).exception_code == 2
        assert plc.read_holding_registers(112, count=1).registers == [60]
        assert plc.read_device_information().information[1] == b"SV-20"


def test_what_a_master_wrote_is_replayed_without_the_map_at_hand(place: Place, tmp_path: Path) -> None:
    port, log = free_port(), tmp_path / "log.jsonl"
    server = serve(place, port, "--log", str(log))
    with ModbusTcpClient("127.0.0.1", port=port) as plc:
        plc.write_registers(10, [9000, 0, 120, 3000])
        plc.write_register(20, 1)
        plc.write_register(20, 3)
        while plc.read_input_registers(4, count=1).registers[0] & 2:
            pass
    server.stop()
    (place.folder / "lathe.yaml").unlink()
    assert place.hil("replay", str(log)).startswith("identical: ")
