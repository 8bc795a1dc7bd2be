"""Uploads to a Uno: what a tool is answered, what is in the flash then, and when what runs."""

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from random import Random
from typing import Any

import pytest
from upload_tool import EEPROM, FAILED, IN_SYNC, OK, NotAnswered, UploadTool

from hil.firmware.chip_memory import NOT_KEPT
from hil.sim.twin import Twin
from hil.sketch.chip_program import SECTION, flash_program, packed, unpacked
from hil.testing import Bench

IDLE = b"\xff\xcf"
"""RJMP to itself."""
SPINS = flash_program("spins.hex", IDLE)
PROGRAM = IDLE + Random(1).randbytes(700)


def bench_with(flash: bytes | None, **keys: Any) -> Bench:
    memories = {"u1": {SECTION: packed(flash_program("old.hex", flash))} if flash else {}}
    return Bench({"bench": "t", "devices": {"u1": {"profile": "uno", **keys}}}, memories=memories)


@pytest.fixture
def bench() -> Iterator[Bench]:
    with bench_with(IDLE) as made:
        made.run(ms=100)
        yield made


def opened(bench: Bench) -> UploadTool:
    return UploadTool(bench.serial("u1", timeout=0.4))


def synced(bench: Bench) -> UploadTool:
    tool = opened(bench)
    bench.run(ms=300)
    tool.sync()
    return tool


def kept(bench: Bench) -> bytes:
    return unpacked(bench.device("u1").nvm[SECTION]).flash


def runs(bench: Bench) -> str:
    return bench.device("u1").notes["runs"]


def test_an_upload_is_verified_and_kept_and_runs(bench: Bench) -> None:
    assert runs(bench) == f"runs old.hex, 2 bytes, {SPINS.digest[:12]}"
    tool = synced(bench)
    assert runs(bench) == "runs the bootloader"
    tool.write(PROGRAM)
    assert tool.read(len(PROGRAM)) == PROGRAM
    tool.leave()
    assert kept(bench) == PROGRAM  # before the tool hears that it is done
    bench.run(ms=20)
    assert runs(bench).startswith(f"runs what was uploaded, {len(PROGRAM)} bytes, ")
    bench.device("u1").reset()
    bench.run(ms=20)
    assert runs(bench).startswith("runs what was uploaded")


class FullDisk:
    """Store that takes nothing while its disk is full."""

    is_full = True

    def commit(
        self, device: Twin, sections: Mapping[str, bytes], answered: Callable[[bool], bool]
    ) -> bool | None:
        return not self.is_full


def test_a_full_disk_is_told_until_the_program_is_kept() -> None:
    disk = FullDisk()
    with Bench({"bench": "t", "devices": {"u1": {"profile": "uno"}}}, store=disk) as bench:
        bench.run(ms=100)
        tool = synced(bench)
        tool.write(PROGRAM)
        tool.leave()
        bench.run(ms=1500)
        assert runs(bench).startswith("runs what was uploaded")
        assert bench.device("u1").notes["memory"] == NOT_KEPT
        disk.is_full = False
        tool.port.close()
        opened(bench)
        bench.run(ms=2500)
        assert "memory" not in bench.device("u1").notes
        assert kept(bench) == PROGRAM


def test_what_is_uploaded_again_keeps_its_name(bench: Bench) -> None:
    tool = synced(bench)
    tool.write(IDLE)
    tool.leave()
    bench.run(ms=20)
    assert runs(bench) == f"runs old.hex, 2 bytes, {SPINS.digest[:12]}"


def test_pages_that_are_not_written_stay(bench: Bench) -> None:
    tool = synced(bench)
    tool.write(PROGRAM)
    tool.port.close()
    bench.run(ms=2000)
    tool = synced(bench)
    tool.write_page(128, b"new")
    tool.port.close()  # cut: no leave
    bench.run(ms=2000)
    whole = PROGRAM[:128] + b"new" + b"\xff" * 125 + PROGRAM[256:]
    assert kept(bench) == whole
    assert runs(bench).startswith("runs what was uploaded")


