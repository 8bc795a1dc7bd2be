"""The bridge of ``docs/how-to/add-a-bridge.md``, as it stands there, in a daemon."""

import asyncio
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from how_to_pages import answer_of_daemon, installed_from, style_problems

from hil.compose import find_catalogue
from hil.compose.find import bridge_reference
from hil.config import ConfigError, parse
from hil.daemon import Serving

PAGE = "add-a-bridge"
CONFIG = "bench: h\ndevices: {{s1: {{profile: sac}}}}\nbridges: {{datagrams: {{listen: {port}}}}}\n"


@pytest.fixture(autouse=True)
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Path]]:
    with installed_from(PAGE, tmp_path / "page", monkeypatch) as written:
        yield written


async def said(serving: Serving, text: str) -> str:
    loop = asyncio.get_running_loop()
    port = int(serving.live.bridges["datagrams"].status()["listen"][0].rpartition(":")[2])
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.setblocking(False)
        await loop.sock_sendto(client, text.encode(), ("127.0.0.1", port))
        return (await loop.sock_recv(client, 4096)).decode()


def test_it_carries_out_and_refuses(tmp_path: Path) -> None:
    async def answers(serving: Serving) -> list[str]:
        asked = ("s1 pin pin=sync level=1", "s1 jump", "s9 reset", "", "s1 pin pin=9 level=x")
        return [await said(serving, text) for text in asked]

    heard = answer_of_daemon(CONFIG.format(port=0), tmp_path, answers)
    codes = [answer.partition(":")[0] for answer in heard]
    assert codes == ["ok", "no_verb", "no_device", "no_device", "bad_parameter"], heard


def test_its_options_are_checked_and_its_reference_is_found() -> None:
    with pytest.raises(ConfigError, match="port"):
        parse(CONFIG.format(port=70000), "h.yaml", find_catalogue())
    assert bridge_reference("datagrams").startswith("## The datagrams bridge")


def test_its_tests_pass(files: list[Path]) -> None:
    """Run the page's tests in this process, so that the bridge is found."""
    assert [path.name for path in files] == ["bridge.py", "test_datagrams.py"]
    assert pytest.main(["-q", "-p", "no:cacheprovider", str(files[1])]) == 0


def test_its_style_is_the_projects(files: list[Path]) -> None:
    assert style_problems(files) == ""
