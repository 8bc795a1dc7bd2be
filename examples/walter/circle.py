"""The arm draws a circle: MOVETO ten times a second over its serial port, as a trajectory server does.

    python examples/walter/circle.py [FILE]    draws how well it followed into FILE (circle.png)

Hip and forearm draw the circle in the plane of their angles. In the second round the forearm loses its
encoder just after it has passed the top: from then on the controller counts pulses, and does not see that
the joint is held for a moment.
"""

import math
import sys
import time
from pathlib import Path

import matplotlib.pyplot as plt
import serial

from hil.testing import ServedBench, live

BENCH = {"bench": "circle", "devices": {"w1": {"profile": "walter"}}}
STEP_S = 0.1
STEPS = 60
RADIUS_DEG, CENTRE_DEG = 20.0, -25.0
LOST_AT, HELD_AT, FREE_AT = 15, 18, 24
Points = list[tuple[float, float]]


def target_deg(step: int) -> tuple[float, float]:
    """Angles of hip and forearm at a step of the circle."""
    angle = 2 * math.pi * step / STEPS
    return RADIUS_DEG * math.sin(angle), CENTRE_DEG + RADIUS_DEG * math.cos(angle)


def ask(port: serial.Serial, line: str) -> str:
    """Send a command; answers its reply, without the prompt."""
    port.write(line.encode() + b"\r")
    said = b""
    while not (said.endswith(b"\r\n>") and b">" in said[:-1]):
        got = port.read(1)
        if not got:
            raise TimeoutError(f"no reply to {line}: {said!r}")
        said += got
    return said.decode().removesuffix("\r\n>")


def where_deg(bench: ServedBench) -> tuple[float, float]:
    """Angles of hip and forearm: on the real arm nobody could measure them without an encoder."""
    hip, forearm = (bench.ask("state", device=f"w1.{name}") for name in ("hip", "forearm"))
    return hip["position_deg"], forearm["position_deg"]


def draw(bench: ServedBench, port: serial.Serial, *, loses_encoder: bool) -> Points:
    """Draw one circle; answers where the arm was at each step."""
    hip, forearm = target_deg(0)
    ask(port, f"MOVETO {hip:.2f} 0 {forearm:.2f} 0 0 0 0 1000")
    time.sleep(1.5)
    drawn, begun_s = [], time.monotonic()
    for step in range(1, STEPS + 1):
        hip, forearm = target_deg(step)
        ask(port, f"MOVETO {hip:.2f} 0 {forearm:.2f} 0 0 0 0 {STEP_S * 1000:.0f}")
        if loses_encoder and step == LOST_AT:
            bench.ask("inject", fault="bus_no_answer", target="w1.forearm", parameters={})
        if loses_encoder and step == HELD_AT:
            held_s = (FREE_AT - HELD_AT) * STEP_S
            bench.ask("inject", fault="shaft_jam", target="w1.forearm", parameters={"for_s": held_s})
        time.sleep(max(0.0, begun_s + step * STEP_S - time.monotonic()))
        drawn.append(where_deg(bench))
    return drawn


def off_deg(drawn: Points) -> float:
    """Greatest distance from the circle, whatever the place on it."""
    return max(abs(math.hypot(hip, forearm - CENTRE_DEG) - RADIUS_DEG) for hip, forearm in drawn)


def picture(rounds: dict[str, Points], file: Path) -> None:
    figure, axes = plt.subplots(figsize=(5.2, 6.2), layout="constrained")
    circle = [target_deg(step) for step in range(STEPS + 1)]
    axes.plot(*zip(*circle, strict=True), color="0.7", linewidth=6, label="asked for")
    for name, drawn in rounds.items():
        axes.plot(*zip(*drawn, strict=True), marker=".", label=name)
    axes.set_xlabel("hip [deg]")
    axes.set_ylabel("forearm [deg]")
    axes.set_aspect("equal")
    axes.legend(loc="center")
    figure.savefig(file, dpi=120)


def main() -> None:
    file = Path(sys.argv[1] if len(sys.argv) > 1 else "circle.png")
    with live(BENCH) as bench, serial.Serial(bench.port("w1"), 115200, timeout=10) as port:
        for command in ("CHECKSUM off", "POWER on", "ENABLE"):
            print(command, ask(port, command))
        rounds = {
            "with its encoders": draw(bench, port, loses_encoder=False),
            "the forearm without": draw(bench, port, loses_encoder=True),
        }
    for name, drawn in rounds.items():
        print(f"{name}: {off_deg(drawn):.1f} deg off the circle at most")
    picture(rounds, file)
    print(file)


if __name__ == "__main__":
    main()
