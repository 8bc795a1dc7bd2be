"""A SAC that drives a Mechaduino: clk to step, dir to dir; when its motion ends, a second SAC starts."""

from hil.testing import Bench

CONFIG = """
bench: examples
devices:
  s1: {profile: sac}
  s2: {profile: sac}
  m1: {profile: mechaduino, flash: {table: identity}}
wires:
  - {from: s1.clk, to: m1.step}
  - {from: s1.dir, to: m1.dir}
  - {from: s1.OP_SA, to: s2.sync}
"""


def main() -> None:
    bench = Bench(CONFIG)
    bench.run(ms=4000)
    bench.port("m1").write(b"xy")  # position mode, loop on
    bench.run(ms=1000)
    angle_deg = bench.axis("m1").snapshot().position_deg
    bench.port("s2").write(b"m100s\r")  # held by its sync input
    bench.port("s1").write(b"m1600v300\r")
    bench.run(ms=8000)

    clk = [at_ns for at_ns, level in bench.device("s1").pin("clk").edges() if level]
    op_sa = bench.device("s1").pin("OP_SA").edges()
    turned_deg = bench.axis("m1").snapshot().position_deg - angle_deg
    print(f"s1: {len(clk)} pulses in {(clk[-1] - clk[0]) / 1e6:.3f} ms")
    print(f"m1: the shaft turned by {abs(turned_deg):.1f} deg, a pulse is 1.8 / 32 deg")
    start_ns = bench.device("s2").pin("clk").edges()[0][0]
    print(f"s2: its first pulse came {start_ns - op_sa[-1][0]} ns after s1's command ended")


if __name__ == "__main__":
    main()
