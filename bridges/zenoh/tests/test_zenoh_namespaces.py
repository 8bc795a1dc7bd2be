"""Two computers, as network namespaces with a wire between them: on one a daemon's session, on the other who
tries. Each is a process of its own. Needs root and iproute2.

The daemon's session is what the bridge opens, with stand-ins behind it that note what reaches them: on the
commands' keys with what the gate says to it.
"""

import json
import os
import secrets
import selectors
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from bridges.zenoh.options import TlsOptions
from bridges.zenoh.site_keys import Site, make_site
from bridges.zenoh.users import read_users
from bridges.zenoh.zenoh_config import client_config
from hil.vocab.verbs import Role

sys.path.insert(0, str(Path(__file__).parent))  # --import-mode=importlib leaves it out

import zenoh_attacks
from zenoh_attacks import (
    ATTACKER,
    COMMANDS,
    DAEMON,
    DEADLINE_S,
    FAULTS,
    LIVE,
    NEVER,
    READ,
    TOLD,
    UNTOLD,
    USERS,
    ours,
)


def run(*command: str) -> None:
    subprocess.run(command, check=True, capture_output=True, text=True, timeout=DEADLINE_S)


@contextmanager
def two_computers(tag: str) -> Iterator[tuple[str, str]]:
    """The names of two namespaces, the daemon's and the attackers'."""
    if os.geteuid() != 0 or shutil.which("ip") is None:
        pytest.skip("network namespaces need root and iproute2")
    here, there = f"hil{os.getpid()}{tag}0", f"hil{os.getpid()}{tag}1"
    wires = f"h{os.getpid()}{tag}0", f"h{os.getpid()}{tag}1"
    with ExitStack() as stack:
        try:
            for name in (here, there):
                run("ip", "netns", "add", name)
                stack.callback(run, "ip", "netns", "del", name)
            run(
                "ip", "link", "add", wires[0], "netns", here, "type", "veth", "peer", wires[1], "netns", there
            )
        except subprocess.CalledProcessError as error:
            pytest.skip(f"no network namespaces here: {error.stderr.strip()}")
        for name, wire, address in ((here, wires[0], DAEMON), (there, wires[1], ATTACKER)):
            run("ip", "-n", name, "addr", "add", f"{address}/24", "dev", wire)
            for link in ("lo", wire):
                run("ip", "-n", name, "link", "set", link, "up", "multicast", "on")
            run("ip", "-n", name, "route", "add", "224.0.0.0/4", "dev", wire)
        yield here, there


@pytest.fixture(scope="module")
def computers() -> Iterator[tuple[str, str]]:
    """Two for all tests."""
    with two_computers("a") as names:
        yield names


@pytest.fixture
def fresh_computers() -> Iterator[tuple[str, str]]:
    """Two that nobody else runs on."""
    with two_computers("b") as names:
        yield names


