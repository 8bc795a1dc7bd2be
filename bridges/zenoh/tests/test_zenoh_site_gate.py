"""Gate of a bench of a site: who has signed, who may, and what is said to others. Without a network."""

import base64
import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec, rsa
from cryptography.hazmat.primitives.serialization import Encoding
from cryptography.x509.oid import NameOID
from hypothesis import given
from hypothesis import strategies as st

from bridges.zenoh.gate import Gate, Rejected
from bridges.zenoh.site_authority import SiteAuthority, new_site
from bridges.zenoh.site_certificates import SKEW, Pair, issued, key_pem, new_key
from bridges.zenoh.site_folder import SiteFolder, read_certificates
from bridges.zenoh.site_gate import SiteGate
from bridges.zenoh.site_list import read_grant
from bridges.zenoh.users import SecurityError, User
from hil.net.signature import KeySigner, read_key, signed
from hil.net.site_stop import STOP_ALL
from hil.vocab.desk_protocol import LOCAL, Source
from hil.vocab.verbs import Role

NOW = datetime(2026, 6, 1, tzinfo=UTC)
NOW_NS = int(NOW.timestamp()) * 10**9
KEY, PART = "hil/mill/axis/m1/cmd/go", "hil/mill/run/r1/part"
PAYLOAD = b'{"position_deg": 90}'
NONCE = "00112233445566778899aabbccddeeff"


class Site:
    """A site, the folder of its bench ``mill``, and the gate there."""

    def __init__(self, folder: Path) -> None:
        self.authority = SiteAuthority(folder)
        self.at_mill = SiteFolder(self.authority.place("mill"), NOW)
        self.gate = SiteGate(self.at_mill, "mill")

    def signer(self, name: str) -> KeySigner:
        folder = self.authority.place(name)
        key = read_key((folder / "key.pem").read_bytes(), True, "key")
        return KeySigner(name, read_certificates(folder / "cert.pem")[0], key)

    def take(self) -> None:
        self.at_mill.refresh(NOW)
        self.gate.list_changed()


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("gates") / "lab"
    site = new_site(folder, "lab", ["hub.lan"], 7447, NOW, 365, None)
    site.add_benches(["mill", "lathe"], {"rig": "press"}, (), NOW, 365)
    site.add_user("otto", [read_grant("operator@mill"), read_grant("viewer")], NOW, 365)
    site.add_user("anna", [read_grant("admin@rig=press")], NOW, 365)
    site.add_user("vera", [read_grant("viewer@lathe")], NOW, 365)
    return folder


@pytest.fixture
def site(made: Path, tmp_path: Path) -> Site:
    return Site(Path(shutil.copytree(made, tmp_path / "lab")))


def attachment(
    signer: KeySigner, key: str = KEY, at_ns: int = NOW_NS, nonce: str = NONCE, user: str = ""
) -> bytes:
    return signer.signed(key, PAYLOAD, at_ns, nonce, user)


@pytest.mark.parametrize(
    ("name", "role"), [("otto", Role.OPERATOR), ("anna", Role.ADMIN), ("lathe", Role.OPERATOR)]
)
def test_the_gate_knows_who_signed_and_the_role_at_this_bench(site: Site, name: str, role: Role) -> None:
    user = site.gate.check(attachment(site.signer(name)), KEY, PAYLOAD, NOW_NS)
    assert (user.name, user.role, user.is_bench) == (name, role, name == "lathe")
    with pytest.raises(Rejected, match="used before"):
        site.gate.check(attachment(site.signer(name)), KEY, PAYLOAD, NOW_NS)


def _changed(**values: object) -> Callable[[Site], bytes]:
    return lambda site: json.dumps(json.loads(attachment(site.signer("otto"))) | values).encode()


def _by_the_key_of_anna(site: Site) -> bytes:
    other = json.loads(attachment(site.signer("anna"), user="otto"))
    return json.dumps(
        json.loads(attachment(site.signer("otto"))) | {"signature": other["signature"]}
    ).encode()


@pytest.mark.parametrize(
    ("made_by", "words"),
    [
        (_changed(at_ns=NOW_NS + 1), "signature is wrong"),
        (_changed(nonce=NONCE[::-1]), "signature is wrong"),
        (_changed(user="anna"), "signature is wrong"),
        (_changed(signature=""), "signature is wrong"),
        (_changed(signature="AAAA"), "signature is wrong"),
        (_changed(certificate="AAAA"), "none that can be read"),
        (_changed(certificate="-"), "the attachment has to be"),
        (_changed(signature="x"), "the attachment has to be"),
        (_by_the_key_of_anna, "signature is wrong"),
        (lambda site: attachment(site.signer("otto"), "hil/lathe/axis/m1/cmd/go"), "signature is wrong"),
        (lambda site: attachment(site.signer("otto"), user="anna"), "signature is that of otto, not of anna"),
        (lambda site: attachment(site.signer("lathe"), user="anna"), "that of lathe, not of anna"),
        (
            lambda site: attachment(site.signer("vera")),
            "vera has no role at bench mill; `hil zenoh site change`",
        ),
        (
            lambda site: attachment(site.signer("otto"), at_ns=NOW_NS - 31 * 10**9),
            "31.0 s old; compare the clocks",
        ),
        (lambda _: signed("otto", "a-good-password", KEY, PAYLOAD, NOW_NS, NONCE), "signed by a password"),
        (lambda _: b"", "not signed"),
    ],
)
def test_what_is_refused(site: Site, made_by: Callable[[Site], bytes], words: str) -> None:
    with pytest.raises(Rejected, match=words):
        site.gate.check(made_by(site), KEY, PAYLOAD, NOW_NS)


