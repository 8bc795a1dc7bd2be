"""Size of a recording, and the memory and time that reading it takes.

``recording_busy_MB_per_h``: 32 SACs on a line at their usual speed whose master polls them back to back for
a minute of simulated time; at most 60 MB an hour. ``recording_typed_MB_per_min``: five boards that a person
types at, a command each second to one of them; at most 1 MB a minute. ``recording_read_MB_per_h``: memory
that an hour of the busy recording takes, read back; the time stands beside it. Files are written as a daemon
does, in texts of 0.2 s.
"""

import resource
import sys
import tempfile
import time
from pathlib import Path

from _report import check_work, is_quick, report

from device_profiles.sac.packet import PacketDecoder, encode
from hil.compose.log_lines import read_log
from hil.host.packed_text import PackedText
from hil.sim.bench import BenchHooks
from hil.sim.input_log import InputLogWriter
from hil.testing import Bench

FLUSH_MS = 200
SECONDS = 20 if is_quick() else 60
NODES, MASTER = 32, 1
BOARDS = {"m1": b"p", "m2": b"r90\n", "s1": b"vd\r", "s2": b"m10v60\r", "s3": b"v\r"}


def recorder(config: dict[str, object], path: Path) -> tuple[Bench, InputLogWriter, PackedText]:
    packed = PackedText(path.open("wb", buffering=0), is_packed=True)
    log = InputLogWriter(
        packed, "benchmark", config, {}, lambda waiting: None, lambda: (0, "2026-01-01T00:00:00.000000Z")
    )
    return Bench(config, around=BenchHooks(log=log)), log, packed


def flush(log: InputLogWriter, packed: PackedText) -> None:
    log.write_waiting()
    packed.flush()


def busy(path: Path) -> int:
    """Record a line that is polled; answers the number of bytes."""
    names = [f"s{address}" for address in range(4, 4 + NODES)]
    config: dict[str, object] = {
        "bench": "busy",
        "devices": {name: {"profile": "sac"} for name in names},
        "segments": {"bus0": {"stations": names, "taps": {"m": {"port": "memory"}}}},
    }
    bench, log, packed = recorder(config, path)
    bench.run(1100)
    for line, wait_ms in (("$CM{}", 50), ("$R", 1200)):
        for name in names:
            bench.port(name).write(f"{line.format(name[1:])}\r".encode())
        bench.run(wait_ms)
    flush(log, packed)
    begun, tap, polls, answers = packed.length, bench.tap("bus0.m"), 0, 0
    decoder, end_ns = PacketDecoder(), bench.now_ns + SECONDS * 10**9
    next_ns = bench.now_ns
    while bench.now_ns < end_ns:
        tap.write(encode(4 + polls % NODES, MASTER, b"vp"))
        polls += 1
        while bench.now_ns < end_ns:
            bench.run(0.5)
            if found := decoder.feed(tap.read()):
                answers += len(found)
                break
        if bench.now_ns >= next_ns:
            next_ns += FLUSH_MS * 10**6
            flush(log, packed)
    log.end()
    packed.close()
    check_work("answers", answers, polls, 0.1)
    print(f"{polls / SECONDS:.0f} polls a second", flush=True)
    return packed.length - begun


def typed(path: Path) -> int:
    """Record boards that a person types at; answers the number of bytes."""
    config: dict[str, object] = {
        "bench": "typed",
        "devices": {name: {"profile": "sac" if name[0] == "s" else "mechaduino"} for name in BOARDS},
    }
    bench, log, packed = recorder(config, path)
    bench.run(5000)
    flush(log, packed)
    begun = packed.length
    for second in range(SECONDS):
        name = list(BOARDS)[second % len(BOARDS)]
        for key in BOARDS[name]:
            bench.port(name).write(bytes([key]))
            bench.run(100)
            flush(log, packed)
        bench.run(1000 - 100 * len(BOARDS[name]))
        flush(log, packed)
    log.end()
    packed.close()
    return packed.length - begun


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "busy.hil.gz"
        per_hour_MB = busy(path) / SECONDS * 3600 / 1e6
        before_kB, begun_s = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.process_time()
        log = read_log(path)
        took_s = time.process_time() - begun_s
        grown_MB = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before_kB) / 1e3
        lines = len(log.inputs) + len(log.sent)
        extra: dict[str, object] = {"reference": "60 MB an hour", "lines_per_s": lines / SECONDS}
        report("recording_busy_MB_per_h", per_hour_MB, "MB", 60.0, 1.0, extra)
        extra = {"reference": "1000 MB", "read_s_per_h": took_s / SECONDS * 3600, "lines": lines}
        report("recording_read_MB_per_h", grown_MB / SECONDS * 3600, "MB", 1000.0, 1.0, extra)
        print(
            f"reading an hour: {took_s / SECONDS * 3600:.1f} s, {lines / SECONDS * 3600:.0f} lines",
            flush=True,
        )
        per_minute_MB = typed(Path(name) / "typed.hil.gz") / SECONDS * 60 / 1e6
        report("recording_typed_MB_per_min", per_minute_MB, "MB", 1.0, 1.0, {"reference": "1 MB a minute"})


if __name__ == "__main__":
    sys.exit(main())
