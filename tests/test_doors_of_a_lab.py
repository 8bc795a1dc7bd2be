"""Doors of a lab with real sessions: an inventory of a hundred benches, and refusals that say why."""

import json
import re
import ssl
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import zenoh
from e2e_support import free_port, until
from typer.testing import CliRunner

from bridges.zenoh.not_joined import why_not_joined
from bridges.zenoh.options import Options, TlsOptions
from bridges.zenoh.site_keys import Site, make_site
from bridges.zenoh.users import read_users
from bridges.zenoh.zenoh_config import READINGS_HZ, client_config, opened, password_file, router_config
from hil.cli.framework.command_group import app
from hil.cli.lab.benches_command import lab_view
from hil.client import ClientError, Lab, connect_sync
from hil.net.door_check import Why, why_not
from hil.vocab.bridge_protocol import PROTOCOL_VERSION
from hil.vocab.verbs import Role

pytestmark = pytest.mark.long

ABOUT: dict[str, Any] = {
    **{"version": "0.3.0", "host": "lab1", "config_digest": "00", "protocol": PROTOCOL_VERSION},
    **{"labels": {}, "devices": {}, "lease": None, "runs": [], "commanders": []},
    "health": {"state": "ok", "problems": [], "problems_left_out": 0},
}
BENCHES = 100


class LightBenches:
    """Benches that tell what they are, and do nothing else, at a router of their own."""

    def __init__(self, stack: ExitStack) -> None:
        self._stack = stack
        self._tokens: list[Any] = []
        self.door = f"tcp/127.0.0.1:{free_port()}"
        self._open(router_config([self.door], None, True))

    def _open(self, config: dict[str, Any]) -> zenoh.Session:
        session = opened(config)
        self._stack.callback(session.close)  # type: ignore[arg-type]
        return session

    def join(self, name: str, about: dict[str, Any] | None, *axes: str) -> None:
        """Join a bench. ``about``: None for one of an older version."""
        session = self._open(client_config([self.door]))
        for word in ("daemon", *(f"axis/{axis}" for axis in axes)):
            self._tokens.append(session.liveliness().declare_token(f"hil/{name}/@live/{word}"))
        if about is not None:
            text = json.dumps({"bench": name, **about})
            key = f"hil/{name}/about"
            session.declare_queryable(key, lambda query: query.reply(key, text), complete=True)


@pytest.fixture
def light() -> Iterator[LightBenches]:
    with ExitStack() as stack:
        yield LightBenches(stack)


def rows_of(lab: Lab, told: int) -> list[dict[str, Any]]:
    """Rows of a lab when so many benches tell what they are: a router may hear of one's presence first. It
    drops questions that come faster than ``READINGS_HZ``."""
    rows: list[dict[str, Any]] = []

    def has_all() -> bool:
        rows[:] = lab.benches()
        return sum("host" in row for row in rows) == told

    until(has_all, "a word of all")
    return rows


def test_a_hundred_benches_are_listed_in_half_a_second(light: LightBenches) -> None:
    for number in range(BENCHES):
        light.join(f"b{number}", ABOUT | {"labels": {"rig": "press" if number % 2 else "lift"}}, "m1")
    with Lab(light.door) as lab:
        rows_of(lab, BENCHES)
        took_s = []
        for _ in range(3):
            time.sleep(2 / READINGS_HZ)
            begin_s = time.monotonic()
            rows = lab.benches({"rig": "press"})
            took_s.append(time.monotonic() - begin_s)
    assert len(rows) == BENCHES // 2
    assert min(took_s) < 0.5


