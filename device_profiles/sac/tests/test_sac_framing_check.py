"""Shipped check of codecs, passed by the framing of the SAC's network."""

from device_profiles.sac.framing import FRAMING
from device_profiles.sac.packet import encode
from hil.testing import check_codec, framing_reader

MESSAGES = [(4, 5, b"hello", True), (0, 1, b"y", True), (255, 4, b"vd", False), (9, 9, b"", True)]


def test_it_keeps_to_what_codecs_keep_to() -> None:
    reader = framing_reader(FRAMING, 38400)
    messages = {}
    for destination, origin, data, has_crc in MESSAGES:
        raw = encode(destination, origin, data, crc=has_crc)
        messages[raw] = [(FRAMING.text(item), True, "", origin) for item in FRAMING.splitter().feed(raw)]
        assert len(messages[raw]) == 1
    check_codec(reader, messages, character_ns=260_416)