def test_an_upload_that_is_cut_by_the_next_opening_is_kept(bench: Bench) -> None:
    tool = synced(bench)
    tool.write(PROGRAM[:128])
    tool.port.close()
    tool = synced(bench)
    assert tool.read(128) == PROGRAM[:128]
    assert kept(bench) == PROGRAM[:128]


def test_the_led_flashes_and_the_sketch_starts_after_a_second(bench: Bench) -> None:
    opened(bench)
    at_ns = bench.now_ns
    bench.run(ms=2000)
    edges = bench.device("u1").pin("D13").edges()
    assert [level for _, level in edges if _ > at_ns] == [1, 0] * 3
    first, last = edges[0][0] - at_ns, edges[-1][0] - at_ns
    assert (round(first / 1e6, 1), round(last / 1e6, 1)) == (128.5, 440.8)
    tool = opened(bench)
    bench.run(ms=1430)
    assert runs(bench) == "runs the bootloader"
    bench.run(ms=20)
    assert runs(bench).startswith("runs old.hex")
    tool.port.close()


def test_bytes_in_reset_are_lost_and_three_wait_while_the_led_flashes(bench: Bench) -> None:
    tool = opened(bench)
    tool.port.write(b"0 ")
    bench.run(ms=80)
    tool.port.write(b"\x41\x81\xaa\xbb\xcc ")  # the receiver keeps the first two and the last
    bench.run(ms=400)
    assert tool.port.read(8) == IN_SYNC + b"\4" + OK


def test_each_byte_holds_the_sketch_off_for_a_second(bench: Bench) -> None:
    tool = synced(bench)
    for _ in range(3):
        bench.run(ms=900)
        tool.sync(1)
    bench.run(ms=1010)
    assert runs(bench).startswith("runs old.hex")


def test_a_command_that_ends_wrongly_starts_the_sketch(bench: Bench) -> None:
    tool = synced(bench)
    tool.port.write(b"\x75x")
    bench.run(ms=20)
    assert tool.port.read(5) == b""
    assert runs(bench).startswith("runs old.hex")


def test_parameters_signature_fuses_and_what_nobody_knows(bench: Bench) -> None:
    tool = synced(bench)
    assert [tool.ask(bytes((0x41, each)), 1) for each in (0x81, 0x82, 0x98)] == [b"\4", b"\4", b"\3"]
    assert tool.ask(b"u", 3) == b"\x1e\x95\x0f"
    asked = ((0x50, 0), (0x58, 8), (0x50, 8), (0x58, 0), (0xAC, 0x80), (0x12, 0x34))
    assert [tool.ask(bytes((0x56, *each, 0, 0)), 1)[0] for each in asked] == [0xFF, 0xDE, 0xFD, 0x0F, 0, 0]
    assert [tool.ask(bytes((0x56, 0x30, 0, each, 0)), 1)[0] for each in range(3)] == [0x1E, 0x95, 0x0F]
    assert tool.ask(b"B" + bytes(20)) == tool.ask(b"E" + bytes(5)) == tool.ask(b"P") == tool.ask(b"?") == b""
    assert "upload" not in bench.device("u1").notes


def test_the_eeprom_is_refused_with_the_reason(bench: Bench) -> None:
    tool = synced(bench)
    tool.write_page(0, b"ab", EEPROM, FAILED)
    assert "wanted the EEPROM" in bench.device("u1").notes["upload"]
    assert tool.read_page(0, 4, EEPROM, FAILED) == b"\xff" * 4
    assert tool.ask(b"\x56\xa0\0\0\0", 1, FAILED) == tool.ask(b"\x56\xc0\0\0\0", 1, FAILED) == b"\0"
    assert tool.read(2) == IDLE


def test_fuses_and_the_boot_section_cannot_be_written(bench: Bench) -> None:
    tool = synced(bench)
    tool.ask(b"\x56\xac\xa0\0\x62", 1)
    assert "fuses or lock bits" in bench.device("u1").notes["upload"]
    tool.write_page(0x7E00, b"ab")
    assert "from 0x7E00 on" in bench.device("u1").notes["upload"]
    assert tool.read_page(0x7E00, 2) == b"\xff\xff"
    tool.write_page(0x7D80, b"ab")
    assert tool.read_page(0x7D80, 2) == b"ab"


