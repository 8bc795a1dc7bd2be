"""Faults of all kinds at once, in any order of beginnings and ends: those in force are those listed.

The model is the list. The checks look at what the faults act on: axes, boards, stations, ways of bytes.
``HIL_FUZZ`` sets how many lives of a bench are tried (8; ``make fuzz``: 250), each of 30 steps and a replay.
"""

import io
import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from bridges.can.bus.bus_events import NodeState
from device_profiles.sac.packet import PacketDecoder, encode
from hil.compose.replay import replay
from hil.sim.bench import BenchHooks
from hil.sim.input_log import InputLogWriter
from hil.sim.twin import Twin
from hil.testing import Bench
from hil.vocab.faults import (
    CAN_NODE,
    DEVICE,
    FAULT_KINDS,
    LINE,
    MODBUS_NODE,
    ON_LINE,
    PORT,
    SEGMENT,
    SERVO,
    SHAFT,
    STATION,
    SUPPLIED,
    TWIN_PORT,
)

CONFIG: dict[str, Any] = {
    "bench": "f",
    "devices": {
        "s1": {"profile": "sac"},
        "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
        "m2": {"profile": "mechaduino", "flash": {"table": "identity"}, "plant": "full"},
    },
    "segments": {
        "bus0": {"stations": ["s1"], "taps": {"master": {"port": "memory"}}},
        "bus1": {"modbus": {"units": {"m1": 1}}},
    },
    "can": {"can0": {"nodes": {"m2": 2}, "taps": {"a": {"port": "memory"}}}},
}
PLACES = {
    PORT: ["s1", "s1.network", "m1", "m2"],
    TWIN_PORT: ["s1", "m1", "m2"],
    STATION: ["s1.network", "bus0.master"],
    SEGMENT: ["bus0"],
    DEVICE: ["s1", "m1", "m2"],
    SHAFT: ["s1", "m1", "m2"],
    SERVO: ["m1", "m2"],
    SUPPLIED: ["m2"],
    MODBUS_NODE: ["m1.modbus"],
    LINE: ["bus0", "can0"],
    ON_LINE: ["s1.network", "bus0.master", "m2.canopen", "can0.a"],
    CAN_NODE: ["m2.canopen", "can0.a"],
}
MODEST = {
    "rate": st.sampled_from([0.0, 0.01, 0.5, 1.0]),
    "delay_ms": st.sampled_from([0.0, 5.0]),
    "seed": st.integers(0, 3).map(float),
    "late_us": st.sampled_from([0.0, 500.0, 4000.0]),
    "bytes": st.integers(1, 10).map(float),
    "every_ms": st.sampled_from([40.0, 90.0]),
    "address": st.sampled_from([85.0, 9.0]),
    "torque_Nm": st.sampled_from([-0.02, 0.01, 0.005]),  # however many, no motor refuses them
    "turn_deg": st.sampled_from([-7.2, 90.0]),
    "supply_V": st.sampled_from([0.0, 6.0, 10.0]),
    "code": st.sampled_from([1.0, 255.0]),
    "late_ms": st.sampled_from([0.0, 9.0]),
    "unit": st.sampled_from([0.0, 247.0]),
    "bit_rate": st.sampled_from([250_000.0, 500_000.0]),
    "counts": st.integers(0, 300).map(float),
}
"""Values of parameters that are numbers; words are drawn from the table."""
MS = 1_000_000
STRONG_NM = 0.3
NOMINAL_V = 24.0


@st.composite
def begun(draw: st.DrawFn) -> tuple[str, str, dict[str, float | str]]:
    """Random fault: its kind, where it is, all its parameters. No part here is on a bus, as an arm's."""
    here = sorted(name for name, kind in FAULT_KINDS.items() if kind.target in PLACES)
    kind = FAULT_KINDS[draw(st.sampled_from(here))]
    parameters: dict[str, float | str] = {
        each.name: draw(st.sampled_from(each.choices) if each.choices else MODEST[each.name])
        for each in kind.parameters
    }
    parameters["start_s"] = draw(st.sampled_from([0.0, 0.0, 0.1, 0.3]))
    parameters["for_s"] = draw(st.sampled_from([0.0, 0.0, 0.1, 0.25]))
    return kind.name, draw(st.sampled_from(PLACES[kind.target])), parameters


