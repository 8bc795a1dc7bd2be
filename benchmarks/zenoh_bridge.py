"""Cost of the zenoh bridge, against the least program that could do the same.

1. A query until it is acknowledged, against a bare zenoh-python queryable in a process of its own that
   takes the same JSON, hops into asyncio once and answers as many bytes. Turn by turn, one client for both.
   Wanted: median at most 1.6 times, p99 at most twice.
2. CPU time of a daemon that tells the state of 200 axes 100 times a second, JSON and packed, against the same
   daemon with nobody listening, and against a bare publisher of as many puts with as many bytes, which the
   daemon cannot be below. Wanted: at most 14 and 7 points of a core more.
3. One axis 1000 times a second: no sample lost to a subscriber that keeps up.
4. Threads of the daemon with 200 devices.
"""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

import zenoh
from _processes import precise_cpu_s
from _report import check_work, report

QUERIES = 200 if "--quick" in sys.argv else 2000
SECONDS = 3 if "--quick" in sys.argv else 10
AXES = 200
STATES_HZ = 100
WANTED = {"json": 14.0, "packed": 7.0}
HIL = Path(sys.executable).parent / "hil"
BARE = """
import asyncio, json, sys, zenoh
TIMES = {"sim_ns": 10**10, "wall_ns": 10**18, "effective_at_ns": 10**10}
ANSWER = json.dumps({"v": 1, **TIMES, "set_point": 90.0})
async def main():
    loop = asyncio.get_running_loop()
    config = zenoh.Config()
    for path, value in json.loads(sys.argv[1]).items():
        config.insert_json5(path, json.dumps(value))
    def answer(query):
        with query:
            json.loads(query.payload.to_bytes())
            query.reply(query.key_expr, ANSWER)
    with zenoh.open(config) as session:
        session.declare_queryable("bare/**", lambda query: loop.call_soon_threadsafe(answer, query))
        print("ready", flush=True)
        await asyncio.Event().wait()
asyncio.run(main())
"""
PUBLISHER = """
import asyncio, json, sys, zenoh
values, axes, size, at_once, interval_s = json.loads(sys.argv[1])
async def main():
    config = zenoh.Config()
    for path, value in values.items():
        config.insert_json5(path, json.dumps(value))
    with zenoh.open(config) as session:
        options = {
            "encoding": zenoh.Encoding.APPLICATION_JSON.with_schema("hil.state.v1"),
            "congestion_control": zenoh.CongestionControl.DROP,
            "allowed_destination": zenoh.Locality.REMOTE,
        }
        keys = [f"hil/bare/axis/m{i}/state" for i in range(axes)]
        publishers = [session.declare_publisher(key, **options) for key in keys]
        print("ready", flush=True)
        loop = asyncio.get_running_loop()
        due_s = loop.time()
        while True:
            for publisher in publishers:
                for _ in range(at_once):
                    publisher.put(bytes(size))
            due_s += interval_s
            await asyncio.sleep(max(due_s - loop.time(), 0))
asyncio.run(main())
"""


def config(**extra: Any) -> dict[str, Any]:
    quiet = {"scouting/multicast/enabled": False, "scouting/gossip/enabled": False}
    return (
        quiet
        | {"transport/shared_memory/enabled": False}
        | {k.replace("__", "/"): v for k, v in extra.items()}
    )


def opened(values: dict[str, Any]) -> zenoh.Session:
    made = zenoh.Config()
    for path, value in values.items():
        made.insert_json5(path, json.dumps(value))
    return zenoh.open(made)


