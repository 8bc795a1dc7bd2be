"""Two computers, as network namespaces with a wire between them: on one a daemon's session, on the other who
tries. Each is a process of its own. Needs root and iproute2.

The daemon's session is what the bridge opens, with stand-ins behind it that note what reaches them: on the
commands' keys with what the gate says to it.
"""

import json
import os
import re
import secrets
import selectors
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
import zenoh

from bridges.zenoh.options import Options, TlsOptions
from bridges.zenoh.security import Gate, Rejected, client_config, made, open_session, read_users
from bridges.zenoh.site_keys import Site, make_site
from hil.vocab.signature import signed
from hil.vocab.verbs import Role

DAEMON, ATTACKER = "10.213.0.1", "10.213.0.2"
DEADLINE_S = 20.0
LIVE = "@live/daemon"
READ = (
    "axis/m1/state",
    "axis/*/state",
    "axis/m1/param/pKp",
    "segment/s/stats",
    "sim/clock",
    "verbs/m1",
    "layout",
)
COMMANDS = ("axis/m1/cmd/go", "axis/m1/param/pKp")
FAULTS = ("axis/m1/fault", "segment/s/fault")
NEVER = ("axis/m1/state", "sim/clock", "segment/s/packets", "port/p/tx", "verbs/m1", "layout", "other")
TOLD = ("axis/m1/state", "segment/s/packets", "port/p/rx", "sim/clock")
UNTOLD = "axis/m1/cmd/echo"
"""What the daemon's side puts, but clients do not get: it stands for a command of another client."""
USERS = {"vic": Role.VIEWER, "opa": Role.OPERATOR, "ada": Role.ADMIN}


# ---- what runs in the namespaces ----


def ours(key: str) -> str:
    return f"hil/b/{key}"


class StandIn:
    """The daemon's side of the session."""

    def __init__(self, options: Options) -> None:
        self.session, self.gate = open_session(options, "b")
        self.heard: list[list[str]] = []
        self.stop = threading.Event()
        remote = zenoh.Locality.REMOTE
        self.entities = [
            self.session.declare_subscriber(ours("**"), self.on_put, allowed_origin=remote),
            self.session.declare_queryable(ours("**"), self.on_query, complete=True),
            self.session.liveliness().declare_token(ours(LIVE)),
        ]
        self.teller = threading.Thread(target=self.tell)
        self.teller.start()

    def tell(self) -> None:
        while not self.stop.wait(0.02):
            for key in (UNTOLD, *TOLD):
                self.session.put(ours(key), b"genuine")

    def note(self, what: str, key: str, payload: Any, attachment: Any) -> None:
        who = ""
        if re.search("/(cmd|param|fault)", key) and (payload or what != "query"):
            text = attachment.to_bytes() if attachment else None
            who = verdict(self.gate, text, key, payload.to_bytes() if payload else b"")
        self.heard.append([what, key.removeprefix(ours("")), who])

    def on_put(self, sample: zenoh.Sample) -> None:
        what = "put" if sample.kind == zenoh.SampleKind.PUT else "delete"
        self.note(what, str(sample.key_expr), sample.payload, sample.attachment)

    def on_query(self, query: zenoh.Query) -> None:
        key = str(query.key_expr)
        self.note("query", key, query.payload, query.attachment)
        query.reply(ours("axis/m1/state") if "*" in key else key, b"genuine")
        query.drop()

    def settled(self) -> list[list[str]]:
        """What was heard, once nothing more comes: callbacks have threads of their own."""
        heard: list[list[str]] | None = None
        while heard is None or heard != self.heard:
            heard = list(self.heard)
            self.stop.wait(0.1)
        return heard

    def report(self) -> dict[str, Any]:
        """What was heard since the last one, and what this side sees of others."""
        heard = self.settled()
        live = [str(each.ok.key_expr) for each in self.session.liveliness().get("**/@live/**") if each.ok]
        answers = self.session.get(ours("axis/m1/state"), consolidation=zenoh.ConsolidationMode.NONE)
        genuine = [each.ok.payload.to_string() for each in answers if each.ok]
        self.heard.clear()
        return {
            "heard": heard,
            "alive": live,
            "answers": genuine,
            "peers": len(self.session.info.peers_zid()),
            "sockets": sockets(),
        }

    def close(self) -> None:
        self.stop.set()
        self.teller.join()
        self.session.close()