@dataclass
class Entry:
    """Entry of the model's list."""

    number: int
    kind: str
    target: str
    parameters: dict[str, Any]
    begin_ns: int
    end_ns: float


class Later:
    """Memory that is written when the test says so: the answer is an input of the log, as a daemon's."""

    def __init__(self) -> None:
        self.asked: list[Callable[[bool], bool]] = []

    def commit(
        self, device: Twin, sections: Mapping[str, bytes], answered: Callable[[bool], bool]
    ) -> bool | None:
        self.asked.append(answered)
        return None


@dataclass
class Rig:
    """A bench whose inputs are logged."""

    log: io.StringIO = field(default_factory=io.StringIO)
    store: Later = field(default_factory=Later)

    def __post_init__(self) -> None:
        with Bench(CONFIG) as fresh:
            memories = {name: device.nvm for name, device in fresh._runtime.devices.items()}
        writer = InputLogWriter(self.log, "test", CONFIG, memories)
        self.bench = Bench(CONFIG, store=self.store, around=BenchHooks(log=writer))
        self.runtime = self.bench._runtime
        self.wire: Any = self.runtime.segments["bus0"]
        self.master = self.bench.tap("bus0.master")
        self.run(4500)

    def run(self, ms: float) -> None:
        self.bench.run(ms=ms)
        asked, self.store.asked = self.store.asked, []
        for answered in asked:
            answered(True)

    def field(self, name: str, what: str) -> float:
        return float(getattr(self.bench.axis(name).snapshot(), what))

    def answers(self) -> list[bytes]:
        """Answers of boards and nodes by which an untouched bench can be told."""
        for name in CONFIG["devices"]:
            self.bench.port(name).read()
        self.master.read()
        said = []
        for name, line in (("s1", b"vd\r"), ("m1", b"p"), ("m2", b"p")):
            self.bench.port(name).write(line)
            self.run(400)
            said.append(self.bench.port(name).read().split(b"Angle")[0])
        self.master.write(encode(85, 1, b"y"))
        self.run(50)
        return [*said, *(item.raw for item in PacketDecoder().feed(self.master.read()))]

    def pushed_deg(self, name: str) -> float:
        """Angle by which a load beside the one that is there moves the shaft in 5 ms."""
        axis = self.bench.axis(name)
        set_Nm = self.runtime.devices[name].axis.set_load_Nm  # without that of faults
        before_deg = self.field(name, "position_deg")
        axis.load_torque_Nm = set_Nm + STRONG_NM
        self.run(5)
        axis.load_torque_Nm = set_Nm
        return abs(self.field(name, "position_deg") - before_deg)


@cache
def untouched() -> list[bytes]:
    return Rig().answers()


