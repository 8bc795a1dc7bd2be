"""Metrics and health of a running bench, as Prometheus and people get them."""

import json
import os
import resource
import select
import socket
import time
import urllib.error
import urllib.request
from urllib.parse import urlparse

import pytest
from e2e_support import PATIENCE_S, Client, Place, Server, config, until
from prometheus_client.parser import text_string_to_metric_families

from hil.discovery.named_kinds import find_wire_infos
from hil.operations.metrics import metric_rows

METRICS_BRIDGE = {"metrics": {"listen": "127.0.0.1:0"}}
Samples = dict[tuple[str, ...], float]


def url(server: Server) -> str:
    root: str = server.ask("status")["bridges"]["metrics"]["root"]
    return root


def scrape(server: Server) -> Samples:
    """Values by the sample's name and the values of its labels."""
    return scrape_at(url(server))


def scrape_at(where: str) -> Samples:
    with urllib.request.urlopen(where, timeout=PATIENCE_S) as answer:
        assert answer.headers["Content-Type"].startswith("text/plain; version=0.0.4")
        text = answer.read().decode()
    families = list(text_string_to_metric_families(text))
    table = [metric for metric, _ in metric_rows(find_wire_infos())]
    assert [f.type for f in families] == [metric.kind for metric in table]
    assert [f.name for f in families] == [metric.name.removesuffix("_total") for metric in table]
    assert all(f.documentation for f in families)
    return {(s.name, *s.labels.values()): s.value for f in families for s in f.samples}


@pytest.fixture
def server(place: Place) -> Server:
    devices = {"m1": {}, "s1": {"profile": "sac", "flash": {}}}
    segments = {"bus": {"stations": ["s1"], "taps": {"tool": {"port": "pty"}}}}
    return place.serve(config(devices=devices, bridges=METRICS_BRIDGE, segments=segments)).ready()


def test_metrics_tell_what_status_tells(server: Server) -> None:
    with server.client("m1") as client:
        answer = client.ask(b"p")
        before, now, after = server.ask("status"), scrape(server), server.ask("status")
    assert before["ticks"] <= now["hil_ticks_total",] <= after["ticks"]
    assert before["missed"] <= now["hil_missed_ticks_total",] <= after["missed"]
    assert before["sim_ns"] / 1e9 <= now["hil_simulated_seconds_total",] <= after["sim_ns"] / 1e9
    assert now["hil_wake_latency_seconds_count",] == pytest.approx(now["hil_ticks_total",], abs=1)
    mean_s = now["hil_wake_latency_seconds_sum",] / now["hil_wake_latency_seconds_count",]
    assert 0 < mean_s < now["hil_wake_latency_max_seconds",]
    assert now["hil_firmware_lag_seconds_count",] > 0
    assert now["hil_loop_lag_seconds_count",] > 0
    assert (now["hil_port_clients", "m1"], now["hil_port_connects_total", "m1"]) == (1, 1)
    assert (now["hil_port_received_bytes_total", "m1"], now["hil_port_clients", "s1"]) == (1, 0)
    assert now["hil_port_sent_bytes_total", "m1"] >= len(answer)
    assert now["hil_port_clients", "bus.tool"] == 0
    assert now["hil_segment_packets_total", "bus"] == 0
    assert now["hil_device_failed", "m1"] == 0
    assert now["hil_runs", "running"] == 0
    assert now["hil_bench_info", "t", before["version"]] == 1
    assert 10e6 < now["process_resident_memory_bytes",] < 1e9
    assert now["process_open_fds",] < now["process_max_fds",]
    assert scrape(server)["hil_bridge_commands_total", "metrics"] == 2


def test_health_is_one_truth(place: Place, server: Server) -> None:
    """Health is the same in status, in metrics and for people."""
    server.ask("inject", fault="node_brown_out", target="m1", parameters={})
    until(lambda: server.status("m1")["failed"], "the failure")
    health = server.ask("status")["health"]
    assert health["state"] == "failed"
    (problem,) = [each for each in health["problems"] if each["kind"] == "device"]
    assert problem["about"] == "m1"
    assert problem["remedy"] == "`hil fault clear` ends the fault"
    now = scrape(server)
    assert now["hil_healthy",] == 0
    assert (now["hil_health", "failed"], now["hil_health", "ok"], now["hil_health", "late"]) == (1, 0, 0)
    assert now["hil_problems", "device"] == 1
    assert now["hil_device_failed", "m1"] == 1
    text = place.cli("status")
    assert "health: failed" in text
    assert f"m1: {problem['what']}; `hil --runtime-dir {place.runtime} fault clear` ends the fault" in text
    assert json.loads(place.cli("status", "--json"))["health"]["state"] == "failed"
    place.cli("reset", "m1")
    assert scrape(server)["hil_problems", "device"] == 1
    server.ask("clear", number=1)
    until(lambda: scrape(server)["hil_problems", "device"] == 0, "the end of the fault")


