"""Members of a site at a router, with real sessions: who gets what through, before and after a new list."""

import json
import secrets
import shutil
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
import zenoh

from bridges.zenoh.bench_session import open_session
from bridges.zenoh.gate import Rejected
from bridges.zenoh.options import Options
from bridges.zenoh.router_process import SiteRouter, default_listen
from bridges.zenoh.site_authority import SiteAuthority, new_site
from bridges.zenoh.site_folder import SiteFolder
from bridges.zenoh.site_gate import SiteGate
from bridges.zenoh.site_list import read_grant
from bridges.zenoh.zenoh_config import READINGS_HZ, made, session_config, site_options
from hil.client.link import from_file
from hil.net.signature import KeySigner

pytestmark = pytest.mark.long

PATIENCE_S = 10.0
USERS = {
    "vera": ["viewer"],
    "otto": ["operator@mill", "viewer"],
    "rita": ["operator@rig=press"],
    "anna": ["admin"],
    "nora": [],
}


def now() -> datetime:
    return datetime.now(UTC)


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return int(listener.getsockname()[1])


class StandIn:
    """A bench's session and gate; behind them is nothing but an answer."""

    def __init__(self, folder: Path, name: str) -> None:
        self.folder = SiteFolder(folder, now())
        options = site_options(Options(site=folder), self.folder)
        self.session, gate = open_session(options, name, self.folder)
        assert isinstance(gate, SiteGate)
        self.gate = gate
        token = self.session.liveliness().declare_token(f"hil/{name}/@live/daemon")
        asked = [
            self.session.declare_queryable(f"hil/{name}/axis/*/state", self._answer),
            self.session.declare_queryable(f"hil/{name}/axis/*/cmd/*", self._do),
            self.session.declare_queryable(f"hil/{name}/halt", self._do),
        ]
        self._declared = token, asked

    def _answer(self, query: zenoh.Query) -> None:
        with query:
            query.reply(query.key_expr, b"{}")

    def _do(self, query: zenoh.Query) -> None:
        attachment = query.attachment.to_bytes() if query.attachment else None
        with query:
            try:
                user = self.gate.check(attachment, str(query.key_expr), b"{}", time.time_ns())
            except Rejected as refusal:
                query.reply_err(str(refusal).encode())
            else:
                query.reply(str(self._own_key(query)), user.role.name.encode())

    def _own_key(self, query: zenoh.Query) -> str:
        own = self.folder.own
        assert own
        return str(query.key_expr).replace("*", own.name, 1)

    def take(self, content: bytes) -> None:
        (self.folder.folder / "members").write_bytes(content)
        self.folder.refresh(now())
        self.gate.list_changed()


class Lab:
    """A site on loopback: router, two benches, users."""

    def __init__(self, folder: Path) -> None:
        port = free_port()
        new_site(folder / "lab", "lab", ["127.0.0.1"], port, now(), 1, None)
        self.authority = SiteAuthority(folder / "lab")
        self.authority.add_benches(["mill"], {"rig": "press"}, (), now(), 1)
        self.authority.add_benches(["lathe"], {}, (), now(), 1)
        for name, roles in USERS.items():
            self.authority.add_user(name, [read_grant(role) for role in roles], now(), 1)
        self.there = folder / "there"
        at_router = SiteFolder(self.copied("router"), now())
        assert default_listen(at_router) == [f"tls/0.0.0.0:{port}"]
        self.router_folder, self.port = at_router, port
        self.router = SiteRouter(at_router, [f"tls/127.0.0.1:{port}"])
        self.benches = {name: StandIn(self.copied(name), name) for name in ("mill", "lathe")}

    def copied(self, name: str) -> Path:
        return Path(shutil.copytree(self.authority.place(name), self.there / name, dirs_exist_ok=True))

    def push(self) -> None:
        content = (self.authority.folder / "members").read_bytes()
        for bench in self.benches.values():
            bench.take(content)
        (self.router_folder.folder / "members").write_bytes(content)
        self.router.look(now())

    def close(self) -> None:
        for bench in self.benches.values():
            bench.session.close()  # type: ignore[no-untyped-call]
        self.router.close()

    @contextmanager
    def user(self, name: str) -> Iterator["Client"]:
        entries, _, signer = from_file(self.copied(name) / "zenoh.json")
        assert isinstance(signer, KeySigner)
        with zenoh.open(zenoh.Config.from_json5(json.dumps(entries))) as session:
            yield Client(session, signer)


