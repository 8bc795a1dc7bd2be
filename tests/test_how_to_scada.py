"""Numbers and commands of ``docs/how-to/scada.md``."""

import re
import tomllib

import pytest
from markdown_blocks import ROOT, block

from bridges.modbus.protocol.pdu import Table
from bridges.modbus.registers.register_map import RegisterMap, register_map
from hil.compose.find import find_catalogue
from hil.core.kinds import KINDS
from hil.sim.twin_info import twin_info

PAGE = "docs/how-to/scada.md"
TEXT = (ROOT / PAGE).read_text()
TABLES = {
    "input register": Table.INPUT_REGISTERS,
    "holding register": Table.HOLDING_REGISTERS,
    "coil": Table.COILS,
    "discrete input": Table.DISCRETE_INPUTS,
}
DIGITS = {"input register": 3, "holding register": 4, "coil": 0, "discrete input": 1}


def map_of(profile: str) -> RegisterMap:
    catalogue = find_catalogue()
    law = catalogue.profiles[profile].law
    assert law
    return register_map(twin_info(profile, profile, catalogue.boards[profile], KINDS[law]))


def test_the_three_ways_to_show_an_address_are_of_one_number() -> None:
    rows = re.findall(r"^\| (.*?) \| (.*?) (\d+) \| (\d+) \| (\d{5}) or (\d{6}) \|$", TEXT, re.M)
    assert len(rows) == 4
    for what, table, number, from_one, five, six in rows:
        cell = map_of("mechaduino").at[TABLES[table], int(number)]
        assert cell.name.rpartition(".")[2] in what
        assert int(from_one) == int(number) + 1
        assert (five, six) == (f"{DIGITS[table]}{from_one:0>4}", f"{DIGITS[table]}{from_one:0>5}")


@pytest.mark.parametrize("profile", ["mechaduino", "sac"])
def test_poll_groups_have_no_gap(profile: str) -> None:
    groups = re.findall(r"^\| (.*?)s (\d+) to (\d+) \|", TEXT, re.M)
    assert len(groups) == 2
    of = map_of(profile)
    for table, first, last in groups:
        for number in range(int(first), int(last) + 1):
            assert of.cell(TABLES[table], number)


def test_telegraf_reads_what_the_map_has() -> None:
    (request,) = tomllib.loads(block(PAGE, "Telegraf"))["inputs"]["modbus"][0]["request"]
    for field in request["fields"]:
        cell = map_of("mechaduino").at[Table.INPUT_REGISTERS, field["address"]]
        assert cell.address == field["address"]
        assert cell.type.upper() == field["type"].replace("INT", "I")
        assert field["name"].rpartition("_")[0] in ("position", "current") or cell.name == "velocity"


def test_openhab_writes_what_the_map_has() -> None:
    starts = [int(number) for number in re.findall(r'writeStart="(\d+)"', block(PAGE, "openHAB"))]
    of = map_of("mechaduino")
    assert of.at[Table.HOLDING_REGISTERS, starts[0]].name == "move_abs.position_deg"
    assert of.at[Table.COILS, starts[1]].name == "move_abs"
