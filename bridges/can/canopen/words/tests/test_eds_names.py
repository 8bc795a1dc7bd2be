"""EDS and DCF files as tools and devices' makers write them."""

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridges.can.canopen.words.eds_names import EdsError, EdsObjects, read_eds
from bridges.can.canopen.words.object_words import ObjectName, value_words
from hil.wire.outside_text import LeftOut, text_of


def read(text: str, node: int = 5) -> tuple[EdsObjects, str]:
    left_out = LeftOut()
    return read_eds(text, node, left_out), left_out.told()


def value_of(text: str, node: int = 5) -> int:
    objects, said = read(f"[1800sub1]\nParameterName=COB-ID\nDataType=7\nDefaultValue={text}\n", node)
    assert not said
    return int.from_bytes(objects.values[0x1800, 1], "little")


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("0x185", 0x185),
        ("389", 0x185),
        ("012", 10),
        ("08", 8),
        ("$NODEID+0x180", 0x185),
        ("$NodeID + 0x180", 0x185),
        ("0x180+$NODEID", 0x185),
        ("0x180 + $NODEID ; a comment", 0x185),
        ("$NODEID", 5),
        ("0x80000180+$NODEID", 0x80000185),
        ("-1", 0xFFFFFFFF),
    ],
)
def test_numbers(text: str, value: int) -> None:
    assert value_of(text) == value


@pytest.mark.parametrize("line", ["DefaultValue=0.0", "DefaultValue=nonsense", "LowLimit=x", "PDOMapping=?"])
def test_what_is_not_needed_refuses_nothing(line: str) -> None:
    objects, said = read(f"[2000]\nParameterName=Reset\nDataType=0x0007\n{line}\n")
    assert objects.names == {(0x2000, -1): ObjectName("u32", "Reset")}
    assert not said


def test_what_is_needed_and_wrong_is_said_and_ends_nothing() -> None:
    objects, said = read(
        "[1800sub1]\nParameterName=COB-ID\nDataType=7\nDefaultValue=0xZ\nnonsense\n[2000]\nParameterName=x\n[20\n"
    )
    assert set(objects.names) == {(0x1800, 1), (0x2000, -1)}
    assert said == (
        "3 left out: line 5 'nonsense': no section and no entry, as in DataType=0x0007;"
        " line 8 '[20': a section without an end, as in [1000];"
        " line 4 '0xZ': no number, where one is needed for a PDO"
    )


@pytest.mark.parametrize("text", ["", "PNG\0\0", "[FileInfo]\nFileName=x\n", "[2000]\nDataType=5\n"])
def test_a_file_without_objects_is_refused(text: str) -> None:
    with pytest.raises(EdsError, match="there is no object in it"):
        read(text)


def test_comments_ends_of_lines_and_other_sections() -> None:
    lines = ("# DCF", ";x", "[ 2000 ] ; y", "ParameterName = Gain=1 ", "#DataType=5", "DataType=0x6")
    text = "\r\n".join((*lines, "[Tools]", "a.b=c"))
    assert read(text) == (EdsObjects({(0x2000, -1): ObjectName("u16", "Gain=1")}, {}), "")
    assert read(text.replace("\r\n", "\r"))[0].names


def test_a_compact_object_has_sub_indices_with_names_and_values() -> None:
    objects, said = read(
        "[1A00]\nParameterName=Map\nObjectType=8\nDataType=7\nCompactSubObj=3\n[1A00Name]\nNrOfEntries=1\n2=Speed\n"
        "[1A00Value]\nNrOfEntries=2\n1=0x60410010\n2=0x606C0020\n[1A00sub3]\nParameterName=Own\nDataType=5\n"
    )
    assert not said
    assert objects.names == {
        (0x1A00, -1): ObjectName("", "Map"),
        (0x1A00, 0): ObjectName("u8", "Number of entries"),
        (0x1A00, 1): ObjectName("u32", "Map 1"),
        (0x1A00, 2): ObjectName("u32", "Speed"),
        (0x1A00, 3): ObjectName("u8", "Own"),
    }
    assert objects.values == {
        (0x1A00, 0): b"\3",
        (0x1A00, 1): bytes.fromhex("10004160"),
        (0x1A00, 2): bytes.fromhex("20006c60"),
    }


