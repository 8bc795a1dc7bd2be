"""Nodes of makers' data sheets in a configuration: what is wrong with lines and files, and their benches."""

from pathlib import Path

import pytest

from bridges.can.can_model import CanConfig
from hil.compose import find_catalogue
from hil.compose.simulated_config import as_simulated
from hil.config import ConfigError, diff, from_dict, parse
from hil.config.schema import schema
from hil.testing import Bench

CATALOGUE = find_catalogue()
EXAMPLES = Path(__file__).parents[3] / "examples" / "drives"
SD11 = (EXAMPLES / "sd11.eds").read_text()
HEAD = "bench: t\ndevices: {x: {profile: canopen_drive}}\ncan:\n  c:\n    nodes:\n      x:\n        id: 5\n"
LINES = HEAD.count("\n")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "sd11.eds").write_text(SD11)
    return tmp_path


def said(folder: Path, keys: str, head: str = HEAD) -> list[str]:
    indented = "".join(f"        {line}\n" for line in keys.splitlines())
    with pytest.raises(ConfigError) as caught:
        parse(head + indented, str(folder / "b.yaml"), CATALOGUE)
    return [
        f"{Path(each.file).name}:{each.line - LINES}:{each.column}: {each.message} ({each.remedy})"
        for each in caught.value.problems
    ]


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("  6082h: 1", '3:11: can.c.nodes.x.objects.6082h: the data sheet has no 6082h (did you mean "'),
        ("  607Dh: 5", "3:11: can.c.nodes.x.objects.607Dh: 607Dh has the sub-indices 1 to 2 (write 607Dh:1)"),
        ("  607Dh:3: 5", "607Dh has the sub-indices 1 to 2 (write 607Dh:1)"),
        (
            "  607Dh:1: 2147483647\n  607Dh:2: 5",
            "the software limits 607Dh are reversed: 2147483647 is above",
        ),
        ("  6064h: 5", "6064h tells what the axis does, and has no first value (leave it out)"),
        (
            "  2001h: 100",
            "3:18: can.c.nodes.x.objects.2001h: 2001h is 200 to 51200 in whole numbers, not 100",
        ),
        ("  2001h: 200.5", "2001h is 200 to 51200 in whole numbers, not 200.5"),
        ("  2001h: fast", '2001h is UNSIGNED32, and "fast" is no number'),
        ("  6502h: 0x2", "6502h is 0x2: it has no mode of operation that hil's drives have"),
        ("  2010h: {field: curent_A}", 'the axis has no field "curent_A" (did you mean "current_A"?)'),
        ("  2010h: {field: current_A, scale: 0}", "objects.2010h.scale: with a scale of 0 it is always 0"),
        ("  2011h: {like: 60F7h}", 'like: "60F7h" is no object that this one could be (write one of CiA 402'),
        ("  2011h: {}", "2011h: an object tells either a field of the axis or what another object has"),
        ("  1017h: {field: position_deg}", "1017h cannot tell what an axis does (leave it out)"),
        ("  1601h:2: 0x60640020", "1601h:2': it receives 6064h:0, which is ro (map what can be written)"),
        ("  1A02h:0: 3\n  1A02h:3: 0x60600010", "1A02h:3': it maps 16 bits of 6060h:0, which has 8"),
        ("  speed: 5", '"speed" is no object (write its index and sub-index, as in 6081h or 607Dh:1)'),
        ("  2011h: {likes: 6064h}", 'objects.2011h.likes: unknown key (did you mean "like"?)'),
    ],
)
def test_a_line_that_cannot_be_is_said_where_it_stands(folder: Path, line: str, told: str) -> None:
    found = said(folder, f"eds: sd11.eds\nobjects:\n{line}")
    assert any(told in each for each in found), found


def test_all_that_is_wrong_is_said_at_once(folder: Path) -> None:
    keys = "eds: sd11.eds\nunits: {position_per_turn: 1000}\nobjects: {6082h: 1, 6064h: 5}"
    assert len(said(folder, keys)) == 3
    assert "the units contradict: the file has 4096 units a turn, and this is 1000" in said(folder, keys)[0]


def test_what_a_turn_is_has_to_be_said(folder: Path) -> None:
    (folder / "sd11.eds").write_text(SD11.replace("DefaultValue=4096\nPDOMapping", "PDOMapping"))
    (found,) = said(folder, "eds: sd11.eds")
    assert "the file does not say how many units a turn has (6092h, 608Fh, 60A8h) (add units: {" in found


def test_lines_without_a_data_sheet_are_of_no_use(folder: Path) -> None:
    found = said(folder, "units: {position_per_turn: 5}\nobjects: {6081h: 5}")
    assert [each.split(": ")[1] for each in found] == ["can.c.nodes.x.units", "can.c.nodes.x.objects"]