class Client:
    def __init__(self, session: zenoh.Session, signer: KeySigner) -> None:
        self.session, self.signer = session, signer

    def ask(self, key: str, timeout_s: float = 2.0) -> list[str]:
        """Answers of benches, and refusals with ``!`` before them."""
        time.sleep(1.5 / READINGS_HZ)  # the router drops what comes faster
        attachment = self.signer.signed(key, b"{}", time.time_ns(), secrets.token_hex(8))
        replies = self.session.get(
            key,
            payload=b"{}",
            attachment=attachment,
            timeout=timeout_s,
            consolidation=zenoh.ConsolidationMode.NONE,
        )
        found = []
        for reply in replies:
            if reply.ok:
                found.append(reply.ok.payload.to_string())
            elif reply.err:
                found.append("!" + reply.err.payload.to_string())
        return sorted(found)

    def until(self, key: str, wanted: Callable[[list[str]], bool]) -> list[str]:
        deadline_s = time.monotonic() + PATIENCE_S
        while not wanted(answer := self.ask(key)):
            assert time.monotonic() < deadline_s, answer
            time.sleep(0.02)
        return answer


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    made_lab = Lab(tmp_path_factory.mktemp("lab"))
    try:
        yield made_lab
    finally:
        made_lab.close()


@pytest.mark.parametrize(
    ("user", "sees", "commands"),
    [
        ("vera", "mill lathe", ""),
        ("otto", "mill lathe", "mill:OPERATOR"),
        ("rita", "mill", "mill:OPERATOR"),
        ("anna", "mill lathe", "mill:ADMIN lathe:ADMIN"),
        ("nora", "", ""),
    ],
)
def test_a_user_gets_through_what_the_roles_allow(lab: Lab, user: str, sees: str, commands: str) -> None:
    roles = dict(each.split(":") for each in commands.split())
    with lab.user(user) as client:
        client.until("hil/mill/axis/m1/state", lambda found: bool(found) or "mill" not in sees.split())
        for bench in ("mill", "lathe"):
            assert client.ask(f"hil/{bench}/axis/m1/state") == (["{}"] if bench in sees.split() else [])
            assert client.ask(f"hil/{bench}/axis/m1/cmd/go") == [each for each in [roles.get(bench)] if each]
        stopped = client.ask("hil/*/halt")
        assert [each for each in stopped if each in ("OPERATOR", "ADMIN")] == sorted(roles.values())
        assert all("halt" in each or "no role" in each for each in stopped if each[0] == "!")
        live = client.session.liveliness().get("hil/*/@live/daemon", timeout=2.0)
        assert {str(each.ok.key_expr).split("/")[1] for each in live if each.ok} == {"mill", "lathe"}


def test_nobody_speaks_for_a_bench(lab: Lab) -> None:
    heard: list[str] = []
    with lab.user("vera") as watcher, lab.user("anna") as forger:
        told = watcher.session.declare_subscriber(
            "hil/*/axis/*/state", lambda sample: heard.append(sample.payload.to_string())
        )
        time.sleep(0.2)
        for session, text in (
            (forger.session, "by a user"),
            (lab.benches["lathe"].session, "by another bench"),
            (lab.benches["mill"].session, "by itself"),
        ):
            session.put("hil/mill/axis/m1/state", text)
        deadline_s = time.monotonic() + PATIENCE_S
        while "by itself" not in heard and time.monotonic() < deadline_s:
            time.sleep(0.02)
        told.undeclare()
    assert heard == ["by itself"]


