"""A sketch in a running bench: what commands tell of it, and Debian's avr-gdb at it."""

import json
import re
import shutil
import socket
import subprocess
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest
from e2e_support import HIL, PATIENCE_S, Place, Server, config, free_port, reload, until

from hil.sketch.chip_program import read_program
from hil.sketch.intel_hex import write_hex
from hil.toolchain.avr_tools import find_avr_tools
from hil.toolchain.build_failed import NoToolchain

SKETCH = """volatile int turns = 0;
__attribute__((noinline)) int twice(int x) {
  volatile int y = x * 2;
  return y;
}
void setup() {
  Serial.begin(115200);
}
void loop() {
  turns++;
  Serial.println(twice(turns));
  delay(5);
}
"""


def missing() -> str:
    try:
        core = find_avr_tools({"PATH": "/usr/bin:/bin"}).core
    except NoToolchain as error:
        return str(error)
    if not core:
        return "arduino-core-avr is not installed"
    return "" if shutil.which("avr-gdb") else "avr-gdb is not installed: `apt install gdb-avr`"


pytestmark = [pytest.mark.skipif(bool(missing()), reason=missing()), pytest.mark.long]


@pytest.fixture(scope="module")
def bench() -> Iterator[tuple[Place, Server]]:
    with Place() as place:
        (place.folder / "turns").mkdir()
        (place.folder / "turns" / "turns.ino").write_text(SKETCH)
        place.hil("sketch", "build", str(place.folder / "turns"), timeout_s=120)
        server = place.serve(config(devices={"u1": {"profile": "uno"}, "m1": {}})).ready("m1")
        load(place)
        until(lambda: server.ask("processor", device="u1")["is_running"], "its program")
        yield place, server


def elf_of(place: Place) -> Path:
    return place.folder / "turns" / "build" / "turns.elf"


def load(place: Place) -> None:
    place.cli("sketch", "load", "u1", str(elf_of(place)), "--runtime-dir", str(place.runtime))


def asked(place: Place, *words: str, code: int = 0) -> str:
    return place.cli("sketch", *words, "--runtime-dir", str(place.runtime), code=code)


def test_pins_and_registers_are_named(bench: tuple[Place, Server]) -> None:
    place, _ = bench
    assert re.search(r"^ D1 +output +[01] ", asked(place, "pins", "u1"), re.M)
    said = asked(place, "registers", "u1", "ubrr0", "R0", "PC")
    assert re.search(r"^ UBRR0 +0xC4 +0x0010 +16 +0{11}10000 *$", said, re.M)
    assert re.search(r"^PC 0x[0-9A-F]{4}, in \w", said, re.M)
    assert len(json.loads(asked(place, "registers", "u1", "--json"))) > 100
    assert "did you mean" in asked(place, "registers", "u1", "UBBR0", code=2)


def test_the_stack_and_the_heap_are_measured(bench: tuple[Place, Server]) -> None:
    answer = json.loads(asked(bench[0], "stack", "u1", "--json"))
    assert answer["heap_start"] == answer["heap_end"]
    assert answer["heap_start"] < answer["stack_lowest"] <= answer["stack_pointer"] <= 0x8FF
    assert answer["free_bytes"] == answer["stack_lowest"] - answer["heap_end"]
    assert answer["stack_bytes"] == 0x900 - answer["stack_lowest"]


def test_turns_of_loop_are_measured(bench: tuple[Place, Server]) -> None:
    answer = json.loads(asked(bench[0], "cycles", "u1", "--for", "100ms", "--json"))
    assert 79_000 < answer["least"] <= answer["median"] <= answer["most"] < 90_000  # 5 ms, and a line
    assert answer["turns"] >= 10
    assert "median" in asked(bench[0], "cycles", "u1", "--for", "50ms")


def test_a_profile_has_each_cycle(bench: tuple[Place, Server]) -> None:
    place, _ = bench
    answer = json.loads(asked(place, "profile", "u1", "--for", "100ms", "--json"))
    rows = {row["function"]: row for row in answer["functions"]}
    assert sum(row["cycles"] for row in answer["functions"]) == answer["cycles"]
    assert rows["micros()"]["calls"] > 1000
    assert rows["twice()"]["calls"] == pytest.approx(rows["loop()"]["calls"], abs=1)
    overflows = answer["cycles"] / (256 * 64)
    assert rows["ISR(TIMER0_OVF_vect)"]["calls"] == pytest.approx(overflows, abs=1)
    assert " micros()" in asked(place, "profile", "u1", "--for", "50ms")