def test_other_requests(server: Server) -> None:
    root = url(server)
    for path, code in (("/other", 404), ("/metrics/", 404)):
        with pytest.raises(urllib.error.HTTPError) as refused:
            urllib.request.urlopen(root.removesuffix("/metrics") + path, timeout=PATIENCE_S)
        assert refused.value.code == code
        refused.value.close()
    with pytest.raises(urllib.error.HTTPError) as refused:
        urllib.request.urlopen(root, data=b"x", timeout=PATIENCE_S)
    assert refused.value.code == 405
    refused.value.close()
    with urllib.request.urlopen(urllib.request.Request(root, method="HEAD"), timeout=PATIENCE_S) as answer:
        assert int(answer.headers["Content-Length"]) > 1000
    assert scrape(server)["hil_bridge_rejected_total", "metrics"] == 3
    address = urlparse(root)
    assert address.hostname
    with socket.create_connection((address.hostname, address.port), timeout=PATIENCE_S) as proxied:
        proxied.sendall(b"GET HTTP://elsewhere:1/metrics?x HTTP/1.1\r\nHost: elsewhere\r\n\r\n")
        assert proxied.recv(15) == b"HTTP/1.1 200 OK"


def test_clients_that_say_nothing_or_too_much_take_nothing_away(server: Server) -> None:
    address = urlparse(url(server))
    assert address.hostname
    where = (address.hostname, address.port)
    silent = [socket.create_connection(where, timeout=PATIENCE_S) for _ in range(20)]
    try:
        until(lambda: server.ask("status")["bridges"]["metrics"]["rejected"] >= 4, "four too many")
        assert scrape(server)["hil_bridge_links", "metrics"] == 16  # the one that asks among them
        assert server.output.count("16 clients are connected; who has said nothing longest is let go") == 1
        with server.client("m1") as client:
            client.ask(b"p")
    finally:
        for each in silent:
            each.close()
    until(lambda: server.ask("status")["bridges"]["metrics"]["links"] == 0, "their end")
    with socket.create_connection(where, timeout=PATIENCE_S) as loud, Client(loud) as client:
        client.write_until_full(b"x" * 100_000)
        until(lambda: server.ask("status")["bridges"]["metrics"]["rejected"] >= 21, "the loud one's end")
    assert scrape(server)["hil_healthy",] in (0, 1)


def test_no_file_descriptor_is_left(place: Place, server: Server) -> None:
    """The shortage is logged once, and a scrape works again as soon as there are descriptors."""
    address = urlparse(url(server))
    assert address.hostname
    before = resource.prlimit(server.pid, resource.RLIMIT_NOFILE)
    highest = max(map(int, os.listdir(f"/proc/{server.pid}/fd")))
    resource.prlimit(server.pid, resource.RLIMIT_NOFILE, (highest + 1, before[1]))
    waiting = [
        socket.create_connection((address.hostname, address.port), timeout=PATIENCE_S) for _ in range(60)
    ]
    try:
        until(lambda: "metrics: new clients have to wait: Too many open files" in server.output, "the word")
        select.select([], [], [], 1.5)  # for it to be tried again
        assert server.output.count("WARNING metrics: ") == 1, server.output
        assert "Traceback" not in server.output
        resource.prlimit(server.pid, resource.RLIMIT_NOFILE, before)
        began_s = time.monotonic()
        assert scrape_at(f"http://{address.netloc}/metrics")
        assert time.monotonic() - began_s < 10
    finally:
        for each in waiting:
            each.close()


@pytest.mark.parametrize(
    ("listen", "said"),
    [
        ("0.0.0.0:9464", "is reached from other computers, and metrics have no users"),
        ("[::]:9464", "is reached from other computers"),
        ("example.com:9464", "is reached from other computers"),
        (":9464", "has no host (write 127.0.0.1:9464 for this computer alone"),
        ("127.0.0.1:70000", "'70000' is no port"),
        ("127.0.0.1:\N{SUPERSCRIPT TWO}", "is no port (a port is 1 to 65535"),
        ("127.0.0.1\0:0", "holds the character NUL"),
        (f"{70 * 'a'}.example:0", "is no address and no name of a computer"),
    ],
)
def test_doors_that_stay_closed(place: Place, listen: str, said: str) -> None:
    """Expect ``hil check`` to find them, with their place."""
    text = config(bridges={"metrics": {"listen": listen}})
    output = place.launch(text).refused()
    assert said in output
    assert "bridges.metrics.listen:" in output
    said = place.cli("check", str(place.write(text)), code=2)
    assert said.splitlines()[1].startswith(f"{place.folder}/bench.yaml:1:")


@pytest.mark.parametrize("listen", ["127.1:0", "LOCALHOST:0", "localhost:0", "127.0.0.1:0"])
def test_doors_that_nobody_outside_reaches(place: Place, listen: str) -> None:
    server = place.serve(config(bridges={"metrics": {"listen": listen}}))
    assert scrape(server)["hil_healthy",] in (0, 1)
    assert not server.ask("status")["bridges"]["metrics"]["insecure"]


def test_a_host_that_is_none(place: Place) -> None:
    listen = "nosuchhost.invalid:9464"
    output = place.launch(config(bridges={"metrics": {"listen": listen, "insecure": True}})).refused()
    assert "bridges.metrics.listen: there is no computer '" in output


def test_an_open_door_is_said_to_be_one(place: Place) -> None:
    server = place.serve(config(bridges={"metrics": {"listen": "0.0.0.0:0", "insecure": True}}))
    assert "insecure: every program that can reach" in server.output
    assert "INSECURE: every program that can reach it can read all metrics" in place.cli("status")
    server.stop()


def test_a_port_that_is_taken(place: Place) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        listen = f"127.0.0.1:{taken.getsockname()[1]}"
        output = place.launch(config(bridges={"metrics": {"listen": listen}})).refused()
    assert f"bridges.metrics.listen: {listen} is in use by " in output
    assert f"(process {os.getpid()}); choose another port, or end it" in output
