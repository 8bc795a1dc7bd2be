"""Certificates and passwords of a site, as ``hil zenoh keys`` makes them."""

import json
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
import zenoh
from cryptography import x509
from cryptography.hazmat.primitives.asymmetric import ec
from typer.testing import CliRunner

from bridges.zenoh.cli import app
from bridges.zenoh.site_keys import Site, make_site
from bridges.zenoh.users import SecurityError, read_users
from hil.vocab.verbs import Role

AT = datetime(2026, 1, 1, tzinfo=UTC)
SITE = Site("b", ["10.0.0.1", "bench.example"], [("opa", Role.OPERATOR), ("vic", Role.VIEWER)], AT, 30, 7500)


def certificate(path: Path) -> x509.Certificate:
    return x509.load_pem_x509_certificate(path.read_bytes())


def test_a_site(tmp_path: Path) -> None:
    folder = tmp_path / "site"
    snippet = make_site(folder, SITE)
    authority, daemon = certificate(folder / "ca.pem"), certificate(folder / "daemon.pem")
    opa = certificate(folder / "clients/opa/opa.pem")
    for each in (authority, daemon, opa):
        each.verify_directly_issued_by(authority)
        assert each.not_valid_after_utc == AT + timedelta(days=30)
        assert each.not_valid_before_utc <= AT
        assert isinstance(each.public_key(), ec.EllipticCurvePublicKey)
    assert opa.subject.rfc4514_string() == "CN=opa"
    names = daemon.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    assert [str(each.value) for each in names] == SITE.hosts
    may = [
        {usage._name for usage in each.extensions.get_extension_for_class(x509.ExtendedKeyUsage).value}
        for each in (daemon, opa)
    ]
    assert may == [{"serverAuth", "clientAuth"}, {"clientAuth"}]
    users = read_users(folder / "users")
    assert [(user.name, user.role) for user in users if not user.is_bench] == SITE.users
    assert [user.name for user in users if user.is_bench] == ["b"]
    assert snippet == (folder / "bridge.yaml").read_text()
    for path in ("users", "ca.pem", "daemon.pem", "daemon.key"):
        assert str(folder / path) in snippet
    assert '["tls/0.0.0.0:7500"]' in snippet


def test_what_is_private_is_for_its_owner_only(tmp_path: Path) -> None:
    folder = tmp_path / "site"
    make_site(folder, SITE)
    files = [path for path in folder.rglob("*") if path.is_file()]
    open_to_others = {str(path.relative_to(folder)) for path in files if path.stat().st_mode & 0o077}
    certificates = {"clients/opa/ca.pem", "clients/opa/opa.pem", "clients/vic/ca.pem", "clients/vic/vic.pem"}
    assert open_to_others == {"bridge.yaml", "ca.pem", "daemon.pem"} | certificates
    private = {str(path.relative_to(folder)) for path in files if b"PRIVATE KEY" in path.read_bytes()}
    assert private == {"ca.key", "daemon.key", "clients/opa/opa.key", "clients/vic/vic.key"}


def test_a_clients_file_is_a_configuration_of_zenoh(tmp_path: Path) -> None:
    make_site(tmp_path / "site", SITE)
    config = zenoh.Config.from_file(tmp_path / "site/clients/opa/zenoh.json")
    assert json.loads(config.get_json("connect/endpoints")) == ["tls/10.0.0.1:7500"]
    login = json.loads(config.get_json("transport/auth/usrpwd"))
    users = {user.name: user.secret for user in read_users(tmp_path / "site/users")}
    assert (login["user"], login["password"]) == ("opa", users["opa"])


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    (tmp_path / "notes").write_text("mine")
    with pytest.raises(SecurityError, match="not empty"):
        make_site(tmp_path, SITE)
    assert [path.name for path in tmp_path.iterdir()] == ["notes"]


@pytest.mark.parametrize(
    ("site", "words"),
    [
        (Site("b", ["bänch"], SITE.users, AT), "write a name or an address"),
        (Site("b", ["10.0.0.1:7447"], SITE.users, AT), "without port"),
        (Site("b", ["[::1]"], SITE.users, AT), "without port"),
        (Site("b", [""], SITE.users, AT), "write a name or an address"),
        (Site("", ["10.0.0.1"], SITE.users, AT), "--bench ''"),
        (Site("b" * 60, ["10.0.0.1"], SITE.users, AT), "up to 31"),
        (Site("b", ["10.0.0.1"], [("ca", Role.ADMIN)], AT), "the authority's name"),
        (Site("b", ["10.0.0.1"], [("opa", Role.ADMIN), ("Opa", Role.VIEWER)], AT), "twice"),
        (Site("b", ["10.0.0.1"], [("../eve", Role.ADMIN)], AT), "no name"),
        (Site("b", ["10.0.0.1"], [("opa", Role.ADMIN), ("opa", Role.VIEWER)], AT), "twice"),
    ],
)
def test_names_that_do_not_do(tmp_path: Path, site: Site, words: str) -> None:
    with pytest.raises(SecurityError, match=words):
        make_site(tmp_path / "site", site)
    assert not list(tmp_path.glob("site/*")), "what was begun would stand in the next one's way"


def test_the_command(tmp_path: Path) -> None:
    words = ["keys", str(tmp_path / "s"), "--bench", "b", "--host", "10.0.0.1", "--host", "::1"]
    done = CliRunner().invoke(app, [*words, "--user", "opa:operator", "--user", "vic:viewer", "--days", "2"])
    assert done.exit_code == 0, done.output
    assert 'listen: ["tls/[::]:7447"]' in done.stdout
    assert certificate(tmp_path / "s/daemon.pem").not_valid_after_utc - datetime.now(UTC) < timedelta(days=2)
    again = CliRunner().invoke(app, [*words, "--user", "opa:operator"])
    assert (again.exit_code, "not empty" in again.stderr) == (2, True)
    wrong = CliRunner().invoke(app, [*words, "--user", "opa:boss"])
    assert (wrong.exit_code, "viewer, operator, admin" in wrong.stderr) == (2, True)


def test_without_the_package_the_line_that_gets_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "cryptography", None)
    with pytest.raises(SecurityError, match="pip install 'hil-motion"):
        make_site(tmp_path / "site", SITE)
    assert not (tmp_path / "site").exists()
