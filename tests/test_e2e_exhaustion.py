"""Systems with no more to give, and clients whose computer has vanished: what is said, and what goes on."""

import itertools
import json
import os
import resource
import select
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator

import pytest
from e2e_support import Place, config, until

MOST_PTYS = 3
VANISHED_S = 120.0
"""25 s of silence, the 5 s between two looks, and time for a machine that is busy."""
needs_root = pytest.mark.skipif(
    os.getuid() != 0 or not shutil.which("unshare") or not shutil.which("ip"),
    reason="only root with util-linux and iproute2 can make namespaces",
)
FEW_PTYS = f"""
mount -t devpts -o newinstance,ptmxmode=666,max={MOST_PTYS} devpts /dev/pts &&
mount --bind /dev/pts/ptmx /dev/ptmx && exec "$@"
"""
CLIENT = """
import select, socket, sys
clients = []
for address, text in zip(sys.argv[1::2], sys.argv[2::2]):
    host, _, number = address.rpartition(":")
    client = socket.socket()
    client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    client.connect((host, int(number)))
    client.send(text.encode())
    clients.append(client)
print("ready", flush=True)
sys.stdin.read()
"""


@needs_root
def test_no_pty_is_left(place: Place) -> None:
    """The start is refused, with each port that could not be made, and nothing is left behind."""
    prefix = ("unshare", "--mount", "sh", "-c", FEW_PTYS, "sh")
    if subprocess.run([*prefix, "true"], capture_output=True, check=False).returncode:
        pytest.skip("mounting a devpts is not permitted here")
    many = config(devices={f"m{n}": {} for n in range(MOST_PTYS + 2)})
    said = place.launch(many, prefix=prefix).refused()
    refusals = [line for line in said.splitlines() if "no pty, or no watch on it: No space left" in line]
    assert len(refusals) == 2
    assert f"pty port of m{MOST_PTYS}: " in refusals[0]
    assert "kernel.pty.max" in refusals[0]
    assert not (place.runtime / "t").exists()
    place.serve(config(devices={f"m{n}": {} for n in range(MOST_PTYS)}), prefix=prefix).stop()


def test_files_are_taken_up_to_the_hard_limit(place: Place) -> None:
    def few() -> None:
        resource.setrlimit(resource.RLIMIT_NOFILE, (256, 3000))

    server = place.serve(config(), preexec_fn=few)
    assert resource.prlimit(server.pid, resource.RLIMIT_NOFILE) == (3000, 3000)


@pytest.fixture
def two_computers() -> Iterator[tuple[str, str]]:
    """Network namespaces with a cable between them, 10.77.0.1 and 10.77.0.2."""
    names = [f"hil{os.getpid()}{side}" for side in "ab"]

    def ip(*words: str) -> None:
        subprocess.run(["ip", *words], check=True, capture_output=True)

    try:
        for name in names:
            ip("netns", "add", name)
        ip(
            "link",
            "add",
            "wire",
            "netns",
            names[0],
            "type",
            "veth",
            "peer",
            "name",
            "wire",
            "netns",
            names[1],
        )
        for number, name in enumerate(names, start=1):
            ip("-n", name, "address", "add", f"10.77.0.{number}/24", "dev", "wire")
            ip("-n", name, "link", "set", "wire", "up")
    except subprocess.CalledProcessError as error:
        pytest.skip(f"network namespaces are not permitted here: {error.stderr.decode()}")
    else:
        yield names[0], names[1]
    finally:
        for name in names:
            subprocess.run(["ip", "netns", "del", name], check=False, capture_output=True)


@pytest.mark.thorough
@needs_root
def test_clients_whose_computer_vanishes(place: Place, two_computers: tuple[str, str]) -> None:
    """Let go of clients that said nothing, that wait for an answer, and that do not read."""
    ours, theirs = two_computers
    port = {"kind": "tcp", "listen": "10.77.0.1"}
    names = ("idle", "asking", "deaf")
    bench = json.loads(config(speed=1, devices={name: {"port": port} for name in names}))
    server = place.serve(json.dumps(bench), prefix=("ip", "netns", "exec", ours)).ready("deaf")
    addresses = [server.status(name)["address"].removeprefix("socket://") for name in names]
    command = ["ip", "netns", "exec", theirs, sys.executable, "-c", CLIENT]
    command += itertools.chain(*zip(addresses, ("", "", "q" * 100), strict=True))
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdin
        assert process.stdout
        assert process.stdout.readline() == b"ready\n"
        until(lambda: all(server.status(name)["clients"] == 1 for name in names), "the clients")
        until(lambda: server.status("deaf")["backlog_bytes"] > 0, "a client that does not read")
        subprocess.run(["ip", "-n", theirs, "link", "set", "wire", "down"], check=True)
        began_s = time.monotonic()
        server.ask("send", device="asking", data=b"p".hex())
        left_s = {}
        while len(left_s) < len(names):
            for name in names:
                if name not in left_s and server.status(name)["clients"] == 0:
                    left_s[name] = time.monotonic() - began_s
            assert time.monotonic() - began_s < VANISHED_S, f"still there; gone are {left_s}"
            select.select([], [], [], 0.1)
        print({name: f"{after_s:.1f} s" for name, after_s in left_s.items()})
        assert server.status("deaf")["backlog_bytes"] == 0
        process.stdin.close()
