"""Role of a client, from its certificate: the text of an extension, or a role of its common name.

Sources: Modbus/TCP Security V21 (2018), R-22 and 8.4: a role in extension 1.3.6.1.4.1.50316.802.1, an ASN.1
UTF8String; RFC 5280, 4.1: the parts of a certificate; X.690: their encoding.
"""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from hil.vocab.verbs import Role

_ROLE = bytes.fromhex("2b0601040183890c862201")
_COMMON_NAME = bytes.fromhex("550403")
_SEQUENCE, _SET, _OID, _OCTETS, _UTF8 = 0x30, 0x31, 0x06, 0x04, 0x0C
_VERSION, _EXTENSIONS = 0xA0, 0xA3
_SUBJECT = 4
"""Place of the subject: behind serial number, algorithm, issuer and validity."""
_LENGTH_BYTES = 4


class CertifiedClient(NamedTuple):
    """Client as its certificate names it. ``role``: what the extension says, empty without one."""

    name: str
    role: str


class NoRole(Exception):
    """Error of a client without a role: ``str(error)`` says why."""


def role_of(certificate: bytes, roles: Mapping[str, str]) -> tuple[str, Role]:
    """Name and role of a client. ``certificate``: DER; ``roles``: by common name, before the extension's.

    Raises:
        NoRole: it has none.
    """
    try:
        client = read_client(certificate)
    except (ValueError, IndexError, StopIteration):
        raise NoRole("its certificate cannot be read") from None
    said = roles.get(client.name, client.role)
    known = {role.name.lower(): role for role in Role}
    if said.lower() not in known:
        why = f"has the role {said!r}" if said else "has no role"
        raise NoRole(f"{client.name!r} {why}; roles are {', '.join(known)}")
    return client.name, known[said.lower()]


def read_client(certificate: bytes) -> CertifiedClient:
    """Read name and role out of a certificate in DER. Raises ValueError, IndexError, StopIteration: it is
    none."""
    ((_, whole),) = _parts(certificate)
    to_be_signed = next(_parts(whole))[1]
    parts = [part for part in _parts(to_be_signed) if part[0] != _VERSION]
    names = [value for _, each in _parts(parts[_SUBJECT][1]) for _, value in _parts(each)]
    name = ""
    for pair in map(list, map(_parts, names)):
        if pair[0] == (_OID, _COMMON_NAME):
            name = pair[1][1].decode()
    return CertifiedClient(name, _role(parts))


def _role(parts: list[tuple[int, bytes]]) -> str:
    for _, extensions in (part for part in parts if part[0] == _EXTENSIONS):
        for _, extension in _parts(next(_parts(extensions))[1]):
            fields = list(_parts(extension))
            if fields[0] == (_OID, _ROLE) and fields[-1][0] == _OCTETS:
                tag, text = next(_parts(fields[-1][1]))
                return text.decode() if tag == _UTF8 else ""
    return ""


def _parts(data: bytes) -> Iterator[tuple[int, bytes]]:
    """Tags and contents of what is written one after the other in DER."""
    at = 0
    while at < len(data):
        tag, length = data[at], data[at + 1]
        at += 2
        if length >= 0x80:
            size = length & 0x7F
            if not 1 <= size <= _LENGTH_BYTES:
                raise ValueError("a length of this form is not DER")
            length = int.from_bytes(data[at : at + size], "big")
            at += size
        if at + length > len(data):
            raise ValueError("it ends too early")
        yield tag, data[at : at + length]
        at += length
