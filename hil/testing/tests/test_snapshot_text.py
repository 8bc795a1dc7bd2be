"""A snapshot as an assertion shows it: short."""

from hil.testing import Bench

CONFIG = {"bench": "b", "devices": {"m1": {"profile": "mechaduino"}, "s1": {"profile": "sac"}}}


def test_a_snapshot_is_short_and_says_what_matters() -> None:
    with Bench(CONFIG) as bench:
        bench.start()
        bench.port("m1").write(b"y")
        bench.run(500)
        servo, stepper = (repr(bench.axis(name).snapshot()) for name in ("m1", "s1"))
    assert servo.startswith("Snapshot(at 4.5 s, position_deg=6.3, velocity_rpm=")
    assert stepper.startswith("Snapshot(at 4.5 s, position_deg=0, velocity_rpm=0, commanded_deg=0,")
    assert max(len(servo), len(stepper)) < 200
