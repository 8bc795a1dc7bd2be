"""moveRel and moveAbs: moves with a trapezoidal speed, by pulse trains on the step and direction inputs."""

from board import holding

from hil.testing import Bench
from hil.wire.step_dir import generate, train_length_ns

STEP_DEG = 1.8 / 32


def move_rel(bench: Bench, degrees: float, speed_deg_per_s: float, acceleration_deg_per_s2: float) -> None:
    """Start a move by so many degrees; wait for its end while printing where the shaft is."""
    rate_Hz, acceleration = speed_deg_per_s / STEP_DEG, acceleration_deg_per_s2 / STEP_DEG
    train = generate(round(degrees / STEP_DEG), rate_Hz, acceleration)
    bench.device("m1").drive(train)
    for _ in range(8):
        bench.run(ms=train_length_ns(train) / 8e6)
        now = bench.axis("m1").snapshot()
        print(
            f"  set-point {now.r:7.2f} deg, speed {now.velocity_rpm * 6:6.1f} deg/s, error {now.e:6.3f} deg"
        )


def move_abs(bench: Bench, degrees: float, speed_deg_per_s: float, acceleration_deg_per_s2: float) -> None:
    """The same, to an angle."""
    move_rel(bench, degrees - bench.axis("m1").snapshot().r, speed_deg_per_s, acceleration_deg_per_s2)


def main() -> None:
    bench = holding()
    print("by 360 deg, at most 100 deg/s and 30 deg/s2:")
    move_rel(bench, 360, 100, 30)
    bench.run(ms=2000)
    print("to 0 deg:")
    move_abs(bench, 0, 100, 30)
    bench.run(ms=2000)
    print(f"at the end {bench.axis('m1').snapshot().yw:.2f} deg")


if __name__ == "__main__":
    main()