@given(st.data())
def test_an_attachment_with_a_byte_changed_is_refused_in_words(made: Path, data: st.DataObject) -> None:
    site = Site(made)
    good = bytearray(attachment(site.signer("otto")))
    at, bit = data.draw(st.integers(0, 9_999)), data.draw(st.integers(0, 6))
    good[at % len(good)] ^= 1 << bit  # its length varies: a signature has chance in it
    if json_of(good) == json_of(attachment(site.signer("otto"))):
        return
    with pytest.raises(Rejected):
        site.gate.check(bytes(good), KEY, PAYLOAD, NOW_NS)


def json_of(text: bytes | bytearray) -> object:
    """Content of an attachment, without what chance gives a signature, and with the certificate's bytes."""
    try:
        content = json.loads(text)
        der = base64.b64decode(content["certificate"], validate=True)
    except (ValueError, KeyError, TypeError):
        return None
    return {**content, "signature": None, "certificate": der}


def test_a_bench_asks_for_a_user_about_a_part_of_a_run_alone(site: Site) -> None:
    at_lathe = SiteGate(SiteFolder(site.authority.place("lathe"), NOW), "lathe")
    for asker, expected in ((Source("otto", Role.OPERATOR), "otto"), (LOCAL, "lathe")):
        given = at_lathe.signed(asker, "lathe", PART, PAYLOAD)
        now_ns = json.loads(given)["at_ns"]
        assert site.gate.check(given, PART, PAYLOAD, now_ns).name == expected
    given = at_lathe.signed(replace(LOCAL, user="otto"), "lathe", PART, PAYLOAD)  # who has a lease there
    assert site.gate.check(given, PART, PAYLOAD, json.loads(given)["at_ns"]).name == "otto"
    given = at_lathe.signed(Source("otto", Role.OPERATOR), "lathe", STOP_ALL, PAYLOAD)
    assert site.gate.check(given, STOP_ALL, PAYLOAD, json.loads(given)["at_ns"]).name == "lathe"
    given = at_lathe.signed(Source("vera", Role.OPERATOR), "lathe", PART, PAYLOAD)
    with pytest.raises(Rejected, match="vera has no role at bench mill"):
        site.gate.check(given, PART, PAYLOAD, json.loads(given)["at_ns"])


def test_a_list_that_is_copied_counts_at_once(site: Site) -> None:
    otto = site.signer("otto")
    site.authority.change("otto", [read_grant("viewer")])
    site.take()
    assert site.gate.check(attachment(otto), KEY, PAYLOAD, NOW_NS).role == Role.VIEWER
    site.authority.rotate(["otto"], NOW, 365, is_stolen=True)
    site.take()
    with pytest.raises(Rejected, match="certificate of otto is revoked, by list 7 of the site lab"):
        site.gate.check(attachment(otto, nonce=NONCE[::-1]), KEY, PAYLOAD, NOW_NS)
    assert (
        site.gate.check(attachment(site.signer("otto"), nonce="a" * 16), KEY, PAYLOAD, NOW_NS).name == "otto"
    )
    again = site.signer("otto")
    site.authority.remove(["otto"])
    site.take()
    names = site.gate.names
    with pytest.raises(Rejected, match="is revoked, by list 8"):
        site.gate.check(attachment(again, nonce=NONCE[:-1]), KEY, PAYLOAD, NOW_NS)
    site.authority.add_user("karl", [read_grant("viewer")], NOW, 365)
    with pytest.raises(Rejected, match=r"karl is not in list 8 .* copy the newest list"):
        site.gate.check(attachment(site.signer("karl")), KEY, PAYLOAD, NOW_NS)
    site.take()
    assert "karl" in names, "others hold the set"
    assert "otto" not in names


def test_a_certificate_of_another_site(site: Site, tmp_path: Path) -> None:
    other = new_site(tmp_path / "other", "lab", ["hub.lan"], 7447, NOW, 365, None)
    other.add_user("otto", [read_grant("admin")], NOW, 365)
    folder = other.place("otto")
    signer = KeySigner(
        "otto",
        read_certificates(folder / "cert.pem")[0],
        read_key((folder / "key.pem").read_bytes(), True, "key"),
    )
    with pytest.raises(Rejected, match="not from an authority of the site lab: it is another site's"):
        site.gate.check(attachment(signer), KEY, PAYLOAD, NOW_NS)


