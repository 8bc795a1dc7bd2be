"""Makers' files as entries of a node: odd forms that are read, and mistakes with their places."""

import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridges.can.canopen.node import eds_reader
from bridges.can.canopen.node.application import Access, DataType, Entry
from bridges.can.canopen.node.eds_reader import read_device
from hil.vocab.problem import ConfigError

SD11 = (Path(__file__).parents[5] / "examples" / "drives" / "sd11.eds").read_text()
HEAD = """[1000]
ParameterName=Device type
DataType=7
AccessType=ro
[1001]
ParameterName=Error register
DataType=5
AccessType=ro
[1018]
ParameterName=Identity
ObjectType=9
[1018sub0]
ParameterName=Count
DataType=5
AccessType=const
DefaultValue=4
[1018sub1]
ParameterName=Vendor-ID
DataType=7
AccessType=ro
"""


def entry(fields: str, index: str = "2000") -> Entry:
    text = f"{HEAD}[{index}]\nParameterName=It\nAccessType=rw\n{fields}\n"
    return read_device(text, "x.eds").entries[int(index, 16), 0]


def problems(text: str) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        read_device(text, "x.eds")
    return [str(each) for each in caught.value.problems]


@pytest.mark.parametrize(
    ("fields", "default"),
    [
        ("DataType=0x0005\nDefaultValue=012", 10),
        ("DataType=0005\nDefaultValue=0xA ; a remark", 10),
        ("DataType=0x0007 # of 32 bits\nDefaultValue=0.0", 0),
        ("datatype=4\nDEFAULTVALUE=0xFFFFFFFE", -2),
        ("DataType=0x10\nDefaultValue=0xFFFFFE", -2),
        ("DataType=0x15\nDefaultValue=-5", -5),
        ("DataType=8\nDefaultValue=25.5", 25.5),
        ("DataType=8\nDefaultValue=0x41C80000", 25.0),
        ("DataType=9\nDefaultValue=a text; all of it", b"a text; all of it"),
        ("DataType=0x0A\nDefaultValue=01 02 ff", b"\x01\x02\xff"),
        ("DataType=0x0F\nDefaultValue=dump.bin", b""),
        ("DataType=7\nDefaultValue=", 0),
        ("DataType=7", 0),
        ("DataType=7\nDefaultValue=5\nParameterValue=6", 6),
        ("DataType=0x0C", 0),
        ("ObjectType=2", b""),
        ("DataType=7\nDefaultValue=-1", 2**32 - 1),
        ("DataType=7\nDefaultValue=N/A", 0),
        ("DataType=1\nDefaultValue=TRUE", 1),
    ],
)
def test_first_values_in_all_forms(fields: str, default: object) -> None:
    assert entry(fields).default == default


def test_the_nodes_id_stands_before_or_behind() -> None:
    for text in ("$NODEID+0x180", "0x180+$NODEID", "0x80000180 + $nodeid"):
        found = entry(f"DataType=7\nDefaultValue={text}")
        assert found.adds_node_id
        assert isinstance(found.default, int)
        assert found.default & 0x7FF == 0x180
    assert not entry("DataType=7\nDefaultValue=0x180").adds_node_id


def test_access_and_limits() -> None:
    for text, access, mapping in (
        ("ro", Access.RO, "tpdo"),
        ("RWW", Access.RW, "rpdo"),
        ("rwr", Access.RW, "tpdo"),
        ("wo", Access.WO, "rpdo"),
        ("Const", Access.CONST, "tpdo"),
    ):
        found = entry(f"AccessType={text}\nDataType=6\nPDOMapping=1")
        assert (found.access, found.mapping) == (access, mapping)
    found = entry("DataType=3\nLowLimit=0x8000\nHighLimit=100")
    assert (found.low, found.high) == (-32768, 100)
    assert entry("DataType=3\nLowLimit=\nHighLimit=").low is None
    assert entry("DataType=3\nHighLimit=0xFFFFFFFF").high is None, "no value of the type reaches it"


def test_compact_objects_have_the_names_of_their_list() -> None:
    found = read_device(SD11, "x.eds")
    rows = [found.entries[0x2000, sub] for sub in range(4)]
    assert [row.name for row in rows[1:]] == ["Running", "Standing", "Accelerating"]
    assert (rows[0].default, rows[2].default, rows[2].high) == (3, 1000, 4200)
    assert found.names[0x2000] == "Phase current"
    assert found.names[0x2001] == ""