def test_symbols_come_from_the_elf_file_beside_the_hex_file(bench: tuple[Place, Server]) -> None:
    place, server = bench
    said = asked(place, "load", "u1", str(elf_of(place).with_suffix(".hex")))
    assert said.startswith("u1 runs turns.hex, ")
    until(lambda: server.ask("processor", device="u1")["is_running"], "its program")
    assert json.loads(asked(place, "stack", "u1", "--json"))["stack_bytes"] > 0


def test_a_program_without_symbols_says_so_until_its_elf_file_is_found(
    bench: tuple[Place, Server], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place, server = bench
    alone = shutil.copy(elf_of(place).with_suffix(".hex"), tmp_path)
    monkeypatch.chdir(tmp_path)
    asked(place, "load", "u1", alone)
    until(lambda: server.ask("processor", device="u1")["is_running"], "its program")
    for command in ("cycles", "profile", "stack"):
        said = asked(place, command, "u1", code=1)
        assert "the names of functions in u1 are not known, and no .elf here or in build is of its" in said
    assert "stack_bytes" in asked(place, "stack", "u1", "--elf", str(elf_of(place)), "--json")
    (tmp_path / "build").mkdir()
    (tmp_path / "build" / "a.elf").write_bytes(b"of something else")
    shutil.copy(elf_of(place), tmp_path / "build" / "b.elf")
    assert "stack_bytes" in asked(place, "stack", "u1", "--json")
    longer = read_program("x", Path(alone).read_bytes()).flash + b"of a longer one before it"
    (tmp_path / "longer.hex").write_bytes(write_hex([(0, longer)]))
    asked(place, "load", "u1", str(tmp_path / "longer.hex"))
    until(lambda: server.ask("processor", device="u1")["is_running"], "its program")
    assert "stack_bytes" in asked(place, "stack", "u1", "--json")
    load(place)
    until(lambda: server.ask("processor", device="u1")["is_running"], "its program")


def test_printed_numbers_are_drawn(bench: tuple[Place, Server], tmp_path: Path) -> None:
    place, _ = bench
    table = tmp_path / "turns.csv"
    said = asked(place, "plot", "u1", "--seconds", "1", "-o", str(table))
    assert "samples of 1" in said
    head, *lines = table.read_text().splitlines()
    assert head == "at_ns,1"
    assert lines[0].startswith("0,")
    rows = [tuple(map(float, line.split(","))) for line in lines]
    assert len(rows) > 20
    assert all(at == before + 2 and at_ns >= before_ns for (before_ns, before), (at_ns, at) in pairwise(rows))
    assert "┤" in asked(place, "plot", "u1", "--seconds", "0.5")
    assert "m1 has printed no numbers in this time (no whole line)" in asked(
        place, "plot", "m1", "--seconds", "0.05", code=1
    )


class Door:
    """`hil sketch gdb u1` for one GDB."""

    def __init__(self, place: Place) -> None:
        self.place, self.port = place, free_port()
        options = ("sketch", "gdb", "u1", "--port", str(self.port), "--once")
        command = [HIL, *options, "--runtime-dir", str(place.runtime)]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        assert "avr-gdb" in self.process.stdout.readline()

    def gdb(self, *lines: str) -> str:
        """Carry out lines in GDB; answers what it says."""
        head = ("set pagination off", "set confirm off", f"target remote :{self.port}")
        words = [word for line in (*head, *lines) for word in ("-ex", line)]
        command = ["avr-gdb", "-q", "-batch", "-nx", *words, str(elf_of(self.place))]
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
        return done.stdout + done.stderr

    def close(self) -> None:
        self.process.terminate()
        self.process.communicate(timeout=PATIENCE_S)


@pytest.fixture
def door(bench: tuple[Place, Server]) -> Iterator[Door]:
    made = Door(bench[0])
    yield made
    made.close()


def values(said: str) -> list[int]:
    return [int(value) for value in re.findall(r"^\$\d+ = (-?\d+)$", said, re.M)]


def sim_ns(server: Server) -> int:
    return int(server.ask("status")["sim_ns"])


def test_it_stops_steps_and_prints(bench: tuple[Place, Server], door: Door) -> None:
    said = door.gdb(
        *("break loop", "continue", "print turns", "next", "print turns", "step", "info args", "backtrace"),
        *("finish", "set var turns = 1000", "delete", "tbreak twice", "continue", "print x", "stepi"),
        *("info registers pc", "detach"),
    )
    print(said)
    before, after, x = values(said)
    assert after == before + 1
    assert x == 1001
    assert "Breakpoint 1, loop () at " in said
    assert re.search(rf"#0 +twice \(x=(x@entry=)?{after}\) at .*turns.ino:3", said)
    assert "#2 " in said
    assert "Value returned is" in said
    assert re.search(r"^pc +0x", said, re.M)
    assert "detached" in said
    assert door.process.wait(PATIENCE_S) == 0


def test_time_stands_with_the_program_and_goes_on_after_it(bench: tuple[Place, Server], door: Door) -> None:
    _, server = bench
    with socket.create_connection(("127.0.0.1", door.port)) as gdb:
        gdb.sendall(b"$?#3f")
        until(lambda: gdb.recv(4096).endswith((b"+", b"#")) or True, "an answer")
        until(lambda: server.ask("status")["is_paused"], "the stop")
        assert sim_ns(server) == sim_ns(server)
        assert server.ask("processor", device="u1")["is_halted"]
    until(lambda: not server.ask("status")["is_paused"], "time")
    before_ns = sim_ns(server)
    until(lambda: sim_ns(server) > before_ns, "time")
    assert not server.ask("processor", device="u1")["is_halted"]


@pytest.mark.thorough
def test_a_second_gdb_is_refused(bench: tuple[Place, Server], door: Door) -> None:
    place, server = bench
    with socket.create_connection(("127.0.0.1", door.port)):
        until(lambda: server.ask("status")["is_paused"], "the stop")
        other = Door(place)
        with socket.create_connection(("127.0.0.1", other.port)) as late:
            assert late.recv(1) == b""
        other.close()
    assert "u1 runs no compiled program" not in door.gdb("detach")


@pytest.mark.thorough
def test_a_port_in_use_is_refused(bench: tuple[Place, Server], door: Door) -> None:
    where = ("--runtime-dir", str(bench[0].runtime))
    said = bench[0].hil("sketch", "gdb", "u1", "--port", str(door.port), *where, code=2)
    assert f"hil: --port: 127.0.0.1:{door.port} is in use by " in said


@pytest.mark.thorough
def test_a_reset_and_another_program_are_told_in_gdb(bench: tuple[Place, Server], door: Door) -> None:
    place, server = bench
    with socket.create_connection(("127.0.0.1", door.port)) as gdb:
        gdb.settimeout(PATIENCE_S)
        gdb.sendall(b"$QStartNoAckMode#b0+$c#63")
        until(lambda: server.ask("status")["is_paused"] is False, "time")
        said = bytearray(gdb.recv(4096))
        place.cli("reset", "u1", "--runtime-dir", str(place.runtime))
        load(place)
        while b"another program".hex().encode() not in said:
            said += gdb.recv(4096)
        assert b"the chip was reset".hex().encode() in said


@pytest.mark.thorough
def test_a_device_that_leaves_the_bench_ends_gdb(bench: tuple[Place, Server], door: Door) -> None:
    place, server = bench
    with socket.create_connection(("127.0.0.1", door.port)) as gdb:
        gdb.settimeout(PATIENCE_S)
        gdb.sendall(b"$QStartNoAckMode#b0+$c#63")
        until(lambda: server.ask("status")["is_paused"] is False, "time")
        reload(place, server, {"m1": {}})
        said = bytearray()
        while piece := gdb.recv(4096):
            said += piece
        assert b"u1 has left the bench".hex().encode() in said
        assert b"$W00#" in said


@pytest.mark.thorough
def test_a_replay_has_what_gdb_wrote(bench: tuple[Place, Server]) -> None:
    with Place() as place:
        shutil.copytree(bench[0].folder / "turns", place.folder / "turns")
        log = place.folder / "gdb.log"
        program = str(elf_of(place).with_suffix(".hex"))
        devices = {"u1": {"profile": "uno", "firmware": program, "auto_reset": False}}
        server = place.serve(config(speed=1, devices=devices), "--log", str(log))
        with server.client("u1") as client:
            client.read_until(b"\r\n")
            assert "stack_bytes" in asked(place, "stack", "u1", "--json")  # symbols of the .elf beside it
            door = Door(place)
            door.gdb("set var turns = 1000", "set var $r4 = 77", "break twice", "continue", "detach")
            door.close()
            client.read_until(b"\r\n2010\r\n")
        server.stop()
        written = [json.loads(line) for line in log.read_text().splitlines() if "write_memory" in line]
        assert ("data", 4, "4d") in [(row["memory"], row["at"], row["data"]) for row in written]
        assert place.cli("replay", str(log)).startswith("identical: ")