def test_problems_of_the_file_have_its_lines(folder: Path) -> None:
    (folder / "sd11.eds").write_text(SD11.replace("0x607A0020", "0x607B0020"))
    with pytest.raises(ConfigError) as caught:
        parse(HEAD + "        eds: sd11.eds\n", str(folder / "b.yaml"), CATALOGUE)
    of_bench, of_file = caught.value.problems
    assert of_bench.message == "can.c.nodes.x.eds: the data sheet sd11.eds cannot be used"
    assert Path(of_file.file) == folder / "sd11.eds"
    row = SD11.replace("0x607A0020", "0x607B0020").splitlines()[of_file.line - 1]
    assert row[of_file.column - 1 :] == "0x607B0020"


@pytest.mark.parametrize(
    ("eds", "told"),
    [
        ("nowhere.eds", "nowhere.eds cannot be read: No such file or directory (write where it is,"),
        ("5", "a file's path is wanted here, not the number 5 (write the path, as in maker.eds)"),
    ],
)
def test_a_file_that_is_not_there(folder: Path, eds: str, told: str) -> None:
    (found,) = said(folder, f"eds: {eds}")
    assert told in found


def test_a_drive_without_a_controlword_is_none(folder: Path) -> None:
    text = (
        SD11.replace("[6040]", "[2040]").replace("0x6040\n", "0x2040\n").replace("0x60400010", "0x20400010")
    )
    (folder / "sd11.eds").write_text(text)
    (found,) = said(folder, "eds: sd11.eds")
    assert (
        "it has no 6040h, Controlword, which a drive of CiA 402 has (add it to the file, or a line" in found
    )
    keys = "eds: sd11.eds\nobjects: {2040h: {like: 6040h}}"
    indented = "".join(f"        {line}\n" for line in keys.splitlines())
    parse(HEAD + indented, str(folder / "b.yaml"), CATALOGUE)


def test_an_object_of_the_drive_is_a_number(folder: Path) -> None:
    head = "[6081]\nParameterName=Profile velocity\nObjectType=0x7\nDataType=0x000"
    text = SD11.replace(f"{head}7", f"{head}9").replace("0x60810020", "0").replace("DefaultValue=2\n", "", 1)
    (folder / "sd11.eds").write_text(text.replace("0x607A0020", "0x607A0020", 1))
    found = said(folder, "eds: sd11.eds")
    assert any(
        "6081h is VISIBLE_STRING, and UNSIGNED32 in the standard (correct its" in each for each in found
    )


def test_a_bus_has_a_bit_rate_that_the_drive_knows(folder: Path) -> None:
    head = HEAD.replace("  c:\n", "  c:\n    bit_rate: 800000\n")
    (found,) = said(folder, "eds: sd11.eds", head)
    assert (
        "can.c.bit_rate: the drive of x does not know 800000 bit/s (sd11.eds) (write one of 125000" in found
    )


def test_the_log_has_the_file_and_a_replay_needs_none(folder: Path) -> None:
    config = parse(HEAD + "        eds: sd11.eds\n", str(folder / "b.yaml"), CATALOGUE)
    (folder / "sd11.eds").unlink()
    again = from_dict(as_simulated(config), CATALOGUE)
    bus = again.wires_of("can")["c"]
    assert isinstance(bus, CanConfig)
    eds = bus.nodes["x"].eds
    assert eds is not None
    assert (eds.name, eds.text) == ("sd11.eds", SD11)


def test_another_text_is_a_change_that_is_told_in_short(folder: Path) -> None:
    text = HEAD + "        eds: sd11.eds\n"
    before = parse(text, str(folder / "b.yaml"), CATALOGUE)
    (folder / "sd11.eds").write_text(SD11.replace("DefaultValue=35", "DefaultValue=37"))
    (change, *_) = diff(before, parse(text, str(folder / "b.yaml"), CATALOGUE))
    assert change.device is None
    assert len("".join(change.why)) < 400


def test_the_schema_takes_a_path() -> None:
    assert '"eds"' in str(schema(CATALOGUE)).replace("'", '"')


def test_the_example_moves_the_axis_of_the_bench(bench) -> None:  # type: ignore[no-untyped-def]
    made: Bench = bench(EXAMPLES / "sd11.yaml")
    (drive,) = made.can().drives()
    drive.await_ready()
    drive.nmt("operational")
    drive.write(0x6060, 0, 1, 1)
    assert drive.enable() & 0x6F == 0x27
    drive.write(0x607A, 0, 2048, 4)
    drive.controlword(0x1F)
    made.run(ms=3000)
    assert drive.statusword & 0x400
    assert made.axis("x").snapshot().position_deg == pytest.approx(180.0, abs=0.5)
    assert drive.read(0x6064, is_signed=True) == pytest.approx(2048, abs=6)
    assert drive.read(0x2011, is_signed=True) == drive.read(0x6064, is_signed=True)
    assert abs(drive.read(0x2010, is_signed=True)) < 2000
