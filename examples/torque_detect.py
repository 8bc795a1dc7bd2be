"""Torque detect: push the shaft, and it goes on by 90 degrees in the direction of the push.

The push shows in the effort u with which the position loop answers it.
"""

from board import holding, move_to

PUSHES = {5: 0.15, 20: 0.15, 35: -0.15}
"""Tenths of a second at which a push of so many newton metres begins; it lasts a tenth."""


def main() -> None:
    bench = holding()
    for tenth in range(50):
        bench.axis("m1").load_torque_Nm = PUSHES.get(tenth, 0.0)
        bench.run(ms=100)
        now = bench.axis("m1").snapshot()
        if abs(now.u) > 35:
            to = now.r - 90 if now.u > 0 else now.r + 90
            print(f"{tenth / 10:.1f} s: effort {now.u:6.1f}, so from {now.r:.0f} to {to:.0f} deg")
            bench.axis("m1").load_torque_Nm = 0.0
            move_to(bench, to)
            bench.run(ms=300)
    print(f"at the end {bench.axis('m1').snapshot().yw:.1f} deg")


if __name__ == "__main__":
    main()
