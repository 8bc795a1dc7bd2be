"""Drives of makers' files: their objects, limits, modes and PDOs, under the ``canopen`` library."""

from dataclasses import replace
from pathlib import Path

import canopen
import pytest
from canopen.profiles.p402 import BaseNode402
from drive_rig import SimpleAxis
from maker_rig import NODE, MakerWorld, differences, enable, move_to, refusals, said_by_dcfchk

from bridges.can.canopen.cia402.maker_drive import FieldLine, LikeLine, MakerLines
from bridges.can.canopen.master.drive_units import NO_UNITS, GivenUnits
from bridges.can.canopen.node.eds_reader import read_device

TEXT = (Path(__file__).parents[5] / "examples" / "drives" / "sd11.eds").read_text()
LINES = MakerLines(
    GivenUnits(velocity_per_rpm=4096 / 60),
    {(0x6081, 0): 8192},
    {(0x2010, 0): FieldLine("current_A", 1000.0), (0x2011, 0): LikeLine((0x6064, 0), 1.0)},
)


def made(text: str = TEXT, lines: MakerLines = LINES) -> tuple[MakerWorld, BaseNode402]:
    world = MakerWorld(text, lines)
    return world, world.master()


def abort_of(call: object, *given: object) -> int:
    with pytest.raises(canopen.SdoAbortedError) as caught:
        call(*given)  # type: ignore[operator]
    code: int = caught.value.code
    return code


def test_the_dictionary_is_the_files() -> None:
    world, master = made()
    assert differences(world, master) == []
    assert refusals(world, master) == []
    for index in (0x1003, 0x1016, 0x1402, 0x6071, 0x60FF, 0x2003):
        assert abort_of(master.sdo.upload, index, 0) == 0x0602_0000, "the file has no such object"
    assert abort_of(master.sdo.upload, 0x607D, 3) == 0x0609_0011


def test_identity_and_names_are_the_makers() -> None:
    _, master = made()
    assert master.sdo[0x1008].raw == "SD-11 stepper drive"
    assert [master.sdo[0x1018][sub].raw for sub in (1, 2, 3, 4)] == [0, 0x1101, 0x10002, 77]
    assert master.sdo[0x1014].raw == 0x80 + NODE


def test_its_heartbeat_runs_and_its_pdos_are_as_shipped() -> None:
    world, master = made()
    world.run(2500)
    assert [frame.data for frame in world.heard if frame.id == 0x700 + NODE] == [b"\x00", b"\x7f", b"\x7f"]
    master.rpdo.read()
    master.tpdo.read()
    assert sorted(master.rpdo.map) == [1, 2]
    assert sorted(master.tpdo.map) == [1, 2, 3]
    assert [variable.index for variable in master.tpdo[2]] == [0x6064, 0x606C]
    assert (master.tpdo[1].trans_type, master.tpdo[1].inhibit_time) == (255, 100)
    assert (master.tpdo[3].enabled, master.tpdo[3].event_timer) == (False, 200)


def test_a_mapping_that_is_read_only_stays_and_another_can_be_changed() -> None:
    world, master = made()
    master.tpdo.read()
    assert abort_of(master.sdo.download, 0x1A00, 0, b"\x00") == 0x0601_0002
    tpdo = master.tpdo[2]
    tpdo.clear()
    tpdo.add_variable(0x6064)
    tpdo.trans_type, tpdo.enabled = 1, True
    tpdo.save()
    master.nmt.state = "OPERATIONAL"
    world.heard.clear()
    world.send_message(0x80, b"")
    (sent,) = [frame for frame in world.heard if frame.id == 0x280 + NODE]
    assert len(sent.data) == 4
    assert abort_of(master.sdo.download, 0x1A01, 0, b"\x02") == 0x0800_0022, "it exists"


def test_modes_are_those_of_the_file() -> None:
    _, master = made()
    assert master.sdo[0x6502].raw == 0x21
    for mode in (3, 4, 8, 7, 2):
        assert abort_of(master.sdo.download, 0x6060, 0, bytes((mode,))) == 0x0609_0030
    master.sdo[0x6060].raw = 6


def test_a_profile_move_ends_at_its_target_in_the_files_units() -> None:
    world, master = made()
    enable(world, master, 1)
    assert move_to(world, master, 2048) == 2048
    assert world.axis.look().position_deg == pytest.approx(180.0)
    assert master.sdo[0x2011].raw == 2048, "the maker's own name of the position"


def test_homing_by_the_library() -> None:
    _, master = made()
    master.nmt.state = "OPERATIONAL"
    assert master.homing(timeout=10)
    assert master.sdo[0x6064].raw == 0


def test_lines_give_first_values_and_bind_objects() -> None:
    world, master = made()
    assert master.sdo[0x6081].raw == 8192
    world.axis.current_A = -1.234
    assert master.sdo[0x2010].raw == -1234
    world.axis.current_A = 1e9
    assert master.sdo[0x2010].raw == 32767, "the nearest that the type has"
    master.sdo[0x2001].raw = 12_800
    assert master.sdo[0x2001].raw == 12_800, "a plain cell"


def test_an_object_of_the_wrong_sign_has_the_right_one() -> None:
    head = "[607A]\nParameterName=Target position\nObjectType=0x7\nDataType=0x0004"
    assert head in TEXT
    world, master = made(TEXT.replace(head, head.replace("0x0004", "0x0007")))
    enable(world, master, 1)
    assert move_to(world, master, -1024 & 0xFFFF_FFFF) == -1024