def verdict(gate: Gate | None, attachment: bytes | None, key: str, payload: bytes) -> str:
    if gate is None:
        return "no gate"
    try:
        return gate.check(attachment, key, payload, time.time_ns()).name
    except Rejected as rejected:
        return "rejected: " + re.split("[:;]", str(rejected))[0]


def sockets() -> list[str]:
    """Local addresses in this namespace that TCP listens on or that UDP is bound to, in hexadecimal."""
    found = []
    for kind, state in (("tcp", "0A"), ("tcp6", "0A"), ("udp", "07"), ("udp6", "07")):
        path = Path(f"/proc/self/net/{kind}")
        for line in path.read_text().splitlines()[1:] if path.exists() else []:
            fields = line.split()
            if fields[3] == state:
                found.append(f"{kind} {fields[1]}")
    return found


def serve(options: Options) -> None:
    """Until its input ends; each line of it is answered by a report."""
    stand_in = StandIn(options)
    say({"ready": True})
    for _ in sys.stdin:
        say(stand_in.report())
    stand_in.close()


def opened(config: Mapping[str, Any] | str) -> Any:
    """A session of a configuration, or of the path of a file with one."""
    return zenoh.open(zenoh.Config.from_file(config) if isinstance(config, str) else made(config))


def attack(config: Mapping[str, Any] | str, user: str | None, secret: str | None) -> None:
    """Try everything, say what came of it, and stay until the input ends."""
    try:
        session = opened(config)
    except zenoh.ZError as error:
        say({"opened": False, "why": str(error).partition(" at /")[0]})
        return
    with session:
        heard = {"narrow": set[str](), "alive": set[str]()}
        told = threading.Semaphore(0)

        def narrow(sample: zenoh.Sample) -> None:
            heard["narrow"].add(str(sample.key_expr).removeprefix(ours("")))
            told.release()

        remote = zenoh.Locality.REMOTE
        alive = session.liveliness()
        kept = [
            session.declare_subscriber(ours("**"), narrow, allowed_origin=remote),
            alive.declare_subscriber(
                ours("@live/**"), lambda sample: heard["alive"].add(str(sample.key_expr)), history=True
            ),
            session.declare_queryable(ours("axis/m1/state"), lambda query: forge(query), complete=True),
            alive.declare_token(ours("@live/axis/forged")),
        ]

        def sign(key: str, payload: bytes) -> bytes | None:
            if user is None or secret is None:
                return None
            return signed(user, secret, key, payload, time.time_ns(), secrets.token_hex(8))

        def ask(key: str, payload: bytes | None = None) -> int:
            replies = session.get(
                ours(key),
                payload=payload,
                attachment=sign(ours(key), payload or b""),
                target=zenoh.QueryTarget.ALL,
                consolidation=zenoh.ConsolidationMode.NONE,  # beside its own forged answer
                timeout=3,
            )
            return sum(
                reply.ok is not None and reply.ok.payload.to_bytes() == b"genuine" for reply in replies
            )

        for key in (*COMMANDS, *FAULTS, *NEVER, LIVE):
            session.put(ours(key), b"evil", attachment=sign(ours(key), b"evil"))
            session.delete(ours(key))
        session.put(ours(COMMANDS[0]), b"unsigned")
        again = sign(ours(COMMANDS[0]), b"again")
        for _ in range(2):
            session.put(ours(COMMANDS[0]), b"again", attachment=again)
        publisher = session.declare_publisher(ours("axis/m1/cmd/publisher"))
        publisher.put(b"evil", attachment=sign(ours("axis/m1/cmd/publisher"), b"evil"))
        session.put("@/*/router/config/access_control/enabled", b"false")
        answered = [key for key in (*READ, "**", "other") if ask(key)]
        commanded = [key for key in (*COMMANDS, *FAULTS) if ask(key, b"1")]
        asked_alive = [str(reply.ok.key_expr) for reply in alive.get(ours("@live/**"), timeout=3) if reply.ok]
        own = str(session.zid())
        admin = [str(reply.ok.key_expr) for reply in session.get("@/**", timeout=3) if reply.ok]
        for _ in range(3 * len(TOLD)):
            if not told.acquire(timeout=2.0 if answered else 0.2):
                break
        links = len(list(session.info.links()))
        wide = listen_wide(config)
        mine = {ours("@live/axis/forged")}
        say(
            {
                "opened": True,
                "links": links,
                "answered": answered,
                "commanded": commanded,
                "narrow": sorted(heard["narrow"]),
                "wide": wide,
                "alive": sorted(heard["alive"] - mine),
                "asked_alive": sorted(set(asked_alive) - mine),
                "admin": [key for key in admin if own not in key],
            }
        )
        sys.stdin.read()
        for entity in kept:
            entity.undeclare()