def test_a_page_takes_what_the_chip_takes(bench: Bench) -> None:
    tool = synced(bench)
    for at, least_ms in ((0, 4.5), (0x7000, 9.0)):
        tool.seek(at)
        begun_ns = bench.now_ns
        tool.ask(b"d\0\x80F" + bytes(128))
        # Of the answer the first byte goes out meanwhile.
        line_ms = (4 + 128 + 1 + 1) * 10 / 115.2
        assert abs((bench.now_ns - begun_ns) / 1e6 - line_ms - least_ms) < 0.001


@pytest.mark.parametrize("at", [0, 6, 130])
@pytest.mark.parametrize("count", [1, 5, 128, 200, 256])
def test_a_page_of_any_length_wraps_in_its_page(bench: Bench, at: int, count: int) -> None:
    tool, data = synced(bench), Random(count).randbytes(count)
    tool.seek(at)
    tool.ask(b"d" + count.to_bytes(2, "big") + b"F" + data)
    page = bytearray(b"\xff" * 128)
    for place, byte in enumerate(data[:128], at):
        page[place % 128] = byte
    assert tool.read_page(at // 128 * 128, 128) == page


def test_reading_goes_on_where_it_ended_and_around(bench: Bench) -> None:
    tool = synced(bench)
    tool.write(PROGRAM)
    tool.seek(2)
    assert b"".join(tool.ask(b"t\0\x05F", 5) for _ in range(3)) == PROGRAM[2:17]
    tool.seek(0x7FFE)
    assert tool.ask(b"t\1\0F", 256) == b"\xff\xff" + PROGRAM[:254]


def test_at_another_baud_nothing_is_written(bench: Bench) -> None:
    tool = opened(bench)
    tool.port.baudrate = 57600
    bench.run(ms=300)
    with pytest.raises(NotAnswered):
        tool.sync()
    bench.run(ms=1500)
    assert (runs(bench), kept(bench)) == (f"runs old.hex, 2 bytes, {SPINS.digest[:12]}", IDLE)


def test_without_auto_reset_nothing_is_uploaded() -> None:
    with bench_with(IDLE, auto_reset=False) as bench:
        bench.run(ms=100)
        tool = opened(bench)
        bench.run(ms=300)
        with pytest.raises(NotAnswered):
            tool.sync()
        assert runs(bench).startswith("runs old.hex")


# ---- a program's own writes ----

WRITES_EEPROM = bytes.fromhex("0bea 00bd 15e0 11bd fa9a f99a ffcf")
"""LDI r16,ABh; OUT EEDR,r16; LDI r17,5; OUT EEARL,r17; SBI EECR,EEMPE; SBI EECR,EEPE; RJMP to itself."""


def test_an_eeprom_that_is_written_outlives_the_power_at_once() -> None:
    with bench_with(WRITES_EEPROM) as bench:
        bench.run(ms=66)
        assert "eeprom" not in bench.device("u1").nvm
        bench.run(ms=4)
        bench.device("u1").reset()
        assert bench.device("u1").nvm["eeprom"] == b"\xff" * 5 + b"\xab" + b"\xff" * 1018


def test_the_eeprom_begins_with_what_the_file_has_and_goes_on_with_what_is_kept() -> None:
    program = packed(replace(flash_program("x.elf", IDLE), eeprom=b"\1\2"))
    for stored, first in (
        ({}, b"\1\2\xff"),
        ({"eeprom": bytes(1024)}, b"\0\0\0"),
        ({"eeprom": b"step"}, b"\1\2\xff"),
    ):
        config = {"bench": "t", "devices": {"u1": {"profile": "uno"}}}
        with Bench(config, memories={"u1": {SECTION: program, **stored}}) as bench:
            bench.run(ms=10)
            assert bench.device("u1").nvm["eeprom"][:3] == first


def test_a_memory_of_a_later_hil_is_left_alone() -> None:
    memory = {SECTION: b"hil program 2\n"}
    with Bench({"bench": "t", "devices": {"u1": {"profile": "uno"}}}, memories={"u1": memory}) as bench:
        bench.run(ms=100)
        assert "in a form that this hil does not know" in bench.device("u1").notes[SECTION]
        assert bench.device("u1").nvm == memory


# ---- beside hil's own sketch ----


def test_hils_own_sketch_goes_on_when_the_port_is_opened() -> None:
    with bench_with(None) as bench:
        bench.port("u1").write(b"move 100000\n")
        bench.run(ms=100)
        port = bench.serial("u1", timeout=0.1)
        port.write(b"pin 3\n")
        assert b"pin 3 is 0\r\n" in port.read(100)
        assert bench.axis("u1").snapshot().pulses_left > 0


@pytest.mark.parametrize("typed", [b"0\n", b"0", b" 0 ", b"pin 0 \n0 "])
def test_only_a_tools_first_bytes_after_the_opening_are_one(typed: bytes) -> None:
    with bench_with(None) as bench:
        bench.run(ms=100)
        port = bench.serial("u1", timeout=0.1)
        port.write(typed)
        port.write(b"\npin 3\n")
        assert port.read(200).endswith(b"pin 3 is 0\r\n")
        port.write(b"0 ")
        assert port.read(10) == b""


@pytest.mark.parametrize("pieces", [[b"0 "], [b"0", b" "], [b"0 0 "]])
def test_a_tool_takes_over_from_hils_own_sketch(pieces: list[bytes]) -> None:
    with bench_with(None) as bench:
        bench.port("u1").write(b"pin 8 1\nmove 100000\n")
        bench.run(ms=100)
        tool = opened(bench)
        for piece in pieces:
            tool.port.write(piece)
            bench.run(ms=5)
        assert tool.port.read(2) == IN_SYNC + OK
        tool.port.reset_input_buffer()
        tool.write(PROGRAM)
        tool.leave()
        bench.run(ms=20)
        assert runs(bench).startswith("runs what was uploaded")
        assert bench.device("u1").pin("D8").edges()[-1][1] == 0


def test_a_tool_that_uploads_nothing_leaves_hils_own_sketch() -> None:
    with bench_with(None) as bench:
        bench.run(ms=100)
        tool = opened(bench)
        tool.sync(1)
        bench.run(ms=1100)
        bench.port("u1").read()
        bench.port("u1").write(b"pin 3\n")
        bench.run(ms=50)
        assert bench.port("u1").read() == b"\r\npin 3 is 0\r\n"


# ---- noise ----


def test_whatever_comes_the_board_can_be_uploaded_to_again(bench: Bench) -> None:
    """``HIL_FUZZ``: how many commands; ``HIL_FUZZ_SEED``."""
    random = Random(int(os.environ.get("HIL_FUZZ_SEED", "1")))
    tool = synced(bench)
    for _ in range(int(os.environ.get("HIL_FUZZ", "150"))):
        command = bytes((random.choice(b"0ABEPQUVdtu?\x00\xff"),)) + random.randbytes(
            random.choice((0, 1, 3, 5, 20))
        )
        if random.random() < 0.7:
            command += b" "
        for byte in command if random.random() < 0.3 else ():
            tool.port.write(bytes((byte,)))
            bench.run(ms=random.choice((0.05, 1)))
        tool.port.write(command)
        bench.run(ms=random.choice((0.1, 3, 40)))
        if random.random() < 0.1:
            tool.port.close()
            tool.port.open()
            bench.run(ms=random.choice((10, 100, 500)))
    tool.port.close()
    bench.run(ms=3000)
    assert bench.device("u1").failed is None
    tool = synced(bench)
    tool.write(PROGRAM)
    assert tool.read(len(PROGRAM)) == PROGRAM
    tool.leave()
    assert kept(bench)[: len(PROGRAM)] == PROGRAM