@pytest.mark.parametrize(
    ("days", "words"), [(-1, "expired at 2026-05-31"), (400, "expired at 2027-06-01"), (-400, "valid from")]
)
def test_a_certificate_that_is_not_good_now(site: Site, days: int, words: str) -> None:
    if words.startswith("expired at 2026"):
        site.authority.make_folder("otto", "otto", (), NOW - 2 * SKEW, 0)
        site.authority.make_folder("otto", "otto", (), datetime(2026, 5, 30, tzinfo=UTC), 1)
        days = 0
    now_ns = NOW_NS + days * 86_400 * 10**9
    with pytest.raises(Rejected, match=words):
        site.gate.check(attachment(site.signer("otto"), at_ns=now_ns), KEY, PAYLOAD, now_ns)


def test_a_bench_with_passwords_says_so() -> None:
    gate = Gate([User("otto", Role.OPERATOR, "a-good-password")])
    given = {"user": "otto", "at_ns": NOW_NS, "nonce": NONCE, "certificate": "AAAA", "signature": "AAAA"}
    with pytest.raises(Rejected, match="this bench knows users by password"):
        gate.check(json.dumps(given).encode(), KEY, PAYLOAD, NOW_NS)


# ---- an authority that is there already ----


def pair(name: str, by: tuple[x509.Certificate, Any] | None, key: Any) -> x509.Certificate:
    """Certificate of an authority, as others make them."""
    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(by[0].subject if by else subject)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(NOW - SKEW)
        .not_valid_after(NOW + 1000 * SKEW)
        .add_extension(x509.BasicConstraints(ca=True, path_length=None), critical=True)
        .sign(by[1] if by else key, hashes.SHA256())
    )


def test_an_authority_with_an_intermediate_one(tmp_path: Path) -> None:
    root_key, key = rsa.generate_private_key(65537, 2048), new_key()
    root = pair("Root", None, root_key)
    between = pair("Intermediate", (root, root_key), key)
    pem = [each.public_bytes(Encoding.PEM) for each in (root, between)]
    chain, short = tmp_path / "chain.pem", tmp_path / "root.pem"
    chain.write_bytes(b"".join(pem))
    short.write_bytes(pem[0])

    site = new_site(tmp_path / "lab", "lab", ["hub.lan"], 7447, NOW, 365, chain)
    assert not site.is_own
    site.add_benches(["mill"], {}, (), NOW, 365)
    site.add_user("otto", [read_grant("operator")], NOW, 365)
    assert not (site.place("mill") / "key.pem").exists()
    for name in ("mill", "otto"):
        own = issued(Pair(between, key), name, NOW, 1)
        (site.place(name) / "cert.pem").write_bytes(own.pem()[0] + pem[1])
        (site.place(name) / "key.pem").write_bytes(own.pem()[1])
        (site.place(name) / "key.pem").chmod(0o600)
    tried = Site(tmp_path / "lab")
    assert tried.gate.check(attachment(tried.signer("otto")), KEY, PAYLOAD, NOW_NS).name == "otto"
    with pytest.raises(SecurityError, match="renew them there"):
        site.rotate([], NOW, 365)
    site.rotate(["otto"], NOW, 365, is_stolen=True)
    tried.take()
    with pytest.raises(Rejected, match="revoked"):
        tried.gate.check(attachment(tried.signer("otto"), nonce=NONCE[::-1]), KEY, PAYLOAD, NOW_NS)
    shutil.copy(short, site.place("mill") / "ca.pem")
    with pytest.raises(
        SecurityError, match=r"ca\.pem lacks the intermediate authority: append its certificate"
    ):
        SiteFolder(site.place("mill"), NOW)


@pytest.mark.parametrize(
    ("made_key", "words"),
    [
        (lambda: rsa.generate_private_key(65537, 2048), "sites use EC keys of P-256"),
        (lambda: ec.generate_private_key(ec.SECP384R1()), "sites use EC keys of P-256"),
    ],
)
def test_a_key_of_another_kind(made_key: Callable[[], Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        read_key(key_pem(made_key()), True, "key.pem")


def test_what_is_signed_is_what_the_page_says(site: Site) -> None:
    """As a program in another language makes it and checks it."""
    given = json.loads(attachment(site.signer("otto")))
    text = f"otto\n{KEY}\n{NOW_NS}\n{NONCE}\n".encode() + PAYLOAD
    certificate = x509.load_der_x509_certificate(base64.b64decode(given["certificate"]))
    key = certificate.public_key()
    assert isinstance(key, ec.EllipticCurvePublicKey)
    key.verify(base64.b64decode(given["signature"]), text, ec.ECDSA(hashes.SHA256()))
