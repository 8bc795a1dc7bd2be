"""Benches behind a router, with options together that are tried alone elsewhere: users, TLS, roles, runs.

Everything is on loopback: what matters here is who may do what, not the network. ``tests/bench_sites.py`` has
computers of their own.
"""

import json
import subprocess
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
import zenoh
from bench_sites import FAR, run, state_of
from e2e_support import HIL, PATIENCE_S, Place, Server, config, free_port, until
from plain_zenoh import NONE, QUIET

from bridges.zenoh.site_keys import Site, make_site
from hil.client import Bench, ClientError, CommandError, connect_sync
from hil.client.lab import Lab
from hil.client.link import Credentials
from hil.vocab.verbs import Role

USERS = {"vera": Role.VIEWER, "otto": Role.OPERATOR, "anna": Role.ADMIN}
SAC = {"profile": "sac", "flash": {}}


@dataclass
class Setting:
    """Router, how it is reached, and what its benches are given. ``has_users``: the benches have; ``asks``:
    so has the router. ``prefixes``: words before the commands of ``router`` and of benches."""

    place: Place
    folder: Path
    door: str
    has_tls: bool
    has_users: bool
    asks: bool
    prefixes: Mapping[str, Sequence[str]] = field(default_factory=dict)
    router: subprocess.Popen[str] | None = None

    def start_router(self) -> None:
        command = [*self.prefixes.get("router", ()), HIL, "zenoh", "router", "--listen", self.door]
        if not self.has_tls and self.prefixes:  # reached from other computers
            command += ["--insecure"]
        if self.has_tls:
            for option, name in (("ca", "ca.pem"), ("certificate", "router.pem"), ("key", "router.key")):
                command += [f"--{option}", str(self.folder / name)]
        if self.asks:
            command += ["--users", str(self.folder / "users")]
        self.router = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert self.router.stdout
        assert "Ctrl-C ends it" in self.router.stdout.readline()

    def end_router(self) -> None:
        if self.router:
            self.router.kill()
            self.router.communicate(timeout=PATIENCE_S)

    def bridge(self, **more: Any) -> dict[str, Any]:
        options: dict[str, Any] = {"listen": [], "connect": [self.door]}
        if self.has_users:
            options["users"] = str(self.folder / "users")
        if self.has_tls:
            files = {"ca": "ca.pem", "certificate": "daemon.pem", "key": "daemon.key"}
            options["tls"] = {name: str(self.folder / file) for name, file in files.items()}
        return options | more

    def launch(self, bench: str, **more: Any) -> Server:
        text = config(bench, 1, {"m1": {}, "s1": SAC}, bridges={"zenoh": self.bridge(**more)})
        return self.place.launch(text, bench=bench, prefix=self.prefixes.get(bench, ()))

    def who(self, user: str) -> tuple[str, str]:
        line = next(
            each for each in (self.folder / "users").read_text().splitlines() if each.startswith(user)
        )
        return user, line.split(":", 2)[2]

    @contextmanager
    def client(self, user: str, bench: str = "mill") -> Iterator[Bench]:
        """Client of a user, as the documents say: by his file with TLS, else by name and password."""
        if self.has_tls:
            with connect_sync(bench, config=self.folder / f"clients/{user}/zenoh.json") as opened:
                yield opened
        else:
            name, password = self.who(user) if self.has_users else (None, "")
            with connect_sync(bench, self.door, user=name, password=password) as opened:
                yield opened

    def session(self, user: str) -> zenoh.Session:
        """A program of a user that knows zenoh and nothing else."""
        values: dict[str, Any] = {**QUIET, "mode": "client", "connect/endpoints": [self.door]}
        if self.has_tls:
            made = zenoh.Config.from_file(self.folder / f"clients/{user}/zenoh.json")
            values = {}
        else:
            made = zenoh.Config()
            if self.asks:
                name, password = self.who(user)
                values["transport/auth/usrpwd"] = {"user": name, "password": password}
        for path, value in values.items():
            made.insert_json5(path, json.dumps(value))
        return zenoh.open(made)


