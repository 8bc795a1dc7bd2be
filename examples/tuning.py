"""Tuning: a step response with the factory's gains and with others, edited over the serial menu.

The shaft turns a flywheel of nine times the rotor's inertia, which the factory's gains brake too late.
`python tuning.py tuning.svg` draws both in one picture (needs the extra `plot`).
"""

import sys
from pathlib import Path

from board import holding, move_to

from hil.telemetry import Recording, step_response

GAINS = {"factory": {}, "tuned": {"p": 25.0, "i": 0.2, "d": 900.0}}
"""Letters of the board's menu k, p: proportional, integral, derivative gain of the position loop."""


def respond(gains: dict[str, float]) -> Recording:
    """A step of 90 degrees with these gains."""
    bench = holding(axis={"inertia_kg_m2": 10 * 5.4e-6})
    if gains:
        edits = "".join(f"{letter}{value}\n" for letter, value in gains.items())
        bench.port("m1").write(f"kp{edits}q".encode())
        bench.run(ms=500)
    recording = bench.axis("m1").record("r", "yw", "u", interval_ms=0.25)
    bench.run(ms=20)
    move_to(bench, 90)
    bench.run(ms=400)
    return recording


def main() -> None:
    responses = {name: respond(gains) for name, gains in GAINS.items()}
    for name, recording in responses.items():
        print(f"{name:8}", step_response(recording).line("deg"))
    if len(sys.argv) > 1:
        from hil.telemetry import picture

        picture.draw(
            responses, Path(sys.argv[1]), "a step of 90 deg with nine times the rotor's inertia on the shaft"
        )


if __name__ == "__main__":
    main()
