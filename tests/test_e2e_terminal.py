"""Text of others on a terminal: a node's, a file's, an argument's. Nothing of it is a command to it."""

import os
import pty
import socket
import subprocess
import threading
from pathlib import Path

import pytest
from e2e_support import HIL

from device_profiles.sac.packet import encode

EVIL = "\x1b]0;PWNED\x07\x1b[2J"
PATIENCE_S = 90


def on_terminal(*words: str) -> str:
    """What a command writes to a terminal."""
    end, command_end = pty.openpty()
    environment = {**os.environ, "TERM": "xterm"}
    child = subprocess.Popen(
        [HIL, *words], stdin=command_end, stdout=command_end, stderr=command_end, env=environment
    )
    os.close(command_end)
    said = b""
    try:
        while piece := os.read(end, 4096):
            said += piece
    except OSError:  # the last end was closed
        pass
    os.close(end)
    child.wait(PATIENCE_S)
    return said.decode("utf-8", "surrogateescape")


@pytest.fixture
def hostile_node() -> str:
    """A line with a node that says what its terminal shall do."""
    server = socket.create_server(("127.0.0.1", 0))

    def serve() -> None:
        while True:
            client, _ = server.accept()
            threading.Thread(target=talk, args=(client,), daemon=True).start()

    def talk(client: socket.socket) -> None:
        texts = (EVIL.encode(), b"\xff\xfe\x9b31m", b"\x08\x08\r\nhil: all is well")
        try:
            while True:
                for text in texts:
                    client.sendall(encode(0, 85, b" " + text))
                client.settimeout(0.2)
                try:
                    if not client.recv(4096):
                        return
                except TimeoutError:
                    pass
        except OSError:
            return

    threading.Thread(target=serve, daemon=True).start()
    return f"socket://127.0.0.1:{server.getsockname()[1]}"


@pytest.mark.parametrize("words", [("watch", "-c", "3"), ("nodes", "--addresses", "80-84")])
def test_a_node_does_nothing_to_the_terminal(hostile_node: str, words: tuple[str, ...]) -> None:
    verb, *options = words
    said = on_terminal("line", verb, hostile_node, *options)
    assert "85" in said
    assert said.replace("\r\n", "").isprintable()
    assert "\nhil: all is well" not in said


@pytest.mark.parametrize(
    "words", [("axis", EVIL), (EVIL,), ("docs", EVIL), ("decode", EVIL), ("list", "--bench", EVIL)]
)
def test_an_argument_in_an_error_does_nothing_to_the_terminal(words: tuple[str, ...], tmp_path: Path) -> None:
    where = ("--runtime-dir", str(tmp_path)) if words[0] in ("axis", "list") else ()
    said = on_terminal(*words, *where)
    assert "\x1b]" not in said
    assert "\x1b[2J" not in said


def test_a_file_does_nothing_to_the_terminal(tmp_path: Path) -> None:
    file = tmp_path / "bench\x1b[2J.yaml"
    file.write_text('bench: t\n"\\e[2J\\u202e": 1\ndevices: {"m\\e]0;x": {profile: "\\e[2J"}}\n')
    said = on_terminal("check", str(file))
    assert "\x1b[2J" not in said
    assert "\x1b]" not in said
    assert "\u202e" not in said