def test_compact_objects_have_a_limit_all_together() -> None:
    each = "[{:04X}]\nParameterName=x\nDataType=7\nCompactSubObj=254\n"
    objects, said = read("".join(map(each.format, range(0x2000, 0x2200))))
    assert 100_000 < len(objects.names) < 101_000
    assert (0x21FF, -1) in objects.names
    assert said.startswith("121 left out: line 1568 and 120 more: sub-indices behind 100000 names"), said


def test_a_dcf_has_the_values_that_were_set() -> None:
    objects, _ = read("[1800sub1]\nParameterName=x\nDataType=7\nDefaultValue=0x181\nParameterValue=0x281\n")
    assert objects.values == {(0x1800, 1): bytes.fromhex("81020000")}


@pytest.mark.parametrize(
    "text",
    [
        "[1800sub1]\nParameterName=x\nDataType=7\nDefaultValue=0x181\nParameterValue=\n",
        "[1800sub1]\nParameterName=x\nDataType=7\nDefaultValue=0x181\nParameterValue= ; as it was\n",
        "[1800]\nParameterName=x\nDataType=7\nDefaultValue=0x181\nCompactSubObj=1\n[1800Value]\n1=\n",
    ],
)
def test_an_empty_value_of_a_dcf_leaves_the_default(text: str) -> None:
    objects, said = read(text)
    assert not said
    assert objects.values[0x1800, 1] == bytes.fromhex("81010000")


@pytest.mark.parametrize(
    ("number", "data", "words"),
    [
        (0x08, "0000c841", "25"),
        (0x08, "cdcccc3d", "0.1"),
        (0x08, "0000c07f", "nan"),
        (0x11, "9a9999999999b93f", "0.1"),
        (0x10, "feffff", "-2"),
        (0x12, "feffffffff", "-2"),
        (0x13, "feffffffffff", "-2"),
        (0x14, "feffffffffffff", "-2"),
        (0x16, "feffff", "16777214"),
        (0x1A, "01000000000000", "1"),
        (0x01, "01", "1"),
        (0x09, "414200", "'AB'"),
        (0x0B, "41004200", "'AB'"),
    ],
)
def test_values_by_the_numbers_of_their_types(number: int, data: str, words: str) -> None:
    objects, _ = read(f"[2010]\nParameterName=x\nDataType=0x{number:04X}\n")
    assert value_words(objects.names[0x2010, -1].type, bytes.fromhex(data)) == words


def test_marks_and_older_encodings_are_read() -> None:
    text = "[2000]\nParameterName=Temperatur in °C\n"
    for encoding in ("utf-8", "utf-8-sig", "latin-1", "utf-16"):
        assert read(text_of(text.encode(encoding)))[0].names[0x2000, -1].name == "Temperatur in °C"


@given(st.binary(max_size=200))
def test_any_content_is_an_eds_or_refused(data: bytes) -> None:
    with suppress(EdsError):
        assert read("[2000]\nParameterName=x\nCompactSubObj=9\n" + text_of(data))[0].names


LINES = (
    *("[1A00]", "[1A00sub1]", "[1A00Name]", "[1A00Value]", "CompactSubObj=0xFFFF", "1=$NODEID+$NODEID"),
    *("2=0x-", "DefaultValue=0x", "DefaultValue=9" + "9" * 90, "DataType=-1", "ObjectType=08"),
    "ParameterName=x",
)


@given(st.lists(st.sampled_from(LINES), max_size=12))
def test_any_lines_are_read(lines: list[str]) -> None:
    with suppress(EdsError):
        _, said = read("\n".join(lines))
        assert said.isprintable()
