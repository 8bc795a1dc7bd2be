"""A test of ``master.py``, a program without code of hil, against 32 nodes with faults."""

import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent


def test_a_node_that_does_not_answer_is_told(live_bench):
    bus = live_bench(HERE / "bench.yaml")
    for address in range(4, 36):
        bus.type(f"s{address}", b"$CM%d\r" % address, b"$R\r", until=b"SAC>")
    bus.hil("fault", "inject", "packet_no_ack", "s7.network")
    master = [sys.executable, HERE / "master.py", bus.port("bus0.master"), "v120", "4", "35"]
    report = subprocess.run(master, capture_output=True, text=True, timeout=60).stdout
    assert report == "node 7: silence, silence, silence\n31 nodes have it, 1 have not\n"
