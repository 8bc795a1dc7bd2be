"""Register maps of the boards that come with hil: their numbers are a promise, kept in golden files.

``python tests/test_register_maps.py`` writes them again, after a change that is meant.
"""

from dataclasses import replace
from pathlib import Path

import pytest

from bridges.modbus.maps.drive_map_text import drive_map_of
from bridges.modbus.registers.map_rows import formatted, map_rows
from bridges.modbus.registers.register_map import register_map
from bridges.modbus.registers.registers_protocol import UnitMap
from bridges.modbus.registers.units import unit_of
from hil.compose.find import find_catalogue
from hil.core.kinds import KINDS
from hil.sim.twin_info import twin_info
from hil.vocab.desk_protocol import DeviceInfo

GOLDEN = Path(__file__).parent / "register_maps"
KINDS_OF_BOARD = ("mechaduino", "sac")
DRIVE = "modbus_drive"


def info_of(profile: str) -> DeviceInfo:
    catalogue = find_catalogue()
    law = catalogue.profiles[profile].law
    assert law
    return twin_info(profile, profile, catalogue.boards[profile], KINDS[law])


def drives_map() -> UnitMap:
    text = find_catalogue().profiles[DRIVE].map
    assert text
    return unit_of(replace(info_of(DRIVE), own_map=drive_map_of(text))).map


def lines_of(of: UnitMap) -> list[str]:
    return [f"CRC {of.crc:08x}", *formatted(map_rows(of), "csv")]


@pytest.mark.parametrize("profile", KINDS_OF_BOARD)
def test_the_numbers_stay(profile: str) -> None:
    golden = (GOLDEN / f"{profile}.csv").read_text().splitlines()
    assert lines_of(register_map(info_of(profile))) == golden


def test_the_numbers_of_the_map_that_is_built_in_stay() -> None:
    assert lines_of(drives_map()) == (GOLDEN / f"{DRIVE}.csv").read_text().splitlines()


@pytest.mark.parametrize("profile", KINDS_OF_BOARD)
def test_no_two_values_share_a_register(profile: str) -> None:
    of = register_map(info_of(profile))
    assert len(of.at) == sum(cell.width for cell in of.cells)


@pytest.mark.parametrize("profile", KINDS_OF_BOARD)
def test_every_verb_and_field_is_in_it_or_among_the_notes(profile: str) -> None:
    info = info_of(profile)
    of = register_map(info)
    names = {cell.name for cell in of.cells}
    assert info.fields.keys() <= names
    noted = {note.split()[0] for note in of.notes}
    assert info.verbs.keys() - names - noted == {"pin", "zero"}  # its pins and its angle are


if __name__ == "__main__":
    GOLDEN.mkdir(exist_ok=True)
    for kind in KINDS_OF_BOARD:
        text = "\n".join(lines_of(register_map(info_of(kind))))
        (GOLDEN / f"{kind}.csv").write_text(text + "\n")
    (GOLDEN / f"{DRIVE}.csv").write_text("\n".join(lines_of(drives_map())) + "\n")
