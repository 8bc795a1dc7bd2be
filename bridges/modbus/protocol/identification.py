"""Identification of a device: Read Device Identification, function 43/14 (6.21).

Its objects are texts under numbers, in three categories that build on each other: basic (0 to 2), regular (3
to 6), extended (128 to 255). A client asks for a category, which comes in as many answers as it needs, or for
a single object.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property
from typing import NamedTuple

from bridges.modbus.protocol.pdu import DEVICE_IDENTIFICATION, PDU_BYTES_MAX, Code, Function, Refused, Request

_HEAD_BYTES, _OBJECT_HEAD_BYTES = 7, 2
OBJECT_BYTES_MAX = PDU_BYTES_MAX - _HEAD_BYTES - _OBJECT_HEAD_BYTES
"""Size of an object that fits into an answer."""
EXTENDED_IDS = range(0x80, 0x100)
_INDIVIDUAL_TOO = 0x80
_MORE_FOLLOWS = 0xFF


class ReadDeviceId(IntEnum):
    """Read device ID codes: a category as a stream of objects, or one object."""

    BASIC = 1
    REGULAR = 2
    EXTENDED = 3
    INDIVIDUAL = 4


_LAST_IDS = {ReadDeviceId.BASIC: 2, ReadDeviceId.REGULAR: 6, ReadDeviceId.EXTENDED: 255}


@dataclass(frozen=True)
class Identification:
    """Objects of a device. The first three are there even if they are empty, the others if they are not.

    Raises:
        ValueError: a text that is not ASCII, an object too long for an answer, or one of a reserved number.
    """

    vendor_name: str
    product_code: str
    revision: str
    vendor_url: str = ""
    product_name: str = ""
    model_name: str = ""
    user_application_name: str = ""
    extended: Mapping[int, bytes] = field(default_factory=dict)
    """Own objects, by their numbers (128 to 255)."""

    def __post_init__(self) -> None:
        for object_id, value in self.objects.items():
            if len(value) > OBJECT_BYTES_MAX:
                raise ValueError(
                    f"object {object_id} has {len(value)} bytes; {OBJECT_BYTES_MAX} fit into an answer"
                )
        if reserved := sorted(set(self.extended).difference(EXTENDED_IDS)):
            raise ValueError(f"own objects are 128 to 255, not {reserved}")

    @cached_property
    def objects(self) -> dict[int, bytes]:
        """All objects by their numbers, in their order."""
        basic = (self.vendor_name, self.product_code, self.revision)
        regular = (self.vendor_url, self.product_name, self.model_name, self.user_application_name)
        texts = [*enumerate(basic), *((number, text) for number, text in enumerate(regular, 3) if text)]
        return {number: text.encode("ascii") for number, text in texts} | dict(sorted(self.extended.items()))

    @property
    def conformity_level(self) -> int:
        """The highest category of which there is an object; single objects may be asked for too."""
        last = max(self.objects)
        return _INDIVIDUAL_TOO | min(code for code, last_id in _LAST_IDS.items() if last <= last_id)


class IdentificationPiece(NamedTuple):
    """An answer of function 43/14."""

    read_device_id_code: int
    conformity_level: int
    next_object_id: int | None
    """Object at which the next piece begins; None: this is the last."""
    objects: dict[int, bytes]


def identify(request: Request, identification: Identification, pdu_bytes_max: int = PDU_BYTES_MAX) -> bytes:
    """Make the answer to a request of function 43/14: from the object asked for on, as many as fit. A stream
    that is to begin at an object which is not there begins at the first.

    Raises:
        Refused: the single object that is asked for is not there (02).
    """
    code, first = request.read_device_id_code, request.object_id
    assert code is not None and first is not None  # noqa: PT018  # parse() gives both or none
    objects = identification.objects
    if code == ReadDeviceId.INDIVIDUAL:
        if first not in objects:
            raise Refused(Code.ILLEGAL_DATA_ADDRESS, f"there is no object {first}")
        wanted = [first]
    else:
        stream = [number for number in objects if number <= _LAST_IDS[ReadDeviceId(code)]]
        wanted = stream[stream.index(first) :] if first in stream else stream
    body, count = b"", 0
    for number in wanted:
        value = objects[number]
        if count and _HEAD_BYTES + len(body) + _OBJECT_HEAD_BYTES + len(value) > pdu_bytes_max:
            break
        body += bytes((number, len(value))) + value
        count += 1
    follows = (_MORE_FOLLOWS, wanted[count]) if count < len(wanted) else (0, 0)
    level = identification.conformity_level
    return bytes((request.function, DEVICE_IDENTIFICATION, code, level, *follows, count)) + body


def parse_identification(pdu: bytes) -> IdentificationPiece:
    """Parse an answer of function 43/14 that is no exception.

    Raises:
        ValueError: it is none.
    """
    function = Function.ENCAPSULATED_INTERFACE_TRANSPORT
    if len(pdu) < _HEAD_BYTES or pdu[:2] != bytes((function, DEVICE_IDENTIFICATION)):
        raise ValueError("no answer of function 43/14")
    code, level, more_follows, next_object_id, count = pdu[2:_HEAD_BYTES]
    objects, at = dict[int, bytes](), _HEAD_BYTES
    for _ in range(count):
        end = at + _OBJECT_HEAD_BYTES + pdu[at + 1] if at + 1 < len(pdu) else len(pdu) + 1
        if end > len(pdu):
            raise ValueError(f"{count} objects are announced; {len(objects)} are there")
        objects[pdu[at]] = pdu[at + _OBJECT_HEAD_BYTES : end]
        at = end
    if at != len(pdu):
        raise ValueError(f"{len(pdu) - at} bytes behind the last object")
    return IdentificationPiece(
        code, level, next_object_id if more_follows == _MORE_FOLLOWS else None, objects
    )
