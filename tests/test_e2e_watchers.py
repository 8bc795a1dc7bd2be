"""Requests of clients to a bench in real time: intervals of watchers, trains of pulses; and it goes on."""

import json
import signal
from pathlib import Path

import pytest
from e2e_support import Place, config


@pytest.mark.thorough
def test_watchers_of_any_interval_leave_the_bench_alone(place: Place) -> None:
    server = place.serve(config(speed=1, devices={"m1": {}, "m2": {}})).ready()

    def watch(interval_ns: int) -> int:
        number: int = server.ask("watch", device="m1", signals=["r"], interval_ns=interval_ns)["watch"]
        return number

    intervals = (1_000_000, 1_000_001, 49_999_999)
    watches = [watch(each) for each in intervals]
    rows: dict[int, list[int]] = {each: [] for each in intervals}
    while any(len(each) < 50 for each in rows.values()):
        for number, interval_ns in zip(watches, intervals, strict=True):
            answer = server.ask("samples", watch=number)
            assert answer["lost"] == 0
            rows[interval_ns] += [row[0] for row in answer["rows"]]
    for interval_ns, times in rows.items():
        first = times[0] // interval_ns
        assert times == [(first + k) * interval_ns for k in range(len(times))]
    for bad in (0, 49_999, 2**63 - 1, 2**63, 2**64 - 1):
        assert "an interval of" in refusal(
            server.control, verb="watch", device="m1", signals=[], interval_ns=bad
        )
    watch(3_600_000_000_000)
    server.stop(signal.SIGTERM)


def test_a_row_of_a_thousand_million_steps_is_refused(place: Place, tmp_path: Path) -> None:
    server = place.serve(config()).ready()
    train = tmp_path / "train.csv"
    train.write_text("at_s,steps,duration_s\n0,1000000000,2\n")
    said = place.cli("pulses", "m1", "--file", str(train), code=2)
    assert f"{train}:2:1: 1000000000 steps; write at most 100,000,000 in a row" in said
    rows = [[0, "step", 0, 10**9, 2 * 10**9]]
    assert refusal(server.control, verb="drive", device="m1", train=rows).startswith(
        "row 1: 1000000000 steps"
    )
    fastest = [[0, "step", 0, 10**8, 5000 * 10**8]]
    assert server.ask("drive", device="m1", train=fastest)["length_ns"] == 5000 * 10**8
    assert server.ask("status")["devices"][0]["failed"] is None
    server.stop(signal.SIGTERM)


def refusal(control: Path, **request: object) -> str:
    import socket

    with socket.socket(socket.AF_UNIX) as client:
        client.settimeout(10)
        client.connect(str(control))
        client.sendall(json.dumps(request).encode() + b"\n")
        answer = json.loads(client.makefile("rb").readline())
    assert answer["ok"] is False
    return str(answer["error"])
