"""Register maps of the boards that come with hil: their numbers are a promise, kept in golden files.

``python tests/test_register_maps.py`` writes them anew, after a change that is meant.
"""

from pathlib import Path

import pytest

from hil.compose.find import find_catalogue
from hil.core.kinds import KINDS
from hil.registers.map_rows import formatted, map_rows
from hil.registers.register_map import RegisterMap, register_map
from hil.sim.twin_info import twin_info
from hil.vocab.desk_protocol import DeviceInfo

GOLDEN = Path(__file__).parent / "register_maps"
KINDS_OF_BOARD = ("mechaduino", "sac")


def info_of(profile: str) -> DeviceInfo:
    catalogue = find_catalogue()
    law = catalogue.profiles[profile].law
    assert law
    return twin_info(profile, profile, catalogue.boards[profile], KINDS[law])


def lines_of(of: RegisterMap) -> list[str]:
    return [f"CRC {of.crc:08x}", *formatted(map_rows(of), "csv")]


@pytest.mark.parametrize("profile", KINDS_OF_BOARD)
def test_the_numbers_stay(profile: str) -> None:
    golden = (GOLDEN / f"{profile}.csv").read_text().splitlines()
    assert lines_of(register_map(info_of(profile))) == golden


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
    assert info.verbs.keys() - names - noted == {"pin"}  # its pins are


if __name__ == "__main__":
    GOLDEN.mkdir(exist_ok=True)
    for kind in KINDS_OF_BOARD:
        text = "\n".join(lines_of(register_map(info_of(kind))))
        (GOLDEN / f"{kind}.csv").write_text(text + "\n")
