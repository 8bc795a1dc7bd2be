"""Print: set-point, error and effort ten times a second, while a load comes and goes."""

from board import holding


def main() -> None:
    bench = holding()
    for tenth in range(20):
        bench.axis("m1").load_torque_Nm = 0.1 if 5 <= tenth < 15 else 0.0
        bench.run(ms=100)
        now = bench.axis("m1").snapshot()
        print(f"setpoint: {now.r:.2f}, error: {now.e:6.3f}, effort: {now.u:6.2f}")


if __name__ == "__main__":
    main()
