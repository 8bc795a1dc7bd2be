"""Delay from a program at a segment's tap to the wire, and from the wire back to it, in real time.

A frame that is written to a pty tap should be on the wire within 2 ms (99th percentile), and its ACK at the
tap within 2 ms of its simulated end. The wire's times are those of a capture.
"""

import os
import select
import statistics
import subprocess
import sys
import tempfile
import time
import tty
from pathlib import Path

from device_profiles.sac.packet import encode
from hil.wire.pcapng import read

ROUNDS = 200 if "--quick" in sys.argv else 2000
ACK_NS = 7 * 10 * 10**9 // 38400
BENCH = """bench: b
devices:
  s1: {profile: sac}
segments:
  bus0: {stations: [s1], taps: {master: {port: pty}}}
"""


def main() -> None:
    hil = Path(sys.executable).with_name("hil")
    with tempfile.TemporaryDirectory(prefix="hil-") as folder:
        Path(folder, "b.yaml").write_text(BENCH)
        where = ["--runtime-dir", folder]
        command = [hil, "serve", f"{folder}/b.yaml", *where, "--state-dir", folder]
        daemon = subprocess.Popen(command, stdout=subprocess.PIPE)
        assert daemon.stdout
        while b"Ctrl-C" not in daemon.stdout.readline():
            pass
        path = Path(folder, "c.pcapng")
        capture = subprocess.Popen([hil, "capture", "bus0", "-w", path, *where])
        fd = os.open(f"{folder}/b/bus0.master", os.O_RDWR | os.O_NOCTTY)
        tty.setraw(fd)
        select.select([fd], [], [], 1.5)  # past the cold start
        written, answered = [], []
        for _ in range(ROUNDS):
            written.append(time.time_ns())
            os.write(fd, encode(85, 1, b"y"))
            got = b""
            while len(got) < 7:
                assert select.select([fd], [], [], 5)[0], "no answer within 5 s"
                got += os.read(fd, 100)
            answered.append(time.time_ns())
        select.select([fd], [], [], 0.3)
        capture.terminate()
        capture.wait()
        daemon.terminate()
        daemon.wait()
        records = list(read(path.read_bytes()))
    to_wire = [each.at_ns - at_ns for each, at_ns in zip(records[::2], written, strict=True)]
    back = [at_ns - each.at_ns - ACK_NS for each, at_ns in zip(records[1::2], answered, strict=True)]
    for name, late_ns in (("to the wire", to_wire), ("back at the tap", back)):
        p99 = sorted(late_ns)[int(len(late_ns) * 0.99)]
        print(
            f"{name:16} median {statistics.median(late_ns) / 1e6:.3f} ms  p99 {p99 / 1e6:.3f} ms, wanted 2 ms"
        )


main()
