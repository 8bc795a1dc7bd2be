"""The port of ``docs/how-to/add-a-port.md``, as it stands there."""

import asyncio
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from how_to_pages import answer_of_daemon, installed_from, style_problems
from markdown_blocks import block

from hil.compose import find_catalogue
from hil.config import ConfigError, parse
from hil.daemon import Serving

PAGE = "add-a-port"


@pytest.fixture(autouse=True)
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Path]]:
    with installed_from(PAGE, tmp_path / "page", monkeypatch) as written:
        yield written


def test_its_tests_pass(files: list[Path]) -> None:
    """Run the page's tests in this process, so that the port is found."""
    assert [path.name for path in files] == ["port.py", "test_unix_port.py"]
    assert pytest.main(["-q", "-p", "no:cacheprovider", str(files[1])]) == 0


def test_its_style_is_the_projects(files: list[Path]) -> None:
    assert style_problems([path for path in files if path.suffix == ".py"]) == ""


def test_a_board_answers_through_it(tmp_path: Path) -> None:
    async def hear(serving: Serving) -> bytes:
        loop, heard = asyncio.get_running_loop(), b""
        with socket.socket(socket.AF_UNIX) as client:
            client.setblocking(False)
            await loop.sock_connect(client, serving.live.places["m1"].port.address)
            while b"Mechaduino" not in heard:
                heard += await loop.sock_recv(client, 4096)
        return heard

    text = block(f"docs/how-to/{PAGE}.md", "Use it")
    assert b"Mechaduino 0.X" in answer_of_daemon(text, tmp_path, hear)


def test_its_options_are_checked() -> None:
    text = "bench: t\ndevices: {m1: {profile: mechaduino, port: {kind: unix, pth: x}}}\n"
    with pytest.raises(ConfigError, match="pth"):
        parse(text, "t.yaml", find_catalogue())
