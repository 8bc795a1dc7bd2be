"""The two ramps of a SAC: harmonic and linear, from a stop to 100 RPM, each with 600 steps.

`python sac_ramps.py ramps.svg` draws the speed of both over time (needs the extra `plot`).
"""

import sys
from pathlib import Path

from hil.telemetry import Recording
from hil.testing import Bench

COMMANDS = {"harmonic": b"m600v100a1d1l0\r", "linear": b"m600v100l1a10.47d10.47\r"}


def turn(command: bytes) -> tuple[Recording, list[int]]:
    """The recorded speed, and the times of the pulses in ns."""
    bench = Bench({"bench": "examples", "devices": {"s1": {"profile": "sac"}}})
    bench.run(ms=1500)
    bench.port("s1").write(b"$CJ0\r$R\r")  # full steps: one pulse each
    bench.run(ms=500)
    recording = bench.axis("s1").record("speed_rpm", interval_ms=1)
    bench.port("s1").write(command)
    bench.run(ms=4000)
    return recording, [at_ns for at_ns, level in bench.device("s1").pin("clk").edges() if level]


def main() -> None:
    recordings = {}
    for name, command in COMMANDS.items():
        recordings[name], pulses = turn(command)
        ramp_ms = (pulses[90] - pulses[0]) / 1e6
        total_ms = (pulses[-1] - pulses[0]) / 1e6
        print(f"{name:8}: {len(pulses)} pulses in {total_ms:.3f} ms, the first 90 in {ramp_ms:.3f} ms")
    if len(sys.argv) > 1:
        from hil.telemetry import picture

        picture.draw(recordings, Path(sys.argv[1]), "a SAC turns 600 steps at 100 RPM")


if __name__ == "__main__":
    main()
