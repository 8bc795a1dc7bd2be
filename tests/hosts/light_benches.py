"""Program that stands for many benches: sessions as the bridge opens them, its tokens and a state
of one axis ten times a second, and nothing behind them.

Called as FIRST COUNT ENDPOINT SECONDS. It says ``up`` when all have joined, and begins with a line of input.
"""

import json
import select
import sys
import time

import zenoh

from bridges.zenoh.bench_session import open_session
from bridges.zenoh.options import Options

STATE_HZ = 10
KEY = "axis/m1/state"


def main() -> None:
    first, count, endpoint, seconds = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3], float(sys.argv[4])
    names = [f"light{number}" for number in range(first, first + count)]
    sessions = [open_session(Options(listen=[], connect=[endpoint]), name)[0] for name in names]
    kept = [
        session.liveliness().declare_token(f"hil/{name}/@live/{what}")
        for name, session in zip(names, sessions, strict=True)
        for what in ("daemon", "axis/m1")
    ]
    publishers = [
        session.declare_publisher(f"hil/{name}/{KEY}", congestion_control=zenoh.CongestionControl.DROP)
        for name, session in zip(names, sessions, strict=True)
    ]
    print("up", flush=True)
    sys.stdin.readline()
    began_s = time.monotonic()
    for sample in range(round(seconds * STATE_HZ)):
        for place, publisher in enumerate(publishers):  # spread over the interval, as clocks of benches are
            at_s = began_s + (sample + place / count) / STATE_HZ
            if (left_s := at_s - time.monotonic()) > 0:
                select.select([], [], [], left_s)
            state = {"n": sample, "sent_s": time.monotonic(), "position_deg": 90.0, "velocity_rpm": 0.0}
            publisher.put(json.dumps(state))
    print("sent", flush=True)
    sys.stdin.readline()
    for each in kept:
        each.undeclare()


if __name__ == "__main__":
    main()
