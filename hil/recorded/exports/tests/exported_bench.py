"""A bench with all kinds of lines, whose run the tests of exports take."""

from collections.abc import Callable
from io import StringIO
from typing import Any

from hil.recorded.recorded_run import RecordedRun
from hil.sim.input_log import InputLog
from hil.sim.log_reading import read_input_log
from hil.testing import Bench
from hil.vocab.time import SimTimeNs

CONFIG: dict[str, Any] = {
    "bench": "lines",
    "devices": {
        "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
        "m2": {"profile": "mechaduino", "flash": {"table": "identity"}},
        "s1": {"profile": "sac"},
        "s2": {"profile": "sac"},
        "s3": {"profile": "sac"},
    },
    "segments": {
        "bus0": {"stations": ["s2", "s3"], "taps": {"master": {"port": "memory"}}},
        "bus1": {
            "modbus": {"units": {"m1": 1, "m2": 2}},
            "baud": 19200,
            "format": "8E1",
            "taps": {"master": {}},
        },
    },
    "can": {"can0": {"bit_rate": 500000, "nodes": {"m1": 5, "m2": 6}}},
    "wires": [{"from": "s1.clk", "to": "m1.step"}, {"from": "s1.dir", "to": "m1.dir"}],
}
READ = bytes.fromhex("010400000001") + bytes.fromhex("31ca")
"""Request of Modbus: unit 1, input register 0."""


def drive(bench: Bench) -> None:
    """Type, step, ask, and let a fault be, at odd times."""
    bench.start()
    bench.run(0.3)
    for name in ("m1", "m2"):
        for text in (b"y", b"x"):
            bench.port(name).write(text)
            bench.run(40.7)
    bench.port("s1").write(b"m100v60\r")
    bench.run(2000)
    fault = bench.fault("shaft_load", "m1", torque_Nm=0.1)
    bench.port("s1").write(b"m-20v30\r")
    bench.run(1500.3)
    fault.clear()
    bench.tap("bus1.master").write(READ)
    bench.run(60)
    bench.tap("bus0.master").write(bytes.fromhex("55aa0011"))
    bench.run(50)
    bench.axis("m2").do("move_abs", position_deg=45)
    bench.run(301.3)


def recorded(run: Callable[[Bench], None] = drive, config: dict[str, Any] | None = None) -> InputLog:
    with Bench(config or CONFIG) as bench:
        run(bench)
        text = StringIO()
        bench.inputs.write_to(text)
    return read_input_log(text.getvalue().splitlines(keepends=True))


def opened(log: InputLog) -> tuple[RecordedRun, SimTimeNs]:
    """The run at its beginning, and its end."""
    run = RecordedRun(log)
    return run, run.end_ns
