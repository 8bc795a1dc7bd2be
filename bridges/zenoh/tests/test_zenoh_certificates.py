"""Attackers on another computer of a site with certificates: who has what gets in where."""

import json
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
from zenoh_attacks import (
    DAEMON,
    USERS,
)
from zenoh_computers import (
    Child,
    Lan,
    assert_let_in_for_nothing,
    assert_refused,
    assert_rights,
    child,
)

from bridges.zenoh.options import TlsOptions
from bridges.zenoh.site_keys import Site, make_site
from bridges.zenoh.users import read_users
from bridges.zenoh.zenoh_config import client_config
from hil.vocab.verbs import Role

pytestmark = pytest.mark.long


class Certified(Lan):
    """Daemon with certificates, and those who try. ``site`` is the folder of its keys."""

    def __init__(self, there: str, daemon: Child, endpoint: str, site: Path) -> None:
        super().__init__(there, daemon, endpoint)
        self.site = site
        self.secrets = {user.name: user.secret for user in read_users(site / "users")}

    def own(self, user: str) -> TlsOptions:
        folder = self.site / "clients" / user
        return TlsOptions(
            ca=folder / "ca.pem", certificate=folder / f"{user}.pem", key=folder / f"{user}.key"
        )

    def entered(
        self, user: str, tls: TlsOptions, secret: str | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Tried with a user's name and password, and these certificates."""
        secret = secret or self.secrets[user]
        return self.tried(client_config([self.endpoint], user, secret, tls), user, secret)


@pytest.fixture(scope="module")
def by_certificate(
    computers: tuple[str, str], tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Certified]:
    site = tmp_path_factory.mktemp("site")
    users = [*USERS.items(), ("eve", Role.ADMIN)]
    make_site(site, Site("b", [DAEMON], users, datetime.now(UTC), port=7449))
    listed = (site / "users").read_text().splitlines(keepends=True)
    (site / "users").write_text("".join(line for line in listed if not line.startswith("eve:")))
    endpoint = f"tls/{DAEMON}:7449"
    tls = {"ca": site / "ca.pem", "certificate": site / "daemon.pem", "key": site / "daemon.key"}
    options = {"users": str(site / "users"), "tls": {name: str(path) for name, path in tls.items()}}
    with child(computers[0], "serve", {"listen": [endpoint], **options}) as daemon:
        assert daemon.read() == {"ready": True}
        yield Certified(computers[1], daemon, endpoint, site)


def reissued(site: Path, user: str, folder: Path, begin: datetime, end: datetime) -> TlsOptions:
    """A user's certificate once more, for the same key, from the same authority, but for another time."""
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes, serialization

    old = x509.load_pem_x509_certificate((site / f"clients/{user}/{user}.pem").read_bytes())
    signer: Any = serialization.load_pem_private_key((site / "ca.key").read_bytes(), None)
    builder = x509.CertificateBuilder(
        old.issuer,
        old.subject,
        old.public_key(),
        x509.random_serial_number(),
        begin,
        end,
        list(old.extensions),
    )
    new = folder / "new.pem"
    new.write_bytes(builder.sign(signer, hashes.SHA256()).public_bytes(serialization.Encoding.PEM))
    return TlsOptions(ca=site / "ca.pem", certificate=new, key=site / f"clients/{user}/{user}.key")


@pytest.mark.parametrize("user", USERS)
def test_the_file_of_a_user_gives_the_rights_of_its_role(by_certificate: Certified, user: str) -> None:
    file = by_certificate.site / "clients" / user / "zenoh.json"
    assert_rights(USERS[user], user, *by_certificate.tried(str(file), user, by_certificate.secrets[user]))


def test_certificate_and_password_as_files_and_words(by_certificate: Certified) -> None:
    assert_rights(Role.OPERATOR, "opa", *by_certificate.entered("opa", by_certificate.own("opa")))


def test_a_certificate_is_good_until_it_ends(by_certificate: Certified, tmp_path: Path) -> None:
    now = datetime.now(UTC)
    hour = timedelta(hours=1)
    good = reissued(by_certificate.site, "opa", tmp_path, now - hour, now + hour)
    assert_rights(Role.OPERATOR, "opa", *by_certificate.entered("opa", good))
    expired = reissued(by_certificate.site, "opa", tmp_path, now - 2 * hour, now - hour)
    assert_refused(by_certificate.entered("opa", expired))
    early = reissued(by_certificate.site, "opa", tmp_path, now + hour, now + 2 * hour)
    assert_refused(by_certificate.entered("opa", early))


def test_a_certificate_alone_does_not_do(by_certificate: Certified) -> None:
    assert_refused(by_certificate.entered("opa", by_certificate.own("opa"), "a-wrong-password"))
    config = client_config([by_certificate.endpoint], tls=by_certificate.own("opa"))
    assert_refused(by_certificate.tried(config, "opa", by_certificate.secrets["opa"]))


def test_a_password_alone_does_not_do(by_certificate: Certified) -> None:
    secret = by_certificate.secrets["opa"]
    trust = {"transport/link/tls/root_ca_certificate": str(by_certificate.site / "ca.pem")}
    config = client_config([by_certificate.endpoint], "opa", secret) | trust
    assert_refused(by_certificate.tried(config, "opa", secret))


def test_anothers_password_beside_the_own_certificate_gives_nothing(by_certificate: Certified) -> None:
    assert_let_in_for_nothing(by_certificate.entered("opa", by_certificate.own("vic")))


def test_a_certificate_of_another_authority_does_not_do(by_certificate: Certified, tmp_path: Path) -> None:
    make_site(tmp_path / "s", Site("b", [DAEMON], [("opa", Role.ADMIN)], datetime.now(UTC)))
    folder = tmp_path / "s/clients/opa"
    forged = TlsOptions(
        ca=by_certificate.site / "ca.pem", certificate=folder / "opa.pem", key=folder / "opa.key"
    )
    assert_refused(by_certificate.entered("opa", forged))


def test_who_was_taken_out_of_users_is_out(by_certificate: Certified) -> None:
    file = by_certificate.site / "clients/eve/zenoh.json"
    config = json.loads(file.read_text())
    secret = config["transport"]["auth"]["usrpwd"]["password"]
    assert_refused(by_certificate.tried(str(file), "eve", secret))


def test_without_tls_nobody_comes_in(by_certificate: Certified) -> None:
    config = client_config([f"tcp/{DAEMON}:7449"], "opa", by_certificate.secrets["opa"])
    assert_refused(by_certificate.tried(config, "opa", by_certificate.secrets["opa"]))


def test_a_daemon_of_another_name_is_not_believed(
    by_certificate: Certified, computers: tuple[str, str]
) -> None:
    """A user's certificate would not make a daemon either: it has no such purpose and no such name."""
    own = by_certificate.own("vic")
    options = {
        "listen": [f"tls/{DAEMON}:7448"],
        "users": str(by_certificate.site / "users"),
        "tls": {name: str(path) for name, path in own.model_dump().items()},
    }
    with child(computers[0], "serve", options) as false_daemon:
        assert false_daemon.read() == {"ready": True}
        secret = by_certificate.secrets["opa"]
        config = client_config([f"tls/{DAEMON}:7448"], "opa", secret, by_certificate.own("opa"))
        assert_refused(Lan(computers[1], false_daemon, "").tried(config, "opa", secret))
