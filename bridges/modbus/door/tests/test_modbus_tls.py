"""Modbus/TCP Security: who a client is, by its certificate, and what it may do."""

import asyncio
import ssl
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.asymmetric.ec import EllipticCurvePrivateKey
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
from cryptography.x509.oid import NameOID
from served_door import READ, WAVE, Door, RawClient, packet, with_door

from bridges.modbus.door.client_role import CertifiedClient, NoRole, read_client, role_of
from bridges.modbus.door.door_options import Certificates, Options
from bridges.modbus.door.modbus_bridge import ModbusBridge
from hil.testing import RecordingDesk
from hil.vocab.bridge_protocol import BridgeError
from hil.vocab.verbs import Role

ROLE = x509.ObjectIdentifier("1.3.6.1.4.1.50316.802.1")


@dataclass
class Issued:
    certificate: x509.Certificate
    key: EllipticCurvePrivateKey

    def write(self, folder: Path, name: str) -> tuple[Path, Path]:
        cert, key = folder / f"{name}.pem", folder / f"{name}.key"
        cert.write_bytes(self.certificate.public_bytes(Encoding.PEM))
        key.write_bytes(self.key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()))
        return cert, key


def issue(name: str, role: str | None = None, by: Issued | None = None) -> Issued:
    key, now = ec.generate_private_key(ec.SECP256R1()), datetime.now(UTC)
    subject = x509.Name(
        [
            x509.NameAttribute(NameOID.ORGANIZATION_NAME, "a plant"),
            x509.NameAttribute(NameOID.COMMON_NAME, name),
        ]
    )
    builder = (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(by.certificate.subject if by else subject)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - timedelta(hours=1))
        .not_valid_after(now + timedelta(hours=1))
        .add_extension(x509.BasicConstraints(ca=by is None, path_length=None), True)
        .add_extension(x509.SubjectAlternativeName([x509.DNSName("localhost")]), False)
    )
    if role is not None:
        text = role.encode()
        length = bytes([len(text)]) if len(text) < 128 else bytes((0x81, len(text)))
        value = b"\x0c" + length + text
        builder = builder.add_extension(x509.UnrecognizedExtension(ROLE, value), False)
    return Issued(builder.sign(by.key if by else key, hashes.SHA256()), key)


@dataclass
class Site:
    folder: Path
    authority: Issued

    def options(self, roles: Mapping[str, str] | None = None) -> Certificates:
        certificate, key = issue("door", by=self.authority).write(self.folder, "door")
        clients, _ = self.authority.write(self.folder, "authority")
        return Certificates.model_validate(
            {"certificate": certificate, "key": key, "clients": clients, "roles": dict(roles or {})}
        )

    def context(self, client: Issued | None) -> ssl.SSLContext:
        context = ssl.create_default_context(cafile=str(self.folder / "authority.pem"))
        if client:
            context.load_cert_chain(*client.write(self.folder, "client"))
        return context


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Site:
    return Site(tmp_path_factory.mktemp("site"), issue("authority"))


async def secured(door: Door, context: ssl.SSLContext) -> RawClient:
    _, _, number = door.bridge.status()["listen"][0].rpartition(":")
    streams = await asyncio.open_connection(
        "127.0.0.1", int(number), ssl=context, server_hostname="localhost"
    )
    door.clients.append(RawClient(*streams))
    return door.clients[-1]


@pytest.mark.parametrize(
    ("name", "extension", "roles", "role"),
    [
        ("ann", "operator", {}, Role.OPERATOR),
        ("ann", "Viewer", {}, Role.VIEWER),
        ("ann", None, {"ann": "admin"}, Role.ADMIN),
        ("ann", "admin", {"ann": "viewer"}, Role.VIEWER),
    ],
)
def test_a_role_of_a_certificate(
    site: Site, name: str, extension: str | None, roles: dict[str, str], role: Role
) -> None:
    async def use(door: Door) -> None:
        client = await secured(door, site.context(issue(name, extension, site.authority)))
        assert (await client.ask(READ))[0] == 4
        assert door.desk.asked[0][0].name == f"modbus client {name}"
        assert door.desk.asked[0][0].role == role
        assert door.bridge.status()["root"] == "modbus+tls"
        assert not door.bridge.status()["insecure"]

    with_door(use, tls=site.options(roles))


@pytest.mark.parametrize("extension", [None, "", "boss"])
def test_without_a_role_nobody_asks(site: Site, extension: str | None) -> None:
    async def use(door: Door) -> None:
        client = await secured(door, site.context(issue("eve", extension, site.authority)))
        await client.send(packet(WAVE))
        assert await client.is_closed()
        assert door.desk.asked == []
        assert door.bridge.status()["closed"] == {"role": 1}

    with_door(use, tls=site.options())


def test_strangers_are_not_let_in(site: Site) -> None:
    async def use(door: Door) -> None:
        stranger = issue("ann", "admin", issue("another authority"))
        for context in (site.context(None), site.context(stranger)):
            try:
                client = await secured(door, context)
                await client.send(packet(WAVE))
                assert await client.is_closed()
            except (OSError, asyncio.IncompleteReadError):
                pass
        plain = await door.client()
        await plain.send(packet(WAVE))
        assert await plain.is_closed()
        assert door.desk.asked == []
        assert door.bridge.status()["closed"]["tls"] == 3
        good = await secured(door, site.context(issue("ann", "operator", site.authority)))
        assert await good.ask(WAVE) == WAVE

    with_door(use, tls=site.options())


@pytest.mark.parametrize(
    ("files", "why"),
    [
        ({"certificate": Path("/nowhere")}, "tls.certificate: /nowhere is not there; write where"),
        ({"clients": Path(__file__)}, "tls.clients: .* is not PEM"),
        ({"key": Path(__file__)}, "tls.key: .* is not PEM"),
    ],
)
def test_files_that_cannot_be_used(site: Site, files: dict[str, Path], why: str) -> None:
    tls = site.options().model_copy(update=files)
    bridge = ModbusBridge(Options(listen="127.0.0.1:0", tls=tls), RecordingDesk())
    with pytest.raises(BridgeError, match=why):
        asyncio.run(bridge.open())


def test_name_and_role_are_read_out_of_a_certificate(site: Site) -> None:
    der = issue("änn " + "x" * 40, "operator" * 30, site.authority).certificate.public_bytes(Encoding.DER)
    assert read_client(der) == CertifiedClient("änn " + "x" * 40, "operator" * 30)


def test_no_piece_of_a_certificate_is_more_than_refused(site: Site) -> None:
    der = issue("ann", "operator", site.authority).certificate.public_bytes(Encoding.DER)
    for end in range(len(der)):
        with pytest.raises(NoRole):
            role_of(der[:end], {})
    for at in range(len(der)):
        for byte in (0, 0x80, 0xFF, der[at] ^ 1):
            try:
                role_of(der[:at] + bytes([byte]) + der[at + 1 :], {"ann": "viewer"})
            except NoRole:
                continue
