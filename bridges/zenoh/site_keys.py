"""Certificates of a small site: an authority, a daemon's certificate, and for each user certificate, password
and configuration. ``cli.py`` is their command."""

import base64
import ipaddress
import json
import os
import re
import secrets
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bridges.zenoh.users import BENCH, SecurityError, parse_users
from bridges.zenoh.zenoh_config import certified, client_config
from hil.vocab.verbs import Role

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ec import EllipticCurvePrivateKey
    from cryptography.x509 import Certificate, ExtensionType

_BENCH = re.compile(r"[a-z][a-z0-9_-]{0,31}")
_HOST = re.compile(r"[A-Za-z0-9]([A-Za-z0-9.-]{0,251}[A-Za-z0-9])?")
SKEW = timedelta(hours=1)
"""Time before now from which certificates are valid: clocks of a site differ."""


@dataclass(frozen=True)
class Site:
    """Site to make. ``hosts``: names and addresses of the daemon's computer; clients connect to the first.
    ``now`` has a time zone."""

    bench: str
    hosts: Sequence[str]
    users: Sequence[tuple[str, Role]]
    now: datetime
    days: int = 365
    port: int = 7447
    more: Sequence[str] = ()
    """Further benches, behind the same router; they share files and certificate."""
    routers: Sequence[str] = ()
    """Names and addresses of the router's computer, to which benches and clients connect."""

    @property
    def benches(self) -> Sequence[str]:
        return self.bench, *self.more


@dataclass(frozen=True)
class _Pair:
    certificate: "Certificate"
    key: "EllipticCurvePrivateKey"

    def pem(self) -> tuple[bytes, bytes]:
        from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat

        return (
            self.certificate.public_bytes(Encoding.PEM),
            self.key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()),
        )


def make_site(folder: Path, site: Site) -> str:
    """Write all files into a new or empty folder; answers the lines for the bench's configuration.

    Raises:
        SecurityError: there are files already, a name does not do, or ``cryptography`` is not there.
    """
    try:
        import cryptography  # noqa: F401
    except ImportError:
        raise SecurityError(
            "certificates need the package cryptography: pip install 'hil-motion[site]'"
        ) from None
    _check(site)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise SecurityError(f"{folder} is not empty, and nothing is overwritten; name another folder")
        folder.chmod(0o700)
        return _write_site(folder.absolute(), site)
    except OSError as error:
        raise SecurityError(f"{error.filename or folder}: {error.strerror}") from None


def _check(site: Site) -> None:
    """Refuse names that would make certificates that nobody can use."""
    for bench in site.benches:
        if not _BENCH.fullmatch(bench):
            raise SecurityError(
                f"--bench {bench!r}: a bench's name is a letter a-z and up to 31 of a-z, 0-9, _, -"
            )
    if not (site.hosts or site.routers):
        raise SecurityError(
            "--host or --router: write where clients connect, the bench's computer or a router's"
        )
    if site.more and not site.routers:
        raise SecurityError("--bench: several benches join a router; write --router, or make a site for each")
    for host in (*site.hosts, *site.routers):
        try:
            ipaddress.ip_address(host)
        except ValueError:
            if not _HOST.fullmatch(host):
                raise SecurityError(f"--host {host!r}: write a name or an address, without port") from None
    names = [name.lower() for name, _ in site.users] + list(site.benches)
    if "ca" in names:
        raise SecurityError("--user ca: that is the authority's name; take another")
    if twice := {name for name in names if names.count(name) > 1}:
        raise SecurityError(f"--user {min(twice)}: that name is there twice")


def _write_site(folder: Path, site: Site) -> str:
    passwords = {name: secrets.token_urlsafe(24) for name, _ in site.users}
    lines = [f"{name}:{role.name.lower()}:{passwords[name]}" for name, role in site.users]
    lines += [f"{bench}:{BENCH}:{secrets.token_urlsafe(24)}" for bench in site.benches]
    parse_users(lines, "users")
    authority = _authority(site)
    daemon = _issued(authority, site, certified(site.bench), hosts=site.hosts)
    owns = {name: _issued(authority, site, name) for name, _ in site.users}

    _write(folder / "users", "\n".join(lines).encode() + b"\n")
    _write_pair(folder, "ca", authority)
    _write_pair(folder, "daemon", daemon)
    if site.routers:
        _write_pair(folder, "router", _issued(authority, site, "hil router", hosts=site.routers))
    for name, own in owns.items():
        of_user = folder / "clients" / name
        of_user.mkdir(parents=True, mode=0o700)
        _write(of_user / "ca.pem", authority.pem()[0], mode=0o644)
        _write_pair(of_user, name, own)
        config = _client(site, name, passwords[name], authority, own)
        _write(of_user / "zenoh.json", json.dumps(config, indent=1).encode())
    snippet = _snippet(folder, site)
    _write(folder / "bridge.yaml", snippet.encode(), mode=0o644)
    return snippet