def bench(folder: Path, port: int, devices: int, options: str) -> subprocess.Popen[str]:
    lines = "\n".join(f"  m{i}: {{profile: mechaduino, flash: {{table: identity}}}}" for i in range(devices))
    door = f"bridges:\n  zenoh: {{listen: [tcp/127.0.0.1:{port}]{options}}}\n"
    text = f"bench: z{devices}\ndevices:\n{lines}\n{door}"
    path = folder / f"z{devices}.yaml"
    path.write_text(text)
    command = [HIL, "serve", path, "--runtime-dir", folder / "run", "--state-dir", folder / "state"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    assert process.stdout is not None
    while not process.stdout.readline().startswith("Ctrl-C"):
        if process.poll() is not None:
            raise SystemExit("the daemon did not start")
    time.sleep(5)  # the boards' start
    return process


def queries(folder: Path) -> None:
    daemon = bench(folder, 7461, 1, "")
    bare_config = config(mode="router", listen__endpoints=["tcp/127.0.0.1:7462"])
    bare = subprocess.Popen(
        [sys.executable, "-c", BARE, json.dumps(bare_config)], stdout=subprocess.PIPE, text=True
    )
    assert bare.stdout is not None
    bare.stdout.readline()
    doors = {
        "hil": ("tcp/127.0.0.1:7461", "hil/z1/axis/m0/cmd/position"),
        "bare": ("tcp/127.0.0.1:7462", "bare/x"),
    }
    sessions = {
        name: opened(config(mode="client", connect__endpoints=[door])) for name, (door, _) in doors.items()
    }
    list(sessions["hil"].get("hil/z1/axis/m0/cmd/enable", timeout=5))
    took: dict[str, list[float]] = {name: [] for name in doors}
    for i in range(QUERIES):
        for name, (_, key) in doors.items():
            payload = json.dumps({"position_deg": 6.0 + i % 10 * 0.1})
            began = time.perf_counter()
            replies = list(sessions[name].get(key, payload=payload, timeout=5))
            took[name].append((time.perf_counter() - began) * 1e3)
            if len(replies) != 1 or not replies[0].ok:
                raise SystemExit(f"{name}: {replies}")
    for session in sessions.values():
        session.close()
    for process in (daemon, bare):
        process.terminate()
        process.wait(20)
    figures = {n: (statistics.median(t), sorted(t)[int(len(t) * 0.99)]) for n, t in took.items()}
    extra: dict[str, object] = {"reference": "a bare zenoh-python queryable"}
    for i, (name, limit_ratio) in enumerate((("p50", 1.6), ("p99", 2.0))):
        report(f"zenoh_query_{name}", figures["hil"][i], "ms", figures["bare"][i], limit_ratio, extra)


def states(folder: Path) -> None:
    daemon = bench(folder, 7463, AXES, f", state_hz: {STATES_HZ}, packed_hz: {STATES_HZ}")
    threads = len(os.listdir(f"/proc/{daemon.pid}/task"))
    print(f"threads of the daemon with {AXES} devices: {threads}")

    nobody, _ = load(daemon, 7463, f"{AXES} axes, nobody listens", None)
    for name, key in (("json", "state"), ("packed", "state/packed")):
        about = f"{AXES} axes at {STATES_HZ} Hz, {name}"
        share, size = load(daemon, 7463, about, f"hil/z{AXES}/axis/*/{key}")
        bare = bare_points(size)
        extra: dict[str, object] = {"reference": "what is wanted at most", "bare publisher": bare}
        report(f"zenoh_{name}", 100 * (share - nobody), "points of a core", WANTED[name], 1.0, extra)
        print(f"  a bare publisher of as many bytes: {bare:.1f} points")
    daemon.terminate()
    daemon.wait(20)


def load(process: subprocess.Popen[str], port: int, about: str, key: str | None) -> tuple[float, int]:
    """Share of a core that a process takes while this key is subscribed to, and bytes of its last sample."""
    counts, sizes = [0], [0]
    session = opened(config(mode="client", connect__endpoints=[f"tcp/127.0.0.1:{port}"]))

    def count(sample: zenoh.Sample) -> None:
        counts[0] += 1
        sizes[0] = len(sample.payload)

    if key:
        session.declare_subscriber(key, count)
    time.sleep(1.5)
    counts[0], spent_s, began_s = 0, precise_cpu_s(process.pid), time.monotonic()
    time.sleep(SECONDS)
    passed_s = time.monotonic() - began_s
    share = (precise_cpu_s(process.pid) - spent_s) / passed_s
    print(f"{about:34} {share * 100:5.1f} % of a core, {counts[0] / passed_s:8.0f} samples/s")
    session.close()
    time.sleep(1.5)
    check_work(about, counts[0] / passed_s, AXES * STATES_HZ if key else 0, 0.1)
    return share, sizes[0]


def bare_points(size: int) -> float:
    """Points of a core that as many puts of so many bytes take in a program that does nothing else. It puts
    them as the daemon does, which takes samples of so many axes twenty times a second."""
    listening = config(mode="router", listen__endpoints=["tcp/127.0.0.1:7465"])
    interval_s = AXES / 4000
    given = json.dumps([listening, AXES, size, round(STATES_HZ * interval_s), interval_s])
    bare = subprocess.Popen([sys.executable, "-c", PUBLISHER, given], stdout=subprocess.PIPE, text=True)
    assert bare.stdout is not None
    bare.stdout.readline()
    share, _ = load(bare, 7465, "a bare publisher", "hil/bare/axis/*/state")
    bare.terminate()
    bare.wait(20)
    return 100 * share


def fast(folder: Path) -> None:
    daemon = bench(folder, 7464, 1, ", packed_hz: 1000, state_hz: 1000")
    session = opened(config(mode="client", connect__endpoints=["tcp/127.0.0.1:7464"]))
    for key in ("state/packed", "state"):
        times: list[int] = []

        def keep(sample: zenoh.Sample, times: list[int] = times, key: str = key) -> None:
            data = sample.payload.to_bytes()
            is_packed = key == "state/packed"
            times.append(int.from_bytes(data[:8], "little") if is_packed else json.loads(data)["at_ns"])

        with session.declare_subscriber(f"hil/z1/axis/m0/{key}", keep):
            time.sleep(SECONDS + 1)
        gaps = [b - a for a, b in pairwise(times)]
        lost = sum(gap // 1_000_000 - 1 for gap in gaps)
        disorder = sum(gap <= 0 for gap in gaps)
        print(f"1 axis at 1 kHz, {key}: {len(times)} samples, {lost} lost, {disorder} out of order")
    session.close()
    daemon.terminate()
    daemon.wait(20)


with tempfile.TemporaryDirectory() as made:
    if "--states" not in sys.argv:
        queries(Path(made))
    states(Path(made))
    fast(Path(made))
