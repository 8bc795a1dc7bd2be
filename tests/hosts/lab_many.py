"""A hundred benches at one router: their states at a user's computer."""

import json
import os
import select
import subprocess
import sys
import time
from typing import Any

import light_benches
import zenoh
from bench_sites import Site
from e2e_support import Place, until
from host_network import Computer, HostNetwork
from plain_zenoh import QUIET

BENCHES = 100
COMPUTERS = 4
SECONDS = 10
WANTED_S = 0.15
"""p99 of a state's way, on a machine that is not full."""


def said(process: subprocess.Popen[str], word: str) -> None:
    assert process.stdout
    assert select.select([process.stdout], [], [], 120)[0], f"no {word}"
    assert process.stdout.readline().strip() == word


def go_on(process: subprocess.Popen[str]) -> None:
    assert process.stdin
    process.stdin.write("\n")
    process.stdin.flush()


def ways(network: HostNetwork, computers: list[Computer], router: str, count: int) -> list[float]:
    """Time of each state's way; checks that none is lost."""
    each = count // len(computers)
    started = [
        network.start(
            computer, sys.executable, light_benches.__file__, str(k * each), str(each), router, str(SECONDS)
        )
        for k, computer in enumerate(computers)
    ]
    for process in started:
        said(process, "up")
    heard: list[tuple[str, int, float]] = []

    def hear(sample: zenoh.Sample) -> None:
        state: dict[str, Any] = json.loads(sample.payload.to_bytes())
        heard.append((str(sample.key_expr), state["n"], time.monotonic() - state["sent_s"]))

    config = zenoh.Config()
    for path, value in {**QUIET, "mode": "client", "connect/endpoints": [router]}.items():
        config.insert_json5(path, json.dumps(value))
    with zenoh.open(config) as session:
        alive = "hil/*/@live/daemon"

        def seen() -> bool:
            return sum(bool(reply.ok) for reply in session.liveliness().get(alive, timeout=10)) == count

        until(seen, "all tokens at the user's computer")
        subscriber = session.declare_subscriber(
            f"hil/*/{light_benches.KEY}", zenoh.handlers.Callback(hear, indirect=False)
        )
        select.select([], [], [], 1)  # the subscription reaches all
        for process in started:
            go_on(process)
        for process in started:
            said(process, "sent")
        wanted = count * SECONDS * light_benches.STATE_HZ
        until(lambda: len(heard) >= wanted, f"{wanted} states")
        subscriber.undeclare()
        for process in started:
            go_on(process)
            process.wait(60)
    assert len({(key, number) for key, number, _ in heard}) == wanted
    return sorted(took for _, _, took in heard)


def test_states_of_a_hundred_benches(place: Place, network: HostNetwork) -> None:
    made = network.computers("router", *(f"rack{number}" for number in range(COMPUTERS)))
    racks = [made[f"rack{number}"] for number in range(COMPUTERS)]
    router = made["router"].endpoint()
    site = Site(place, {"rack0": router}, {"router": made["router"].prefix})
    site.join()
    try:
        alone = ways(network, racks, router, COMPUTERS)
        all_ = ways(network, racks, router, BENCHES)
    finally:
        site.part()

    def p99_ms(took: list[float]) -> float:
        return took[int(len(took) * 0.99)] * 1e3

    load = os.getloadavg()[0]
    print(
        f"{BENCHES} benches: {len(all_)} states, p50 {all_[len(all_) // 2] * 1e3:.1f} ms,"
        f" p99 {p99_ms(all_):.1f} ms, longest {all_[-1] * 1e3:.0f} ms;"
        f" {COMPUTERS} benches: p99 {p99_ms(alone):.1f} ms; load {load:.1f}"
    )
    if load <= 2 * len(os.sched_getaffinity(0)):
        assert p99_ms(all_) <= WANTED_S * 1e3