def test_lines_change_pdos_too() -> None:
    values = {(0x1802, 1): 0x123, (0x1802, 2): 1, (0x1A02, 0): 1, (0x1A02, 1): 0x6502_0020}
    world, master = made(TEXT, replace(LINES, values=values))
    assert master.sdo[0x1802][1].raw == 0x123
    master.nmt.state = "OPERATIONAL"
    world.heard.clear()
    world.send_message(0x80, b"")
    assert [frame.data for frame in world.heard if frame.id == 0x123] == [b"\x21\0\0\0"]


def test_what_1010h_keeps_is_there_after_a_reset() -> None:
    world, master = made()
    master.sdo[0x2001].raw = 12_800
    master.sdo[0x6081].raw = 5
    master.sdo[0x607A].raw = 77
    master.sdo.download(0x1010, 1, b"save")
    master.nmt.state = "RESET"
    world.run(50)
    assert (master.sdo[0x2001].raw, master.sdo[0x6081].raw, master.sdo[0x607A].raw) == (12_800, 5, 0)
    master.sdo.download(0x1011, 1, b"load")
    master.nmt.state = "RESET"
    world.run(50)
    assert (master.sdo[0x2001].raw, master.sdo[0x6081].raw) == (4096, 8192)


def test_an_object_can_command_by_another_name() -> None:
    text = TEXT.replace("[2011]", "[2012]\nParameterName=Go\nDataType=4\nAccessType=rw\n\n[2011]")
    lines = replace(LINES, bound={(0x2012, 0): LikeLine((0x607A, 0), 10.0)})
    _, master = made(text, lines)
    master.sdo[0x2012].raw = 20_480
    assert (master.sdo[0x607A].raw, master.sdo[0x2012].raw) == (2048, 20_480)


def test_interpolated_position_follows_its_record_with_each_sync() -> None:
    text = TEXT.replace("DefaultValue=0x00000021", "DefaultValue=0x00000061").replace(
        "[6098]",
        "[60C1]\nParameterName=Data\nObjectType=9\nSubNumber=2\n[60C1sub0]\nParameterName=n\nDataType=5\n"
        "AccessType=ro\nDefaultValue=1\n[60C1sub1]\nParameterName=Position\nDataType=4\nAccessType=rw\n\n[6098]",
    )
    world, master = made(text)
    enable(world, master, 7)
    master.sdo[0x60C1][1].raw = 1024
    world.send_message(0x80, b"")
    world.run(20)
    assert world.axis.look().position_deg == pytest.approx(0.0), "bit 4 is not set"
    master.sdo[0x6040].raw = 0x1F
    for step in range(1, 11):
        master.sdo[0x60C1][1].raw = step * 10
        world.send_message(0x80, b"")
    world.run(10)
    assert world.axis.look().position_deg * 4096 / 360 == pytest.approx(100.0, abs=12)


def test_a_drive_may_begin_without_a_mode_and_with_values_of_nothing() -> None:
    """Files of makers have 0 where a drive has a value of its own."""
    text = TEXT
    for index in (0x6060, 0x6081, 0x6083, 0x6084, 0x6085, 0x609A):
        head = f"[{index:04X}]"
        at = text.index(head)
        end = text.index("\n[", at)
        section = "\n".join(
            "DefaultValue=0" if row.startswith("DefaultValue") else row
            for row in text[at:end].split("\n")
            if not row.startswith("LowLimit")
        )
        text = text[:at] + section + text[end:]
    world, master = made(text, MakerLines(NO_UNITS))
    assert (master.sdo[0x6060].raw, master.sdo[0x6061].raw) == (0, 0)
    master.nmt.state = "OPERATIONAL"
    for word in (0x06, 0x07, 0x0F):
        master.sdo[0x6040].raw = word
        world.run(20)
    assert master.sdo[0x6041].raw & 0x6F == 0x27
    master.sdo[0x6060].raw = 1
    master.sdo[0x607A].raw = 1000
    master.sdo[0x6040].raw = 0x1F
    world.run(100)
    master.sdo[0x6040].raw = 0x0B
    world.run(100)
    assert master.sdo[0x6041].raw & 0x08 == 0, "no fault"


def test_clients_see_what_is_in_the_file_and_nothing_else() -> None:
    world, _ = made()
    seen = {(each.index, each.subindex) for each in world.node.dictionary.entries.values()}
    assert seen == set(read_device(TEXT, "x").entries)


def test_what_it_exports_is_what_masters_and_their_tools_take(tmp_path: Path) -> None:
    world, _ = made()
    text = world.exported()
    assert said_by_dcfchk(text, tmp_path) == ""
    assert said_by_dcfchk(TEXT, tmp_path) == "", "the example, too"
    assert differences(world, world.master(text)) == []
    assert (read_device(text, "x").info.has_lss, read_device(text, "x").info.bit_rates[0]) == (False, 125_000)


def test_lss_is_there_if_the_file_says_so() -> None:
    inquire = bytes((0x04, 1)) + bytes(6), bytes((0x5E,)) + bytes(7)
    for number in (0, 1):
        world, _ = made(TEXT.replace("LSS_Supported=0", f"LSS_Supported={number}"))
        world.heard.clear()
        for data in inquire:
            world.send_message(0x7E5, data)
        assert len([frame for frame in world.heard if frame.id == 0x7E4]) == number


def test_a_stepper_board_has_the_modes_that_it_and_the_file_have() -> None:
    axis = SimpleAxis(verbs=("stop", "velocity", "move_abs"), follows_paths=False, index_deg=None)
    text = TEXT.replace("DefaultValue=0x00000021", "DefaultValue=0x000003ED")
    world = MakerWorld(text, LINES, axis)
    master = world.master()
    for mode, is_there in ((1, True), (3, True), (6, True), (4, False), (8, False), (7, False)):
        if is_there:
            master.sdo[0x6060].raw = mode
        else:
            assert abort_of(master.sdo.download, 0x6060, 0, bytes((mode,))) == 0x0609_0030