def test_line_ends_of_all_kinds_and_places_are_the_same() -> None:
    text = f"{HEAD}[2000]\nParameterName=It\nDataType=99\n"
    told = "x.eds:23:10: 2000h:0 has the type 99, which no node can have (write its DataType, as in"
    for end in ("\n", "\r\n", "\r"):
        (found,) = problems(text.replace("\n", end))
        assert found.startswith(told)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("[6083]", "[6082]", "149:4: 6083h is listed, and has no section (add [6083], or take it"),
        ("DataType=0x0006\nAccessType=rww", "AccessType=rww", "an object without a type, which no"),
        ("AccessType=rww", "AccessType=rwx", "6040h:0 has the access 'rwx', which there is not (write ro,"),
        ("0x607A0020", "0x607B0020", ": it maps 607Bh:0, which is not in the file (add 607Bh:0, or map"),
        ("0x60600008", "0x60600010", ": it maps 16 bits of 6060h:0, which has 8 (write 0x60600008)"),
        ("0x60810020", "0x60640020", ": it receives 6064h:0, which is ro (map what can be written)"),
        ("LowLimit=200", "LowLimit=60000", "2001h:0 has a LowLimit of 60000, above its HighLimit of 51200"),
        ("DefaultValue=0x80\n", "DefaultValue=0xl0\n", "1005h:0 is UNSIGNED32, and '0xl0' is no number"),
        ("DefaultValue=35", "DefaultValue=350", "6098h:0 is INTEGER8, which cannot be 350 (write -128 to"),
        ("HighLimit=51200", "HighLimit=much", "2001h:0 has 'much' as a limit, which is no number"),
        ("[1001]", "[1fff]", "1001h, Error register, is missing, which each node has (add its section"),
    ],
)
def test_a_mistake_is_told_with_its_place(old: str, new: str, told: str) -> None:
    assert old in SD11
    found = problems(SD11.replace(old, new, 1))
    assert any(told in each for each in found), found


def test_all_mistakes_are_told_at_once_in_their_order() -> None:
    text = SD11.replace("DefaultValue=35", "DefaultValue=350").replace("LowLimit=200", "LowLimit=x", 1)
    lines = [int(each.split(":")[1]) for each in problems(text)]
    assert len(lines) == 2
    assert lines == sorted(lines)


@given(st.text(alphabet="[]=;#\n 0123456789abcdefsubDTPx$NODEI+-", max_size=300))
def test_any_text_is_a_device_or_problems(text: str) -> None:
    found = []
    try:
        read_device(HEAD + text, "x.eds")
    except ConfigError as error:
        found = error.problems
    assert all(each.line >= 1 and each.column >= 1 and each.remedy for each in found)


def test_a_file_of_2000_objects_is_read_in_little_time() -> None:
    rows = "".join(
        f"[{0x2000 + at:04X}]\nParameterName=Object {at}\nObjectType=0x7\nDataType=0x0007\nAccessType=rw\n"
        f"DefaultValue={at}\nLowLimit=0\nHighLimit=0xFFFF\nPDOMapping=0\n\n"
        for at in range(2000)
    )
    took_s = []
    for at in range(5):
        began = time.thread_time()
        device = read_device(f"{HEAD}{rows};{at}\n", "x.eds")
        took_s.append(time.thread_time() - began)
    assert len(device.entries) == 2004
    assert min(took_s) < 0.2, "a tenth of that on a computer with nothing else to do"
    assert eds_reader.read_device(f"{HEAD}{rows};4\n", "y.eds") is device, "the same text is read once"


def test_a_file_of_endless_objects_is_refused() -> None:
    rows = "".join(f"[{0x2000 + at:04X}]\nDataType=7\nCompactSubObj=254\n" for at in range(1000))
    (found,) = problems(HEAD + rows)
    assert "there are more than 30000 objects and sub-indices (leave those out" in found


def test_types_that_no_processor_has_are_numbers() -> None:
    assert entry("DataType=0x18\nDefaultValue=0xFFFFFFFFFF").data_type is DataType.UNSIGNED40


@pytest.mark.parametrize("text", ["", "hello\n", "; a note\n", "a=1\n"])
def test_a_file_without_a_section_is_no_data_sheet(text: str) -> None:
    with pytest.raises(ConfigError) as raised:
        read_device(text, "bad.eds")
    (found,) = raised.value.problems
    assert found.message == "this is no data sheet (EDS): it has no [section]"
    assert (found.file, found.line) == ("bad.eds", 1)