def test_one_bench_of_a_lab_is_asked_by_its_name(light: LightBenches) -> None:
    light.join("mill", ABOUT)
    light.join("lathe", ABOUT | {"host": "lab2"})
    with Lab(light.door) as lab:
        rows_of(lab, 2)
        time.sleep(2 / READINGS_HZ)
        assert lab.ask("lathe", "about")["host"] == "lab2"
        for name, why in (("*", "is no name of a bench"), ("press", "nobody answers for the bench 'press'")):
            with pytest.raises(ClientError, match=re.escape(why)):
                lab.ask(name, "about", answer_s=0.3)
        light.join("mill", ABOUT | {"host": "lab3"})
        rows_of(lab, 3)
        time.sleep(2 / READINGS_HZ)
        with pytest.raises(ClientError, match="2 benches are called 'mill'"):
            lab.ask("mill", "about")
        lease = ["lease", "--connect", light.door]
        said = CliRunner().invoke(app, [*lease, "--bench", "press"])
        assert (said.exit_code, "nobody answers for the bench 'press'" in said.output) == (1, True)
        said = CliRunner().invoke(app, lease)
        assert (said.exit_code, "Name it with --bench" in said.output) == (2, True)


def test_two_of_a_name_and_one_of_an_older_version_are_listed(light: LightBenches) -> None:
    light.join("mill", ABOUT)
    light.join("mill", ABOUT | {"host": "lab2"})
    light.join("lathe", None, "m1", "m2")
    light.join("newer", ABOUT | {"protocol": PROTOCOL_VERSION + 1})
    with Lab(light.door) as lab:
        rows = rows_of(lab, 3)
    assert [(row["bench"], row.get("host")) for row in rows] == [
        ("lathe", None),
        ("mill", "lab1"),
        ("mill", "lab2"),
        ("newer", "lab1"),
    ]
    assert rows[0]["devices"].keys() == {"m1", "m2"}
    shown = str(lab_view(rows, 0))
    assert "lathe: it tells nothing about itself" in shown
    assert shown.count("mill: 2 benches have this name: end all but one") == 2
    assert f"newer: it speaks protocol {PROTOCOL_VERSION + 1} between benches" in shown
    assert "update this computer" in shown
    listed = CliRunner().invoke(app, ["list", "--connect", light.door, "--json"])
    assert [row["bench"] for row in json.loads(listed.output)] == [row["bench"] for row in rows]