def test_strangers_stay_outside(lab: Lab, tmp_path: Path) -> None:
    other = new_site(tmp_path / "other", "lab", ["127.0.0.1"], lab.port, now(), 1, None)
    other.add_user("anna", [read_grant("admin")], now(), 1)
    lab.authority.add_user("late", [read_grant("admin")], now(), 1)
    lab.authority.make_folder("late", "late", (), now() - timedelta(days=3), 1)
    expired = lab.copied("late")
    mixed = Path(shutil.copytree(other.place("anna"), tmp_path / "mixed"))
    shutil.copy(lab.authority.folder / "ca.pem", mixed / "ca.pem")
    for folder in (other.place("anna"), mixed, expired):
        entries, _, _ = from_file(folder / "zenoh.json")
        config = zenoh.Config.from_json5(json.dumps(entries))
        config.insert_json5("connect/timeout_ms", "300")
        with pytest.raises(zenoh.ZError):
            zenoh.open(config)
    lab.authority.remove(["late"])


def test_a_new_list_counts_at_router_and_benches_without_a_restart(lab: Lab) -> None:
    stop = threading.Event()
    answered_s: list[float] = []
    with lab.user("anna") as anna, lab.user("otto") as otto:
        otto.until("hil/mill/axis/m1/cmd/go", lambda found: found == ["OPERATOR"])

        def ask() -> None:
            while not stop.is_set():
                if anna.ask("hil/mill/axis/m1/cmd/go", 0.5):
                    answered_s.append(time.monotonic())

        thread = threading.Thread(target=ask)
        thread.start()
        try:
            lab.authority.change("otto", [read_grant("viewer"), read_grant("operator@lathe")])
            lab.push()
            otto.until("hil/lathe/axis/m1/cmd/go", lambda found: found == ["OPERATOR"])
            assert otto.ask("hil/mill/axis/m1/cmd/go") == []
            lab.authority.rotate(["otto"], now(), 1, is_stolen=True)
            lab.push()
            anna.until("hil/mill/axis/m1/state", lambda found: found == ["{}"])
            assert otto.ask("hil/lathe/axis/m1/state", 1.0) == []
            with lab.user("otto") as renewed:
                renewed.until("hil/lathe/axis/m1/cmd/go", lambda found: found == ["OPERATOR"])
        finally:
            stop.set()
            thread.join()
    gaps = [later - sooner for sooner, later in pairwise(answered_s)]
    assert max(gaps) < PATIENCE_S / 2, "0.2 s where nothing else runs"


def test_an_old_list_opens_nothing_again(lab: Lab, caplog: pytest.LogCaptureFixture) -> None:
    old = (lab.authority.folder / "members").read_bytes()
    lab.authority.change("vera", [])
    lab.push()
    (lab.router_folder.folder / "members").write_bytes(old)
    lab.router.look(now())
    assert "an older one could give back what was revoked" in caplog.text
    with lab.user("vera") as vera:
        assert vera.ask("hil/mill/axis/m1/state", 0.5) == []
    lab.push()


def test_the_router_takes_a_new_certificate(lab: Lab) -> None:
    lab.authority.rotate(["router"], now(), 2)
    lab.copied("router")
    before = lab.router_folder.version[1]
    lab.router.look(now())
    assert lab.router_folder.version[1] != before
    with lab.user("anna") as anna:
        anna.until("hil/lathe/axis/m1/state", lambda found: found == ["{}"])


def test_a_bench_that_listens_itself(lab: Lab) -> None:
    """A lab without a router: clients connect to the bench."""
    lab.authority.add_benches(["drill"], {}, ["127.0.0.1"], now(), 1)
    folder = SiteFolder(lab.copied("drill"), now())
    port = free_port()
    options = site_options(Options(site=folder.folder, listen=[f"tls/127.0.0.1:{port}"]), folder)
    drill: Any = zenoh.open(made(session_config(options, "drill", (), "", folder.list)))
    answered = drill.declare_queryable(
        "hil/drill/axis/*/state", lambda query: query.reply(query.key_expr, b"{}")
    )
    try:
        for user, sees in (("anna", True), ("rita", False)):
            entries, _, _ = from_file(lab.copied(user) / "zenoh.json")
            entries["connect"]["endpoints"] = [f"tls/127.0.0.1:{port}"]
            with zenoh.open(zenoh.Config.from_json5(json.dumps(entries))) as session:
                replies = session.get("hil/drill/axis/m1/state", timeout=1.0)
                assert any(reply.ok for reply in replies) == sees
    finally:
        answered.undeclare()
        drill.close()