@contextmanager
def setting(
    place: Place,
    *,
    tls: bool,
    users: bool,
    asks: bool,
    host: str = "127.0.0.1",
    prefixes: Mapping[str, Sequence[str]] | None = None,
) -> Iterator[Setting]:
    """Router at ``host``, and how benches are started there."""
    port = free_port()
    folder = place.folder / "site"
    site = Site("mill", [], list(USERS.items()), datetime.now(UTC), port=port, more=["lathe"], routers=[host])
    make_site(folder, site)
    door = f"{'tls' if tls else 'tcp'}/{host}:{port}"
    made = Setting(place, folder, door, tls, users, asks, prefixes or {})
    made.start_router()
    try:
        yield made
    finally:
        made.end_router()


WAYS = {
    "nobody-asked": {"tls": False, "users": False, "asks": False},
    "users-of-benches": {"tls": False, "users": True, "asks": False},
    "users": {"tls": False, "users": True, "asks": True},
    "tls": {"tls": True, "users": True, "asks": True},
}
"""Router and benches: who asks for names, and how."""


def rights(made: Setting, user: str) -> list[str]:
    """What a user can do at the bench behind the router."""
    done = []
    with made.client(user) as client:
        m1 = client.axis("m1")
        assert client.alive() == ["axis/m1", "axis/s1", "daemon"]
        assert m1.state().at_ns > 0
        for name, attempt in (
            ("enable", m1.enable),
            ("pKp", lambda: m1.set_parameter("pKp", 14.0)),
            ("fault", lambda: m1.clear_fault()),
        ):
            try:
                attempt()
            except ClientError:
                continue
            done.append(name)
    return done


MAY = {"vera": [], "otto": ["enable", "pKp"], "anna": ["enable", "pKp", "fault"]}


@pytest.mark.thorough
@pytest.mark.parametrize("way", WAYS)
def test_roles_runs_and_restarts_behind_a_router(place: Place, way: str) -> None:
    with setting(place, **WAYS[way]) as made:
        roles_runs_and_restarts(made)


def roles_runs_and_restarts(made: Setting) -> None:
    """Try what each user may, runs over two benches, and that all go on after router and bench were away."""
    mill, lathe = made.launch("mill"), made.launch("lathe")
    for server in (mill, lathe):
        server.started().ready().ask("do", device="m1", name="enable", parameters={})
    for user in USERS:
        assert rights(made, user) == (MAY[user] if made.has_users else MAY["anna"]), user

    # A run over both, of whom may; then one that is told to stop where it is led.
    until(lambda: [row["bench"] for row in mill.ask("benches")] == ["lathe"], "a sight of the lathe")
    move = {"move": {"m1": 30.0, "lathe/m1": -20.0}}
    with made.client("otto") as otto:
        otto.submit(run("together", move))
        until(lambda: state_of(mill, "together") in ("done", "failed"), "the run's end")
        assert state_of(mill, "together") == "done", mill.ask("runs", name="together")
        otto.submit(run("far", FAR))
        until(lambda: state_of(mill, "far") == "running", "the next run")
        otto.cancel("far")
        until(lambda: state_of(mill, "far") == "cancelled", "its end")

        # The router goes and comes back: benches and an open client join again.
        made.end_router()
        made.start_router()

        def again() -> bool:
            try:
                return bool(otto.axis("m1").enable().effective_at_ns)
            except ClientError:
                return False

        until(again, "the router's return")

        # A bench is killed and comes back under its name.
        lathe.kill()
        lathe = made.launch("lathe").started().ready()
        until(lambda: "lathe" in [row["bench"] for row in mill.ask("benches")], "the lathe's return")
        assert lathe.ask("health")["problems"] == [] or "name" not in str(lathe.ask("health"))
    with made.client("otto", "lathe") as other:
        assert other.axis("m1").enable().effective_at_ns


