"""Slow moves: to 90 degrees and back at constant speed, by a pulse train on the step and direction inputs."""

from board import holding

from hil.wire.step_dir import generate

STEP_DEG = 1.8 / 32


def main() -> None:
    bench = holding()
    steps = round(90 / STEP_DEG)
    for direction in (1, -1):
        bench.device("m1").drive(generate(direction * steps, rate_hz=steps / 0.9))
        for _ in range(10):
            bench.run(ms=100)
            now = bench.axis("m1").snapshot()
            print(f"set-point {now.r:6.2f}, shaft {now.yw:6.2f}, behind by {now.e:6.3f} deg")
        bench.run(ms=2000)


if __name__ == "__main__":
    main()
