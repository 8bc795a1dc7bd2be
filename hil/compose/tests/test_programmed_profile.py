"""A board that is a ``profile.yaml`` with a processor, and no Python."""

from pathlib import Path

import pytest

from hil.compose import find_catalogue
from hil.core.fields import OFFSETS
from hil.sim.twin_info import info_of
from hil.testing import Bench
from hil.vocab.problem import ConfigError

NODE = "name: node\ntitle: Node\nprocessor: {chip: atmega328p, pins: {LED: PB5, FAN: PD3, SENSE: ADC6}}\n"
MCUSR = 0x54
SPINS = b"\xff\xcf"
"""RJMP to itself."""


def bench_of(folder: Path, text: str = NODE, **device: object) -> Bench:
    board = folder / "boards/node"
    board.mkdir(parents=True)
    (board / "profile.yaml").write_text(text)
    devices = {"x1": {"profile": "node", **device}}
    return Bench({"bench": "t", "profile_path": [str(folder / "boards")], "devices": devices})


def test_doors_have_its_names(tmp_path: Path) -> None:
    with bench_of(tmp_path) as bench:
        board = find_catalogue(path=[tmp_path / "boards"]).boards["node"]
        info = info_of(bench.runtime.devices["x1"], "", board)
        assert info.inputs == {"FAN": "pin_levels.3", "LED": "pin_levels.13"}
        voltages = [field for field in info.fields.values() if field.unit == "V"]
        assert [field.name for field in voltages] == ["vcc_V", "fan_V", "sense_V"]
        assert [field.is_settable for field in voltages] == [True, False, True]
        assert info.fields["sense_V"].offset == OFFSETS["a6_V"]


def test_a_chip_alone_has_a_unos_names(tmp_path: Path) -> None:
    with bench_of(tmp_path, "name: node\ntitle: Node\nprocessor: atmega328p\n") as bench:
        assert "D13" in bench.runtime.devices["x1"].axis.pins
        bench.run(ms=10)
        assert bench.device("x1").notes["runs"] == "runs nothing: there is no program in the flash"


def test_others_need_their_python(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"board.py:1:1: this file is missing"):
        bench_of(tmp_path, "name: node\ntitle: Node\n")


@pytest.mark.parametrize(("baud", "cause"), [("57600", 0), ("null", 1)])
def test_only_a_bootloader_clears_the_cause_of_a_reset(tmp_path: Path, baud: str, cause: int) -> None:
    program = tmp_path / "spins.hex"
    program.write_text(":02000000FFCF30\n:00000001FF\n")
    text = NODE.replace("atmega328p,", f"atmega328p, bootloader_baud: {baud},")
    with bench_of(tmp_path, text, firmware=str(program)) as bench:
        bench.run(ms=100)
        processor = bench.runtime.devices["x1"].processor
        assert processor.flash.startswith(SPINS)
        assert processor.data(MCUSR, 1)[0] == cause
        with bench.serial("x1"):
            bench.run(ms=3000)
        assert processor.data(MCUSR, 1)[0] == 3 * cause  # and the pin RESET
