import struct
import zlib
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.firmware.nvm import FORMAT_VERSION, MAGIC, Content, Decoded, NvmError, decode, encode

CONTENT = Content("mechaduino", 7, {"lookup": bytes(range(256)), "": b"", "größe": b"\x00"})
CONTENTS = st.builds(
    Content,
    profile=st.text(max_size=40),
    counter=st.integers(0, 2**64 - 1),
    sections=st.dictionaries(st.text(max_size=20), st.binary(max_size=200), max_size=5),
)


def sealed(version: int, body: bytes) -> bytes:
    """A file with the right checksum, whatever is in it."""
    signed = MAGIC + struct.pack("<H", version)
    return signed + struct.pack("<I", zlib.crc32(signed + body)) + body


@given(CONTENTS)
def test_what_is_written_reads_back(content: Content) -> None:
    assert decode(encode(content)) == Decoded(content)


def test_the_order_of_the_sections_does_not_show() -> None:
    turned = replace(CONTENT, sections=dict(reversed(list(CONTENT.sections.items()))))
    assert encode(turned) == encode(CONTENT)


def test_the_bytes_of_the_current_version_do_not_change() -> None:
    body = b"\x02sm" + struct.pack("<QH", 3, 1) + b"\x01t" + struct.pack("<I", 2) + b"\x80\x81"
    assert encode(Content("sm", 3, {"t": b"\x80\x81"})) == sealed(2, body)


@given(st.binary(max_size=100))
def test_version_1_is_migrated(body: bytes) -> None:
    assert decode(sealed(1, body)) == Decoded(Content("", 0, {"": body}), migrated_from=1)


def refusal(data: bytes) -> str:
    """Reason why the file is refused, or "" if it is read."""
    try:
        decode(data)
    except NvmError as error:
        return str(error)
    return ""


@given(st.binary(max_size=200))
def test_any_bytes_are_read_or_refused(data: bytes) -> None:
    for candidate in (data, MAGIC + data, *(sealed(version, data) for version in range(4))):
        assert "\n" not in refusal(candidate)


@given(CONTENTS, st.data())
def test_a_changed_body_with_a_right_checksum_is_read_or_refused(
    content: Content, data: st.DataObject
) -> None:
    body = bytearray(encode(content)[14:])
    body[data.draw(st.integers(0, len(body) - 1))] = data.draw(st.integers(0, 255))
    reason = refusal(sealed(FORMAT_VERSION, bytes(body)))
    assert reason == "" or reason.startswith("damaged: ")


@pytest.mark.parametrize("whole", [encode(CONTENT), sealed(1, b"settings")])
def test_every_flipped_bit_is_found(whole: bytes) -> None:
    for bit in range(8 * len(whole)):
        flipped = bytearray(whole)
        flipped[bit // 8] ^= 1 << bit % 8
        with pytest.raises(NvmError):
            decode(bytes(flipped))


@pytest.mark.parametrize("whole", [encode(CONTENT), sealed(1, b"settings")])
def test_every_shortened_or_lengthened_file_is_found(whole: bytes) -> None:
    for wrong in (*(whole[:size] for size in range(len(whole))), whole + b"\x00"):
        with pytest.raises(NvmError):
            decode(wrong)


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "not a memory file"),
        (b"[m1]\nport = pty\n", "not a memory file"),
        (MAGIC, "too short"),
        (sealed(FORMAT_VERSION, b"")[:-1] + b"\x00", "checksum"),
        (sealed(FORMAT_VERSION + 1, b"anything"), "format version 3 is unknown: this program reads 1 to 2"),
        (sealed(0, b""), "format version 0 is unknown"),
        (sealed(2, b"\x01s" + struct.pack("<QH", 0, 2) + 2 * b"\x01t\x00\x00\x00\x00"), "same name"),
        (sealed(2, b"\x01\xff" + struct.pack("<QH", 0, 0)), "UTF-8"),
        (sealed(2, b"\x01s" + struct.pack("<QH", 0, 0) + b"\x00"), "after the last section"),
        (sealed(2, b"\x01s" + struct.pack("<QH", 0, 1) + b"\x01t\x05\x00\x00\x00abcd"), "too early"),
    ],
)
def test_the_reason_is_named(data: bytes, reason: str) -> None:
    with pytest.raises(NvmError, match=reason):
        decode(data)


@pytest.mark.parametrize(
    "content",
    [
        replace(CONTENT, profile="x" * 256),
        replace(CONTENT, counter=2**64),
        replace(CONTENT, counter=-1),
        replace(CONTENT, sections={"ü" * 128: b""}),
        replace(CONTENT, sections={str(n): b"" for n in range(65_536)}),
    ],
)
def test_what_does_not_fit_is_refused(content: Content) -> None:
    with pytest.raises(ValueError, match="cannot be stored"):
        encode(content)
