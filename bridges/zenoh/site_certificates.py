"""Certificates of a site, which its authority issues, and their files."""

import ipaddress
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bridges.zenoh.users import SecurityError
from hil.net.signature import NO_CRYPTOGRAPHY

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ec import EllipticCurvePrivateKey
    from cryptography.x509 import Certificate, ExtensionType

_HOST = re.compile(r"[A-Za-z0-9]([A-Za-z0-9.-]{0,251}[A-Za-z0-9])?")
SKEW = timedelta(hours=1)
"""Time before now from which certificates are valid: clocks of a site differ."""


@dataclass(frozen=True)
class Pair:
    """Certificate with its private key."""

    certificate: "Certificate"
    key: "EllipticCurvePrivateKey"

    def pem(self) -> tuple[bytes, bytes]:
        from cryptography.hazmat.primitives.serialization import Encoding

        return self.certificate.public_bytes(Encoding.PEM), key_pem(self.key)


def key_pem(key: "EllipticCurvePrivateKey") -> bytes:
    """Private key as PEM, without a password."""
    from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat

    return key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())


def need_cryptography() -> None:
    """Check that the package is there. Raises SecurityError."""
    try:
        import cryptography  # noqa: F401
    except ImportError:
        raise SecurityError(NO_CRYPTOGRAPHY) from None


def check_host(host: str) -> None:
    """Check a name or an address of a computer. Raises SecurityError."""
    try:
        ipaddress.ip_address(host)
    except ValueError:
        if not _HOST.fullmatch(host):
            raise SecurityError(f"--host {host!r}: write a name or an address, without port") from None


def door(host: str, port: int) -> str:
    """Endpoint of a computer, for zenoh."""
    return f"tls/[{host}]:{port}" if ":" in host else f"tls/{host}:{port}"


def anywhere(hosts: Sequence[str]) -> str:
    """Address of all interfaces, for a computer with such addresses."""
    return "[::]" if any(":" in host for host in hosts) else "0.0.0.0"


def new_key() -> "EllipticCurvePrivateKey":
    from cryptography.hazmat.primitives.asymmetric import ec

    return ec.generate_private_key(ec.SECP256R1())


def made_authority(site: str, now: datetime, days: int) -> Pair:
    """Authority with a certificate of its own."""
    from cryptography import x509

    signs = _usage(key_cert_sign=True, crl_sign=True)
    extensions = [(x509.BasicConstraints(ca=True, path_length=0), True), (signs, True)]
    return _signed(f"hil site {site}", now, days, None, extensions)


def issued(by: Pair, name: str, now: datetime, days: int, hosts: Sequence[str] = ()) -> Pair:
    """Certificate of a member, with a new key. ``hosts``: names and addresses at which it listens."""
    from cryptography import x509
    from cryptography.x509.oid import ExtendedKeyUsageOID

    purposes = [ExtendedKeyUsageOID.CLIENT_AUTH]
    extensions: list[tuple[ExtensionType, bool]] = [
        (x509.BasicConstraints(ca=False, path_length=None), True),
        (_usage(digital_signature=True), True),
    ]
    if hosts:
        purposes.append(ExtendedKeyUsageOID.SERVER_AUTH)
        extensions.append((x509.SubjectAlternativeName([_alternative(host) for host in hosts]), False))
    extensions.append((x509.ExtendedKeyUsage(purposes), False))
    return _signed(name, now, days, by, extensions)


def hosts_of(certificate: "Certificate") -> list[str]:
    """Names and addresses in a certificate."""
    from cryptography import x509

    try:
        names = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except x509.ExtensionNotFound:
        return []
    return [str(each.value) for each in names]


def _usage(**wanted: bool) -> "ExtensionType":
    from cryptography import x509

    kinds = (
        *("digital_signature", "content_commitment", "key_encipherment", "data_encipherment"),
        *("key_agreement", "key_cert_sign", "crl_sign", "encipher_only", "decipher_only"),
    )
    return x509.KeyUsage(**{kind: wanted.get(kind, False) for kind in kinds})


def _alternative(host: str) -> Any:
    from cryptography import x509

    try:
        return x509.IPAddress(ipaddress.ip_address(host))
    except ValueError:
        pass
    try:
        return x509.DNSName(host)
    except ValueError:
        raise SecurityError(f"host: {host!r} is neither a name of ASCII letters nor an address") from None


def _signed(
    name: str, now: datetime, days: int, by: Pair | None, extensions: "Sequence[tuple[ExtensionType, bool]]"
) -> Pair:
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes
    from cryptography.x509.oid import NameOID

    key = new_key()
    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
    builder = (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(by.certificate.subject if by else subject)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - SKEW)
        .not_valid_after(now + timedelta(days=days))
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
    )
    for extension, critical in extensions:
        builder = builder.add_extension(extension, critical=critical)
    if by:
        above = by.certificate.public_key()
        identifier = x509.AuthorityKeyIdentifier.from_issuer_public_key(above)  # type: ignore[arg-type]
        builder = builder.add_extension(identifier, critical=False)
    return Pair(builder.sign(by.key if by else key, hashes.SHA256()), key)


def write_pair(folder: Path, name: str, pair: Pair) -> None:
    """Write a certificate and its key as new files."""
    certificate, key = pair.pem()
    write_new(folder / f"{name}.pem", certificate, mode=0o644)
    write_new(folder / f"{name}.key", key)


def write_new(path: Path, content: bytes, mode: int = 0o600) -> None:
    """Write a file that must not be there. Raises OSError."""
    with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "wb") as file:
        file.write(content)


def write_whole(path: Path, content: bytes, mode: int = 0o600) -> None:
    """Write a file in the place of one that may be there; readers see the old or the new one. Raises
    OSError."""
    begun = path.with_name(f".{path.name}.{os.getpid()}")
    begun.unlink(missing_ok=True)
    write_new(begun, content, mode)
    begun.replace(path)


def nested(entries: Mapping[str, Any]) -> dict[str, Any]:
    """Zenoh's configuration as one object, of values by their path in it."""
    config: dict[str, Any] = {}
    for path, value in entries.items():
        *above, last = path.split("/")
        inner = config
        for each in above:
            inner = inner.setdefault(each, {})
        inner[last] = value
    return config