class Doors:
    """Routers of a site, one with certificates and users, one with users alone."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self.tls, self.plain = (f"{kind}/127.0.0.1:{free_port()}" for kind in ("tls", "tcp"))
        port = int(self.tls.rpartition(":")[2])
        users = [("otto", Role.OPERATOR)]
        for name in ("ours", "theirs"):
            now = datetime.now(UTC)
            make_site(folder / name, Site("mill", ["127.0.0.1"], users, now, 30, port, [], ["127.0.0.1"]))
        self.ours, self.theirs = folder / "ours", folder / "theirs"
        known = read_users(self.ours / "users")
        router = {name: self.ours / f"router.{end}" for name, end in (("certificate", "pem"), ("key", "key"))}
        for door, tls in (
            (self.tls, TlsOptions(ca=self.ours / "ca.pem", **router)),
            (self.plain, None),
        ):
            with password_file(known) as dictionary:
                session = opened(router_config([door], tls, True, known, dictionary))
            stack.callback(session.close)  # type: ignore[arg-type]

    @staticmethod
    def files(site: Path) -> TlsOptions:
        return TlsOptions(ca=site / "ca.pem", certificate=site / "daemon.pem", key=site / "daemon.key")

    def user_file(self, folder: Path, site: Path, **changed: Any) -> Path:
        """File of a user, with other keys of ``transport/link/tls``, or another password."""
        values = json.loads((site / "clients/otto/zenoh.json").read_text())
        if password := changed.pop("password", None):
            values["transport"]["auth"]["usrpwd"]["password"] = password
        tls = values["transport"]["link"]["tls"] | changed
        values["transport"]["link"]["tls"] = {name: value for name, value in tls.items() if value is not None}
        path = folder / "zenoh.json"
        path.write_text(json.dumps(values))
        return path


@pytest.fixture(scope="module")
def doors(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Doors]:
    with ExitStack() as stack:
        yield Doors(tmp_path_factory.mktemp("sites"), stack)


def refusal(door: str | None = None, **given: Any) -> str:
    """Sentence of a refusal, which comes within two seconds of a machine that is not full."""
    with pytest.raises(ClientError) as caught, suppress(ssl.SSLError):
        connect_sync("mill", **({"endpoint": door} if door else {}), **given)
    return str(caught.value)


def test_refusals_are_different_sentences(doors: Doors, tmp_path: Path) -> None:
    own = partial(doors.user_file, tmp_path, doors.ours)
    no_certificate = {f"connect_{name}_base64": None for name in ("certificate", "private_key")}
    authority = json.loads((doors.ours / "clients/otto/zenoh.json").read_text())["transport"]["link"]["tls"]
    name = "root_ca_certificate_base64"
    said = {
        "password": refusal(config=own(password="x")),
        "no certificate": refusal(config=own(**no_certificate, enable_mtls=False)),
        "their router": refusal(config=doors.user_file(tmp_path, doors.theirs)),
        "our certificate": refusal(config=doors.user_file(tmp_path, doors.theirs, **{name: authority[name]})),
        "away": refusal(config=own()),
        "nobody": refusal(f"tcp/127.0.0.1:{free_port()}", timeout_s=0.2),
        "no user": refusal(doors.plain),
        "plain password": refusal(doors.plain, user="otto", password="x"),
        "no tls": refusal(doors.tls.replace("tls/", "tcp/")),
    }
    words = {
        "password": "it does not let in otto: the password is wrong",
        "no certificate": "it wants a certificate, and none is given",
        "their router": "its certificate is of another site than yours",
        "our certificate": "your certificate is of another site",
        "away": "there is no bench 'mill' that you may see; there: none. Start it",
        "nobody": "no router and no bench listens there (connection refused); start it",
        "no user": "it lets in users alone",
        "plain password": "it does not let in otto",
        "no tls": "it wants certificates (TLS); write tls/ for tcp/",
    }
    assert {case: text for case, text in said.items() if words[case] not in text} == {}
    assert all(text.startswith(("tcp/127.0.0.1:", "tls/127.0.0.1:")) for text in said.values())


def test_a_reason_is_found_in_time(doors: Doors) -> None:
    begin_s = time.monotonic()
    assert why_not(doors.plain, {}, "otto").why is Why.REFUSED
    assert why_not("tcp/nowhere.invalid:1", {}, None).why is Why.AWAY
    assert why_not("quic/127.0.0.1:1", {}, None).why is Why.OTHER
    assert time.monotonic() - begin_s < 10


def test_a_bench_says_in_its_log_why_it_is_not_joined(doors: Doors) -> None:
    theirs = Options(listen=[], connect=[doors.tls], tls=Doors.files(doors.theirs))
    assert "its certificate is of another site" in why_not_joined(theirs, "mill", is_of_site=False)
    nobody = Options(listen=[], connect=[f"tcp/127.0.0.1:{free_port()}"])
    assert "no router and no bench listens there" in why_not_joined(nobody, "mill", is_of_site=False)


def test_a_router_with_the_certificate_of_a_bench_is_no_other_site(tmp_path: Path) -> None:
    site, door = tmp_path / "site", f"tls/127.0.0.1:{free_port()}"
    users = [("otto", Role.OPERATOR)]
    make_site(site, Site("mill", [], users, datetime.now(UTC), 30, 7447, [], ["127.0.0.1"]))
    values = json.loads((site / "clients/otto/zenoh.json").read_text())["transport"]["link"]["tls"]
    session = opened(router_config([door], Doors.files(site), True))
    try:
        reason = why_not(door, values, "otto")
    finally:
        session.close()  # type: ignore[no-untyped-call]
    assert reason.why is Why.OTHER
    assert "its certificate is not one of a router or a bench" in reason.text


def test_the_command_line_says_it_too() -> None:
    done = CliRunner().invoke(app, ["list", "--connect", f"tcp/127.0.0.1:{free_port()}"])
    assert done.exit_code == 1
    assert "no router and no bench listens there" in done.output
    for words, why in (
        (["--label", "rig=press"], "name the lab with --connect or --config"),
        (["--connect", "tcp/127.0.0.1:1", "--label", "rig"], "is no label; write NAME=VALUE"),
    ):
        done = CliRunner().invoke(app, ["list", *words])
        assert done.exit_code == 2
        assert why in done.output