@pytest.mark.thorough
@pytest.mark.parametrize("way", ["users", "tls"])
def test_a_viewer_behind_a_router_cannot_speak_for_a_bench(place: Place, way: str) -> None:
    with setting(place, **WAYS[way]) as made:
        mill = made.launch("mill").started().ready()
        vera, otto = made.session("vera"), made.session("otto")
        heard: list[str] = []
        state = "hil/mill/axis/m1/state"
        subscriber = otto.declare_subscriber(state, lambda sample: heard.append(sample.payload.to_string()))
        kept = [
            vera.declare_queryable("hil/mill/**", lambda query: query.reply(state, "forged"), complete=True),
            vera.declare_queryable("hil/lathe/**", lambda query: query.reply(query.key_expr, "forged")),
            *(vera.liveliness().declare_token(f"hil/{name}/@live/daemon") for name in ("lathe", "ghost")),
            vera.liveliness().declare_token("hil/mill/@one/forged"),
        ]
        until(lambda: heard, "states")
        for key in ("axis/m1/state", "sim/health", "sim/rejected", "run/r/state"):
            for bench in ("mill", "lathe"):
                for who in (vera, otto):
                    who.put(f"hil/{bench}/{key}", "forged", allowed_destination=zenoh.Locality.REMOTE)
        seen = len(heard)
        until(lambda: len(heard) > seen + 5, "more states")
        assert not [text for text in heard if "forged" in text]
        for key in (state, "hil/lathe/axis/m1/state", "hil/lathe/sim/health"):
            replies = [each.ok for each in otto.get(key, consolidation=NONE, timeout=5) if each.ok]
            assert len(replies) == (key == state)
            assert not [each for each in replies if each.payload.to_bytes() == b"forged"]
        tokens = [str(each.ok.key_expr) for each in otto.liveliness().get("hil/*/@live/daemon") if each.ok]
        assert tokens == ["hil/mill/@live/daemon"]
        with made.client("otto") as client:
            assert client.axis("m1").enable().effective_at_ns
        with pytest.raises(ClientError, match="no bench 'lathe'"):
            connect_sync("lathe", config=made.folder / "clients/otto/zenoh.json", timeout_s=0.5) if (
                made.has_tls
            ) else connect_sync("lathe", made.door, user="otto", password=made.who("otto")[1], timeout_s=0.5)
        assert mill.ask("health")["state"] != "failed"
        subscriber.undeclare()
        for each in kept:
            each.undeclare()
        for session in (vera, otto):
            session.close()  # type: ignore[no-untyped-call]


@pytest.mark.thorough
def test_strangers_and_benches_that_are_not_in_the_file_are_kept_out(place: Place) -> None:
    with setting(place, **WAYS["users"]) as made:
        with pytest.raises(ClientError, match="lets in users alone"):
            connect_sync("mill", made.door, timeout_s=0.5)
        with pytest.raises(ClientError, match="does not let in otto"):
            connect_sync("mill", made.door, user="otto", password="not-the-password", timeout_s=0.5)
        saw = made.launch("saw").started().ready()
        assert saw.ask("status")["bridges"]["zenoh"]["links"] == 0


@pytest.mark.thorough
@pytest.mark.parametrize("way", ["nobody-asked", "tls"])
def test_the_second_bench_of_a_name_stands_aside_until_the_first_has_gone(place: Place, way: str) -> None:
    with setting(place, **WAYS[way]) as made, Place() as elsewhere:
        first = made.launch("mill").started().ready()
        second = Setting(elsewhere, made.folder, made.door, made.has_tls, made.has_users, made.asks)
        mill2 = second.launch("mill").started().ready()

        def named(server: Server) -> list[dict[str, Any]]:
            return [each for each in server.ask("health")["problems"] if each["kind"] == "name"]

        (problem,) = named(mill2)
        assert "another bench mill is joined" in problem["what"]
        (row,) = mill2.ask("benches")
        assert row["bench"] == "mill"
        assert "another bench mill" in row["why"]
        assert named(first) == []
        first.ask("do", device="m1", name="enable", parameters={})
        with made.client("otto") as client:
            assert client.axis("m1").enable().effective_at_ns
        assert first.ask("status")["bridges"]["zenoh"]["commands"] == 1
        first.kill()
        until(lambda: not named(mill2), "the name to be free")
        with made.client("otto") as client:
            until(lambda: client.axis("m1").state().at_ns > 0, "the second one")