class Child:
    """``zenoh_attacks.py``, running in a namespace."""

    def __init__(self, namespace: str, what: str, given: Any) -> None:
        command = [
            "ip",
            "netns",
            "exec",
            namespace,
            sys.executable,
            zenoh_attacks.__file__,
            what,
            json.dumps(given),
        ]
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
        )

    def read(self, deadline_s: float = DEADLINE_S) -> Any:
        assert self.process.stdout is not None
        with selectors.DefaultSelector() as selector:
            selector.register(self.process.stdout, selectors.EVENT_READ)
            assert selector.select(deadline_s), f"nothing within {deadline_s} s"
        line = self.process.stdout.readline()
        assert line, f"it ended with {self.process.wait(DEADLINE_S)}"
        return json.loads(line)

    def ask(self, deadline_s: float = DEADLINE_S) -> Any:
        assert self.process.stdin is not None
        self.process.stdin.write("report\n")
        return self.read(deadline_s)

    def end(self) -> None:
        try:
            self.process.communicate(timeout=DEADLINE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise


@contextmanager
def child(namespace: str, what: str, given: Any) -> Iterator[Child]:
    running = Child(namespace, what, given)
    try:
        yield running
    finally:
        running.end()


class Lan:
    """A daemon that listens on the wire, and those who try."""

    def __init__(self, there: str, daemon: Child, endpoint: str) -> None:
        self.there, self.daemon, self.endpoint = there, daemon, endpoint

    def tried(
        self, config: Mapping[str, Any] | str, user: str | None = None, secret: str | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """What an attacker got, and what the daemon heard and sees after it."""
        with child(self.there, "attack", {"config": config, "user": user, "secret": secret}) as attacker:
            return attacker.read(), self.daemon.ask()


@contextmanager
def lan(computers: tuple[str, str], options: dict[str, Any], endpoint: str) -> Iterator[Lan]:
    with child(computers[0], "serve", options) as daemon:
        assert daemon.read() == {"ready": True}
        yield Lan(computers[1], daemon, endpoint)


PASSWORDS = {name: secrets.token_urlsafe(24) for name in USERS}


@pytest.fixture(scope="module")
def by_password(computers: tuple[str, str], tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lan]:
    path = tmp_path_factory.mktemp("users") / "users"
    path.touch(0o600)
    path.write_text(
        "".join(f"{name}:{role.name.lower()}:{PASSWORDS[name]}\n" for name, role in USERS.items())
    )
    endpoint = f"tcp/{DAEMON}:7447"
    with lan(computers, {"listen": [endpoint], "users": str(path)}, endpoint) as lan_now:
        yield lan_now


def assert_rights(role: Role, user: str, result: dict[str, Any], report: dict[str, Any]) -> None:
    """Exactly what a role may, and nothing beside it."""
    commands = (*(COMMANDS if role >= Role.OPERATOR else ()), *(FAULTS if role >= Role.ADMIN else ()))
    assert result["opened"]
    assert result["answered"] == [*READ, "querier"]
    assert result["narrow"] == sorted(TOLD)
    assert result["wide"] == []
    assert result["alive"] == result["asked_alive"] == [ours(LIVE)]
    assert result["admin"] == []
    # A viewer's query with a payload at a parameter passes zenoh, which looks at no payload. The gate gives
    # the name, and the bridge refuses by the role.
    assert result["commanded"] == list(commands or COMMANDS[1:])

    heard = [tuple(each) for each in report["heard"]]
    expected = [("put", key, user) for key in commands]
    if role >= Role.OPERATOR:
        expected += [
            ("put", COMMANDS[0], "rejected: the command is not signed"),
            ("put", COMMANDS[0], user),
            ("put", COMMANDS[0], "rejected: the signature was used before"),
            ("put", "axis/m1/cmd/publisher", user),
        ]
    expected += [("query", key, "") for key in (*READ, "axis/m1/param/querier")]
    expected += [("query", key, user) for key in commands or COMMANDS[1:]]
    assert sorted(heard) == sorted(expected)
    assert_untouched(report)


def assert_untouched(report: dict[str, Any]) -> None:
    assert report["alive"] == [ours(LIVE)]
    assert report["answers"] == ["genuine"]
    assert report["peers"] == 0


def assert_refused(tried: tuple[dict[str, Any], dict[str, Any]]) -> None:
    result, report = tried
    assert result["opened"] is False, result
    assert report["heard"] == []
    assert_untouched(report)


def assert_let_in_for_nothing(tried: tuple[dict[str, Any], dict[str, Any]]) -> None:
    result, report = tried
    assert (result["opened"], result["links"]) == (True, 1)
    for what in ("answered", "commanded", "narrow", "wide", "alive", "asked_alive", "admin"):
        assert result[what] == [], what
    assert report["heard"] == []
    assert_untouched(report)


@pytest.mark.parametrize("user", USERS)
def test_a_password_gives_the_rights_of_its_role(by_password: Lan, user: str) -> None:
    config = client_config([by_password.endpoint], user, PASSWORDS[user])
    assert_rights(USERS[user], user, *by_password.tried(config, user, PASSWORDS[user]))


@pytest.mark.parametrize(
    ("user", "secret"),
    [
        (None, None),
        ("opa", "a-wrong-password"),
        ("opa", "the-viewers"),
        ("eve", "a-wrong-password"),
        ("", ""),
    ],
    ids=["stranger", "wrong-password", "another's", "unknown", "empty"],
)
def test_without_a_password_nobody_comes_in(by_password: Lan, user: str | None, secret: str | None) -> None:
    secret = PASSWORDS["vic"] if secret == "the-viewers" else secret
    assert_refused(by_password.tried(client_config([by_password.endpoint], user, secret), user, secret))


@pytest.mark.parametrize("mode", ["peer", "router"])
def test_without_a_password_no_peer_and_no_router_either(by_password: Lan, mode: str) -> None:
    config = {
        "mode": mode,
        "connect/endpoints": [by_password.endpoint],
        "listen/endpoints": [f"tcp/{ATTACKER}:7450"],
    }
    limits = {"connect/timeout_ms": 2000, "connect/exit_on_failure": True}
    assert_refused(by_password.tried(config | limits))


@pytest.mark.parametrize("mode", ["peer", "router"])
def test_a_viewer_that_says_it_is_a_peer_or_router_may_no_more(by_password: Lan, mode: str) -> None:
    config = client_config([by_password.endpoint], "vic", PASSWORDS["vic"]) | {
        "mode": mode,
        "listen/endpoints": [f"tcp/{ATTACKER}:7450"],
    }
    result, report = by_password.tried(config, "vic", PASSWORDS["vic"])
    assert [each for each in report["heard"] if each[0] != "query" or each[1] in (*FAULTS, COMMANDS[0])] == []
    assert set(result["narrow"]) <= set(TOLD)
    assert (result["wide"], result["admin"]) == ([], [])
    assert report["answers"] == ["genuine"]
    assert report["alive"] == [ours(LIVE)]


def test_a_peer_of_the_lan_with_zenohs_own_configuration_finds_nobody(by_password: Lan) -> None:
    result, report = by_password.tried({"mode": "peer"})
    assert (result["opened"], result["links"]) == (True, 0)
    for what in ("answered", "commanded", "narrow", "wide", "alive", "asked_alive", "admin"):
        assert result[what] == [], what
    assert report["heard"] == []
    assert_untouched(report)


def test_what_these_attacks_do_to_a_daemon_that_is_open(computers: tuple[str, str]) -> None:
    """With ``insecure: true`` all of them succeed: otherwise nothing above would say anything."""
    endpoint = f"tcp/{DAEMON}:7450"
    with lan(computers, {"listen": [endpoint], "insecure": True}, endpoint) as lan_now:
        result, report = lan_now.tried(client_config([endpoint]))
    assert result["answered"] == [*READ, "**", "other", "querier"]
    assert result["commanded"] == [*COMMANDS, *FAULTS]
    assert set(result["narrow"]) == {*TOLD, UNTOLD}
    assert set(result["wide"]) == {ours(key) for key in (*TOLD, UNTOLD, LIVE) if key != "sim/clock"}
    heard = {(what, key) for what, key, _ in report["heard"]}
    for key in (*COMMANDS, *FAULTS, *NEVER):
        assert {("put", key), ("delete", key)} <= heard
    assert set(report["alive"]) == {ours(LIVE), ours("@live/axis/forged")}
    assert set(report["answers"]) == {"genuine", "forged"}


# ---- certificates ----


class Certified(Lan):
    """The same with certificates. ``site`` is the folder of its keys."""

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


# ---- with no options at all ----


def multicast_of(computers: tuple[str, str], what: str, given: Any, for_s: float) -> tuple[int, list[str]]:
    """Frames to groups that reach the other computer from the start of a session on, and its sockets."""
    with child(computers[1], "count", for_s) as counting:
        assert counting.read() == {"ready": True}
        with child(computers[0], what, given) as session:
            assert session.read() == {"ready": True}
            open_sockets = session.ask()["sockets"] if what == "serve" else []
            return counting.ask(for_s + DEADLINE_S)["count"], open_sockets


def test_by_default_a_daemon_is_heard_on_its_own_computer_only(fresh_computers: tuple[str, str]) -> None:
    count, open_sockets = multicast_of(fresh_computers, "serve", {}, 3.0)
    assert (count, open_sockets) == (0, ["tcp 0100007F:1D17"]), "127.0.0.1:7447 and nothing else"


def test_zenohs_own_configuration_would_be_noticed(fresh_computers: tuple[str, str]) -> None:
    assert multicast_of(fresh_computers, "open", None, 3.0)[0] > 0