class Overlaps(RuleBasedStateMachine):
    def __init__(self) -> None:
        super().__init__()
        self.rig = Rig()
        self.bench = self.rig.bench
        self.entries: dict[int, Entry] = {}
        self.loads_Nm = {name: 0.0 for name in CONFIG["devices"]}
        self.frozen: dict[str, tuple[set[int], float]] = {}

    # ---- what happens ----

    @rule(fault=begun())
    def begin(self, fault: tuple[str, str, dict[str, float | str]]) -> None:
        kind, target, parameters = fault
        number = self.bench.fault(kind, target, **parameters).number
        begin_ns = self.bench.now_ns + round(float(parameters["start_s"]) * 1e9)
        for_ns = round(float(parameters["for_s"]) * 1e9)
        end_ns = begin_ns + for_ns if for_ns else math.inf
        if FAULT_KINDS[kind].is_once:
            end_ns = begin_ns
        self.entries[number] = Entry(number, kind, target, dict(parameters), begin_ns, end_ns)

    @precondition(lambda self: self.entries)
    @rule(data=st.data())
    def clear(self, data: st.DataObject) -> None:
        number = data.draw(st.sampled_from(sorted(self.entries)))
        self.rig.runtime.clear_fault(number)
        del self.entries[number]

    @rule(name=st.sampled_from(["s1", "m1", "m2"]))
    def reset(self, name: str) -> None:
        self.bench.device(name).reset()

    @rule(name=st.sampled_from(["s1", "m1", "m2"]), torque_Nm=st.sampled_from([-0.1, 0.0, 0.03]))
    def load(self, name: str, torque_Nm: float) -> None:
        self.bench.axis(name).load_torque_Nm = self.loads_Nm[name] = torque_Nm

    @rule(ms=st.sampled_from([1, 50, 100, 250, 2000]))
    def time_passes(self, ms: int) -> None:
        self.rig.run(ms)

    @rule(name=st.sampled_from(["s1", "m1", "m2"]), line=st.sampled_from([b"vd\r", b"p", b"s", b"q"]))
    def typed(self, name: str, line: bytes) -> None:
        self.bench.port(name).write(line)

    @rule()
    def asked(self) -> None:
        self.rig.master.write(encode(85, 1, b"y"))

    # ---- what is to be ----

    def on(self, target: str, *kinds: str) -> list[Entry]:
        """Faults in force on a device, or on exactly this target, in the order in which they began."""
        now_ns = self.bench.now_ns
        in_force = [each for each in self.entries.values() if each.begin_ns <= now_ns < each.end_ns]
        here = [
            each
            for each in in_force
            if each.kind in kinds and target in (each.target, each.target.partition(".")[0])
        ]
        return sorted(here, key=lambda each: (each.begin_ns, each.number))

    @invariant()
    def list_is_what_was_asked_for(self) -> None:
        self.entries = {n: each for n, each in self.entries.items() if each.end_ns > self.bench.now_ns}
        assert set(self.rig.runtime.faults.active) == set(self.entries)

    @invariant()
    def boards(self) -> None:
        for name, device in self.rig.runtime.devices.items():
            is_off = bool(self.on(name, "node_brown_out"))
            assert ("no power" in (device.failed or "")) == is_off, device.failed
            if is_off:
                assert int((device.failed or "").split()[-1].strip(")")) in self.entries
            assert device.is_hung == bool(self.on(name, "node_hang"))

    @invariant()
    def ways_of_bytes(self) -> None:
        bytes_kinds = [kind.name for kind in FAULT_KINDS.values() if kind.layer == "byte"]
        for name, device in self.rig.runtime.devices.items():
            for port, uart in device.uarts.items():
                target = name if port == "main" else f"{name}.{port}"
                here = [
                    each
                    for each in self.on(target, *bytes_kinds, "host_close", "host_stop_reading")
                    if each.target == target
                ]
                rx = [e.number for e in here if e.parameters.get("towards") == "board"]
                rx += [e.number for e in here if e.kind == "host_close"]
                tx = [e.number for e in here if e.parameters.get("towards") != "board"]
                assert list(uart.rx_faults) == sorted(rx, key=[e.number for e in here].index)
                assert list(uart.tx.faults) == tx

    @invariant()
    def wire(self) -> None:
        wire = self.rig.wire
        assert list(wire.noise) == [each.number for each in self.on("bus0", "wire_noise")]
        clashes = {f"fault {each.number}" for each in self.on("bus0", "node_clash")}
        assert set(wire.stations) == {"s1.network", "bus0.master"} | clashes
        packet_kinds = [kind.name for kind in FAULT_KINDS.values() if kind.layer == "packet"]
        for target in PLACES[STATION]:
            station = wire.stations[target]
            assert station.is_cut == bool(self.on(target, "wire_cut"))
            assert station.is_swapped == bool(self.on(target, "wire_swapped"))
            assert station.is_stuck == bool(self.on(target, "driver_stuck"))
            late = self.on(target, "driver_late")
            assert station.release_ns == (late[-1].parameters["late_us"] * 1000 if late else 0)
            assert list(station.transforms) == [each.number for each in self.on(target, *packet_kinds)]

    @invariant()
    def nodes(self) -> None:
        kinds = [kind.name for kind in FAULT_KINDS.values() if kind.target == MODBUS_NODE]
        active = self.rig.runtime.cards["m1.modbus"].faults.numbers
        assert active == [each.number for each in self.on("m1.modbus", *kinds)]

    @invariant()
    def bus(self) -> None:
        of = self.rig.runtime.wires["can0"]
        bus: Any = of.bus
        faults: Any = of._faults
        assert list(faults._noises) == [each.number for each in self.on("can0", "wire_noise")]
        kinds = ("wire_cut", "driver_stuck", "packet_no_ack", "bit_rate_wrong")
        for target in PLACES[CAN_NODE]:
            assert list(bus.nodes[target].wire_faults) == [each.number for each in self.on(target, *kinds)]
        has_power = not self.on("m2", "node_brown_out")
        assert (bus.state("m2.canopen") != NodeState.OFF) == has_power

    @invariant()
    def shafts(self) -> None:
        for name in CONFIG["devices"]:
            loads = [each.parameters["torque_Nm"] for each in self.on(name, "shaft_load")]
            assert self.rig.field(name, "load_torque_Nm") == self.loads_Nm[name] + math.fsum(loads)
            if self.on(name, "shaft_jam"):
                assert self.rig.field(name, "velocity_rpm") == 0
        sags = self.on("m2", "supply_sag")
        supply_V = sags[-1].parameters["supply_V"] if sags else NOMINAL_V
        assert self.rig.runtime.devices["m2"].axis.supply_V() == supply_V

    @invariant()
    def coils(self) -> None:
        state = self.bench.axis("m1").snapshot()
        off = self.on("m1", "thermal_trip", "node_brown_out")
        broken = {each.parameters["coil"] for each in self.on("m1", "phase_open")}
        for coil, current_A, told in (
            ("A", state.current_a_A, state.vref1 * (state.in2 - state.in1)),
            ("B", state.current_b_A, state.vref2 * (state.in4 - state.in3)),
        ):
            assert (current_A == 0) == bool(off or coil in broken or not told)

    @invariant()
    def encoder(self) -> None:
        raw, frozen = self.rig.field("m1", "raw"), {each.number for each in self.on("m1", "encoder_freeze")}
        before, count = self.frozen.pop("m1", (set(), 0.0))
        if self.on("m1", "encoder_disconnect"):
            assert raw == 16383
        elif frozen:
            if frozen & before:
                assert raw == count
            self.frozen["m1"] = frozen, raw
        elif not any(each.parameters["counts"] for each in self.on("m1", "encoder_noise")[-1:]):
            slips = sum(each.parameters["counts"] for each in self.on("m1", "encoder_slip"))
            rev = self.rig.field("m1", "position_deg") / 360
            assert abs((raw - slips - int(rev % 1 * 16384) + 8192) % 16384 - 8192) <= 1

    @rule(name=st.sampled_from(["m1", "m2"]))
    def push(self, name: str) -> None:
        is_jammed = bool(self.on(name, "shaft_jam"))
        moved_deg = self.rig.pushed_deg(name)
        if is_jammed and self.on(name, "shaft_jam"):
            assert moved_deg == 0
        elif not is_jammed and not self.on(name, "shaft_jam"):
            assert moved_deg > 0.01

    def teardown(self) -> None:
        for number in list(self.rig.runtime.faults.active):
            self.rig.runtime.clear_fault(number)
        self.entries.clear()
        for name in CONFIG["devices"]:
            self.load(name, 0.0)
            self.bench.device(name).reset()
        self.rig.run(5000)
        self.rig.run(5000)
        of_lines = (self.ways_of_bytes, self.wire, self.nodes, self.bus)
        for check in (self.boards, *of_lines, self.shafts, self.coils, self.encoder):
            check()
        adapter = self.bench.tap("can0.a")
        for line in (b"S6\rO\r", b"t00028102\r"):  # reset node 2
            adapter.write(line)
            self.rig.run(5)
        assert b"t702100\r" in adapter.read()
        for name in ("m1", "m2"):
            assert self.rig.pushed_deg(name) > 0.01
        assert self.rig.answers() == untouched()
        self.rig.log.seek(0)
        assert replay(self.rig.log).difference() is None


TestOverlaps = pytest.mark.thorough(Overlaps.TestCase)
TestOverlaps.settings = settings(max_examples=int(os.environ.get("HIL_FUZZ", "8")), stateful_step_count=30)