def forge(query: zenoh.Query) -> None:
    query.reply(str(query.key_expr), b"forged")
    query.drop()


def listen_wide(config: Mapping[str, Any] | str) -> list[str]:
    """What somebody gets who asks for more than the bench's keys. In a session of its own, for what one
    subscriber of a session may have, its others see too."""
    heard: set[str] = set()
    clocks = threading.Semaphore(0)

    def on_any(sample: zenoh.Sample) -> None:
        heard.add(str(sample.key_expr))

    with suppress(zenoh.ZError):
        session = opened(config)
        with session:
            session.declare_subscriber("**", on_any)
            session.declare_subscriber("hil/**", on_any)
            session.liveliness().declare_subscriber("hil/*/@live/**", on_any, history=True)
            replies = session.liveliness().get("hil/*/@live/**", timeout=3)
            heard |= {str(reply.ok.key_expr) for reply in replies if reply.ok}
            session.declare_subscriber(ours("sim/clock"), lambda _: clocks.release())
            for _ in range(5):
                if not clocks.acquire(timeout=1.0):
                    break
    return sorted(heard - {ours("sim/clock"), ours("@live/axis/forged")})


def count_multicast(for_s: float) -> int:
    """IPv4 frames to groups that pass this namespace's interfaces in a time."""
    import socket

    count, until_s = 0, time.monotonic() + for_s
    with socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(0x0003)) as raw:
        say({"ready": True})
        while (left_s := until_s - time.monotonic()) > 0:
            raw.settimeout(left_s)
            with suppress(TimeoutError):
                packet = raw.recv(65536)
                count += len(packet) > 16 and packet[0] >> 4 == 4 and packet[16] >> 4 == 14
    return count


def say(what: Mapping[str, Any]) -> None:
    print(json.dumps(what), flush=True)


def main(what: str, given: Any) -> None:
    if what == "serve":
        serve(Options.model_validate_json(json.dumps(given)))
    elif what == "attack":
        attack(given["config"], given["user"], given["secret"])
    elif what == "open":
        session: Any = zenoh.open(zenoh.Config())
        say({"ready": True})
        sys.stdin.read()
        session.close()
    elif what == "count":
        say({"count": count_multicast(given)})


# ---- the tests ----


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
            for name, wire, address in ((here, wires[0], DAEMON), (there, wires[1], ATTACKER)):
                run("ip", "-n", name, "addr", "add", f"{address}/24", "dev", wire)
                for link in ("lo", wire):
                    run("ip", "-n", name, "link", "set", link, "up", "multicast", "on")
                run("ip", "-n", name, "route", "add", "224.0.0.0/4", "dev", wire)
        except subprocess.CalledProcessError as error:
            pytest.skip(f"no network namespaces here: {error.stderr.strip()}")
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
    """This file, running in a namespace."""

    def __init__(self, namespace: str, what: str, given: Any) -> None:
        command = ["ip", "netns", "exec", namespace, sys.executable, __file__, what, json.dumps(given)]
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

    def ask(self) -> Any:
        assert self.process.stdin is not None
        self.process.stdin.write("report\n")
        return self.read()

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
    assert result["answered"] == list(READ)
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
    expected += [("query", key, "") for key in READ]
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
    assert result["answered"] == [*READ, "**", "other"]
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
            return counting.read(for_s + DEADLINE_S)["count"], open_sockets


def test_by_default_a_daemon_is_heard_on_its_own_computer_only(fresh_computers: tuple[str, str]) -> None:
    count, open_sockets = multicast_of(fresh_computers, "serve", {}, 3.0)
    assert (count, open_sockets) == (0, ["tcp 0100007F:1D17"]), "127.0.0.1:7447 and nothing else"


def test_zenohs_own_configuration_would_be_noticed(fresh_computers: tuple[str, str]) -> None:
    assert multicast_of(fresh_computers, "open", None, 3.0)[0] > 0


if __name__ == "__main__":
    main(sys.argv[1], json.loads(sys.argv[2]))
