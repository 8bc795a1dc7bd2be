"""``hil web user``, whose lines the door reads, and the ports at which the door listens."""

import asyncio
import os
import socket
from contextlib import ExitStack

import pytest
from pages_of_tests import PagesDesk, opened
from typer.testing import CliRunner

from bridges.web import web_bridge
from bridges.web.bridge import Options, make
from bridges.web.cli import app
from bridges.web.password_hash import fits
from bridges.web.web_users import user_of
from hil.vocab.bridge_protocol import BridgeError
from hil.vocab.verbs import Role

PASSWORD = "long and green"


def test_a_line_is_one_that_the_door_reads() -> None:
    done = CliRunner().invoke(app, ["user", "ann:operator"], input=f"{PASSWORD}\n")
    user = user_of(done.stdout)
    assert (done.exit_code, user.name, user.role) == (0, "ann", Role.OPERATOR)
    assert fits(PASSWORD, user.password_hash)
    assert PASSWORD not in done.output


@pytest.mark.parametrize(
    ("name", "password", "why"),
    [
        ("ann:boss", PASSWORD, "hil: there is no role 'boss'; there are viewer, operator, admin\n"),
        ("ann", PASSWORD, "hil: 'ann' has no role; write NAME:ROLE, as ann:viewer\n"),
        ("a b:viewer", PASSWORD, "hil: 'a b' is no name: letters, digits, _ . - and at most 64 of them\n"),
        ("ann:viewer", "short", "hil: a password has 12 characters or more\n"),
        (
            "ann:viewer",
            f"{PASSWORD}\x07",
            "hil: a password has printable characters alone, and no space around\n",
        ),
    ],
)
def test_what_is_no_user_or_no_password_is_refused(name: str, password: str, why: str) -> None:
    done = CliRunner().invoke(app, ["user", name], input=f"{password}\n")
    assert (done.exit_code, done.stdout, done.stderr) == (2, "", why)


def test_without_a_port_the_next_free_one_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    with ExitStack() as stack:
        first = stack.enter_context(socket.create_server(("127.0.0.1", 0))).getsockname()[1]
        monkeypatch.setattr(web_bridge, "FIRST_PORT", first)
        monkeypatch.setattr(web_bridge, "LAST_PORT", first)

        async def use() -> None:
            with pytest.raises(
                BridgeError, match=f"ports {first} to {first} of 127.0.0.1 are in use; choose"
            ):
                await make(Options(), PagesDesk()).open()
            monkeypatch.setattr(web_bridge, "LAST_PORT", first + 20)
            async with opened(listen="127.0.0.1") as one, opened(listen="127.0.0.1") as other:
                ports = [int(each.url[:-1].rpartition(":")[2]) for each in (one, other)]
                assert first < ports[0] < ports[1] <= first + 20
                async with one.page(), other.page():
                    pass

        asyncio.run(use())


def test_a_port_that_was_named_is_that_one_or_none() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(BridgeError) as refused:
            asyncio.run(make(Options(listen=f"127.0.0.1:{port}"), PagesDesk()).open())
    assert str(refused.value).startswith(f"127.0.0.1:{port} is in use by ")
    assert f"(process {os.getpid()}); choose another port, or end it" in str(refused.value)
    assert refused.value.option == ("listen",)
    with pytest.raises(BridgeError, match=r"192\.0\.2\.1:0 is no address of this computer"):
        asyncio.run(make(Options(listen="192.0.2.1:0", insecure=True), PagesDesk()).open())


@pytest.mark.parametrize(
    ("host", "names", "root"),
    [
        ("127.0.0.1", [], "http://127.0.0.1:{}/"),
        ("localhost", ["lab1"], "http://127.0.0.1:{}/"),
        ("0.0.0.0", [], "http://localhost:{}/"),
        ("0.0.0.0", ["lab1"], "http://lab1:{}/"),
        ("0.0.0.0", ["lab1:9000"], "http://lab1:9000/"),
    ],
)
def test_the_address_is_one_that_a_browser_can_open(host: str, names: list[str], root: str) -> None:
    async def use() -> None:
        async with opened(listen=f"{host}:0", names=names, insecure=True) as door:
            status = door.bridge.status()
            assert status["root"] == root.format(status["listen"][0].rpartition(":")[2])
            assert status["insecure"] is (host == "0.0.0.0")

    asyncio.run(use())