def _write_pair(folder: Path, name: str, pair: _Pair) -> None:
    certificate, key = pair.pem()
    _write(folder / f"{name}.pem", certificate, mode=0o644)
    _write(folder / f"{name}.key", key)


def _write(path: Path, content: bytes, mode: int = 0o600) -> None:
    with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "wb") as file:
        file.write(content)


def _authority(site: Site) -> _Pair:
    from cryptography import x509
    from cryptography.hazmat.primitives.asymmetric import ec

    key = ec.generate_private_key(ec.SECP256R1())
    signs = _usage(key_cert_sign=True, crl_sign=True)
    extensions = [(x509.BasicConstraints(ca=True, path_length=0), True), (signs, True)]
    return _signed(site, f"hil site {site.bench}", key, None, extensions)


def _issued(authority: _Pair, site: Site, name: str, hosts: Sequence[str] = ()) -> _Pair:
    from cryptography import x509
    from cryptography.hazmat.primitives.asymmetric import ec
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
    return _signed(site, name, ec.generate_private_key(ec.SECP256R1()), authority, extensions)


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
    site: Site,
    name: str,
    key: "EllipticCurvePrivateKey",
    authority: _Pair | None,
    extensions: "Sequence[tuple[ExtensionType, bool]]",
) -> _Pair:
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes
    from cryptography.x509.oid import NameOID

    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
    builder = (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(authority.certificate.subject if authority else subject)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(site.now - SKEW)
        .not_valid_after(site.now + timedelta(days=site.days))
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
    )
    for extension, critical in extensions:
        builder = builder.add_extension(extension, critical=critical)
    if authority:
        above = authority.certificate.public_key()
        identifier = x509.AuthorityKeyIdentifier.from_issuer_public_key(above)  # type: ignore[arg-type]
        builder = builder.add_extension(identifier, critical=False)
    return _Pair(builder.sign(authority.key if authority else key, hashes.SHA256()), key)


def _client(site: Site, user: str, password: str, authority: _Pair, own: _Pair) -> dict[str, Any]:
    """Make a zenoh configuration that needs no other file. The password is what commands are signed with."""

    def text(pem: bytes) -> str:
        return base64.b64encode(pem).decode()

    certificate, key = own.pem()
    entries = client_config([_door(site)], user, password) | {
        "transport/link/tls": {
            "root_ca_certificate_base64": text(authority.pem()[0]),
            "connect_certificate_base64": text(certificate),
            "connect_private_key_base64": text(key),
            "enable_mtls": True,
            "verify_name_on_connect": True,
        }
    }
    config: dict[str, Any] = {}
    for path, value in entries.items():
        *above, last = path.split("/")
        inner = config
        for each in above:
            inner = inner.setdefault(each, {})
        inner[last] = value
    return config


def _door(site: Site) -> str:
    """Address to which clients connect."""
    first = [*site.routers, *site.hosts][0]
    return f"tls/[{first}]:{site.port}" if ":" in first else f"tls/{first}:{site.port}"


def router_command(folder: Path, site: Site) -> str:
    """Command that runs the site's router."""
    of = folder.absolute()
    files = f"--ca {of}/ca.pem --certificate {of}/router.pem --key {of}/router.key --users {of}/users"
    return f"hil zenoh router --listen tls/{_anywhere(site.routers)}:{site.port} {files}"


def _anywhere(hosts: Sequence[str]) -> str:
    return "[::]" if any(":" in host for host in hosts) else "0.0.0.0"


def _snippet(folder: Path, site: Site) -> str:
    listens = f'    listen: ["tls/{_anywhere(site.hosts)}:{site.port}"]\n'
    if site.routers:
        listens = f'    listen: []\n    connect: ["{_door(site)}"]\n'
    return (
        "bridges:\n"
        "  zenoh:\n"
        f"{listens}"
        f"    users: {json.dumps(str(folder / 'users'))}\n"
        "    tls:\n"
        f"      ca: {json.dumps(str(folder / 'ca.pem'))}\n"
        f"      certificate: {json.dumps(str(folder / 'daemon.pem'))}\n"
        f"      key: {json.dumps(str(folder / 'daemon.key'))}\n"
    )