def test_two_that_meet_later_say_so_and_refuse_commands_but_not_a_stop(place: Place) -> None:
    """Two networks become one: each bench was alone when it joined."""
    with setting(place, **WAYS["nobody-asked"]) as made, Place() as elsewhere:
        port = free_port()
        own = made.launch("mill", listen=[f"tcp/127.0.0.1:{port}"], connect=[]).started().ready()
        away = Setting(elsewhere, made.folder, made.door, False, False, False)
        other = away.launch("mill", connect=[made.door]).started().ready()
        assert "name" not in [each["kind"] for each in other.ask("health")["problems"]]
        bridge: dict[str, Any] = {**QUIET, "mode": "router"}
        bridge["connect/endpoints"] = [made.door, f"tcp/127.0.0.1:{port}"]
        joined = zenoh.Config()
        for path, value in bridge.items():
            joined.insert_json5(path, json.dumps(value))
        session = zenoh.open(joined)
        try:
            for server in (own, other):
                until(
                    lambda server=server: "name" in str(server.ask("health")["problems"]),  # type: ignore[misc]
                    "the other to be noticed",
                )
                assert "1 more joined as mill" in server.ask("benches")[0]["why"]
            rejected = [server.ask("status")["bridges"]["zenoh"]["rejected"] for server in (own, other)]
            with pytest.raises(ClientError, match="2 benches are called 'mill'"):
                connect_sync("mill", made.door, timeout_s=5)
            key = "hil/mill/axis/m1/cmd"
            refusal = next(iter(session.get(f"{key}/enable", payload=b"{}", timeout=10)))
            assert refusal.err is not None
            assert json.loads(refusal.err.payload.to_bytes())["code"] == "not_now"
            session.put(f"{key}/stop", b"{}")

            def told() -> list[int]:
                return [server.ask("status")["bridges"]["zenoh"]["rejected"] for server in (own, other)]

            until(lambda: sum(told()) > sum(rejected), "the refusal to be counted")
            before, began_s = sum(told()), time.monotonic()
            until(lambda: time.monotonic() - began_s > 0.5, "half a second")
            assert sum(told()) - before < 5, "each refuses what the other tells"
        finally:
            session.close()  # type: ignore[no-untyped-call]
        until(lambda: "name" not in str(own.ask("health")["problems"]), "the other to be gone")
        jump = pytest.raises(CommandError, match="has no 'jump'")
        with connect_sync("mill", f"tcp/127.0.0.1:{port}") as client, jump:
            client.axis("m1").do("jump")


@pytest.mark.thorough
@pytest.mark.parametrize("way", WAYS)
def test_a_stop_of_the_site_is_for_operators_and_benches(place: Place, way: str) -> None:
    with setting(place, **WAYS[way]) as made:
        mill, lathe = (made.launch(name) for name in ("mill", "lathe"))
        for server in (mill, lathe):
            server.started().ready()
        until(lambda: "lathe" in [row["bench"] for row in mill.ask("benches")], "a sight of lathe")

        def stopped(user: str) -> list[tuple[str, str]]:
            file = made.folder / f"clients/{user}/zenoh.json" if made.has_tls else None
            with Lab(
                None if file else made.door, credentials=Credentials(*made.who(user)), config=file
            ) as lab:
                return [(row["bench"], row["state"]) for row in lab.stop(answer_s=3.0)]

        both = [("lathe", "confirmed"), ("mill", "confirmed")]
        until(lambda: stopped("otto") == both, "both")
        rows = mill.ask("stop_site", how="grace", within_s=10.0)["benches"]
        assert [(row["bench"], row["state"], row["why"]) for row in rows] == [
            ("mill", "confirmed", None),
            ("lathe", "confirmed", None),
        ]
        if made.has_users:
            by_viewer = {state for _, state in stopped("vera")}
            assert by_viewer <= {"refused", "silent"}, by_viewer
