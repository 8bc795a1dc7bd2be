"""The switch itself: delays, jitter, losses, cuts, and networks that become one."""

import json
import select
import statistics
import subprocess
import sys
from typing import Any

import pytest
from host_network import NAMESPACES, Computer, HostNetwork

ECHO = """
import socket, sys
s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
s.bind(("", 9))
print("up", flush=True)
while True:
    data, who = s.recvfrom(2000)
    s.sendto(data, who)
"""
ASK = """
import json, socket, sys, time
s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
s.settimeout(0.5)
address, count, every_s = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
took = {}
for k in range(count):
    began = time.monotonic()
    s.sendto(b"%d %f" % (k, began), (address, 9))
    try:
        while True:
            number, sent = s.recv(2000).split()
            took[int(number)] = time.monotonic() - float(sent)
            if int(number) == k:
                break
    except (TimeoutError, OSError):
        pass
    time.sleep(every_s)
print(json.dumps([took.get(k) for k in range(count)]))
"""
ROUND_MS = 36


@pytest.fixture
def pair(network: HostNetwork) -> tuple[Computer, Computer]:
    made = network.computers("mill", "lathe")
    echo = network.start(made["lathe"], sys.executable, "-c", ECHO)
    assert echo.stdout
    assert echo.stdout.readline() == "up\n"
    return made["mill"], made["lathe"]


def asked(near: Computer, far: Computer, count: int, every_s: float = 0) -> list[float | None]:
    """Time of each round trip in s; None for one that was lost."""
    command = [*near.prefix, sys.executable, "-c", ASK, far.address, str(count), str(every_s)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    answer: list[float | None] = json.loads(done.stdout)
    return answer


def test_a_link_delays_each_way(pair: tuple[Computer, Computer]) -> None:
    near, far = pair
    bare = statistics.median(each for each in asked(near, far, 50) if each is not None)
    for link in (near.link, far.link):
        link.set(delay_ms=ROUND_MS / 4, jitter_ms=2)
    took = [each for each in asked(near, far, 50) if each is not None]
    assert len(took) == 50
    median_ms = (statistics.median(took) - bare) * 1000
    assert ROUND_MS - 1 < median_ms < ROUND_MS + 10, "a busy machine adds, and takes nothing away"
    assert min(took) * 1000 > ROUND_MS - 8
    assert max(took) - min(took) > 0.001, "jitter"


def test_one_way_alone(pair: tuple[Computer, Computer]) -> None:
    near, far = pair
    near.link.set_way("in", delay_ms=20)
    took = [each for each in asked(near, far, 10) if each is not None]
    assert 0.019 < statistics.median(took) < 0.035


def test_losses_are_drawn_from_the_seed(pair: tuple[Computer, Computer]) -> None:
    near, far = pair
    far.link.set_way("in", loss_percent=20)
    took = asked(near, far, 60)
    assert 3 <= took.count(None) <= 24, "12 are to be expected"


def test_a_cut_loses_all_and_ends(pair: tuple[Computer, Computer]) -> None:
    near, far = pair
    near.link.cut()
    assert asked(near, far, 2) == [None, None]
    near.link.join()
    assert None not in asked(near, far, 5)


def test_networks_that_become_one(pair: tuple[Computer, Computer]) -> None:
    near, far = pair
    far.link.join(2)
    assert asked(near, far, 1) == [None]
    near.link.join(2)
    assert None not in asked(near, far, 2)


def test_many_bytes_arrive_as_they_were(pair: tuple[Computer, Computer], network: HostNetwork) -> None:
    """TCP with losses and jitter: whole segments, right check sums, in their order."""
    near, far = pair
    for link in (near.link, far.link):
        link.set(delay_ms=2, jitter_ms=1, loss_percent=0.5)
    serve = (
        "import socket, hashlib; s = socket.create_server(('', 10)); print('up', flush=True);"
        "c, _ = s.accept(); f = c.makefile('rb'); print(hashlib.sha256(f.read()).hexdigest(), flush=True)"
    )
    server = network.start(far, sys.executable, "-c", serve)
    assert server.stdout
    server.stdout.readline()
    send = (
        f"import socket, hashlib, random; s = socket.create_connection(('{far.address}', 10));"
        "d = random.Random(1).randbytes(2_000_000); s.sendall(d); print(hashlib.sha256(d).hexdigest())"
    )
    sent = subprocess.run(
        [*near.prefix, sys.executable, "-c", send], capture_output=True, text=True, timeout=60
    )
    assert select.select([server.stdout], [], [], 60)[0]
    assert server.stdout.readline() == sent.stdout


def test_nothing_is_left_behind(network: HostNetwork) -> None:
    made: dict[str, Any] = network.computers("mill")
    network.start(made["mill"], "sleep", "1000")
    assert len(list(NAMESPACES.glob("hilhost*-mill"))) >= 1
    network.close()
    assert list(NAMESPACES.glob(f"{made['mill'].namespace}")) == []
    assert subprocess.run(["ip", "link", "show", "eth0"], capture_output=True, check=False).returncode
