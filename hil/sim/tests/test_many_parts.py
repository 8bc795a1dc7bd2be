"""Boards with several UARTs and axes, with no axis and with no UART, by their addresses."""

import io
import json
from collections.abc import Mapping
from functools import partial
from typing import Any

import pytest

from hil.core import Core
from hil.sim.bench import BenchHooks, BenchRuntime
from hil.sim.given_fault import fault_refusal
from hil.sim.hardware import DeviceSpec
from hil.sim.input_log import InputLogWriter
from hil.sim.inputs import Bytes, Do, Follow, Pin, SetField
from hil.sim.setpoints import TimeOut
from hil.sim.tests.session_bench import PARAMETERS
from hil.testing.memory_store import MemoryStore
from hil.vocab.axis_plan import AxisPlan
from hil.vocab.faults import FaultRefused
from hil.vocab.firmware import Board, ByteAvailable, CoreEvent, Main
from hil.vocab.parameters import Parameter
from hil.vocab.path import PathPiece
from hil.vocab.time import NS_PER_MS, SimTimeNs
from hil.vocab.verbs import Effect, Verb, VerbRefused, table_of

STEPPER = {"phase_current_A": 1.0, "driver": 0} | {n: v for n, v in PARAMETERS.items() if n[:5] != "sense"}


class Arm:
    """Says at which UART a byte came, and which axis an interrupt was of."""

    def __init__(self, board: Board) -> None:
        self.board = board

    def main(self) -> Main:
        while True:
            yield ByteAvailable()
            for name, uart in self.board.uarts.items():
                for byte in uart.read_all():
                    uart.write(f"{name}:{byte:c};".encode())

    def interrupt(self, event: CoreEvent) -> None:
        self.board.uart.write(f"{event.kind} of {event.axis};".encode())


def aim(arm: Arm, axis: str, r: float) -> Mapping[str, float]:
    arm.board.axes[axis].set("r", r)
    return {"r": r}


def park(arm: Arm) -> None:
    for axis in arm.board.axes.values():
        axis.loop(False)


def follow(arm: Arm, path: tuple[PathPiece, ...], start_ns: int, axis: str) -> None:
    arm.board.axes[axis].follow(path, start_ns)


def starve(arm: Arm, policy: str, acceleration_rpm_per_s: float, axis: str) -> None:
    arm.board.axes[axis].set("r", -1.0)


VERBS = table_of(
    (
        Verb("aim", "", (Parameter("r", "", maximum=10),), aim, Effect.STREAM, is_of_axis=True),
        Verb("park", "", run=park, effect=Effect.ENDS),
    )
)


class Rig:
    """A bench with an arm (shoulder and elbow are servos, the grip a stepper) and a pinger without axes."""

    def __init__(self, timeout_ms: int = 0) -> None:
        self.log = io.StringIO()
        around = BenchHooks(log=InputLogWriter(self.log, "test", {}, {}))
        self.runtime = BenchRuntime("test", Core(8), MemoryStore(), around)
        self.heard: list[tuple[str, str]] = []
        time_out = TimeOut(timeout_ms * NS_PER_MS, "hold", 1.0, starve) if timeout_ms else None
        servo, stepper = AxisPlan(PARAMETERS, law="mechaduino"), AxisPlan(STEPPER, law="sac")
        axes = {"shoulder": servo, "elbow": servo, "grip": stepper}
        self._add("arm", {"main": None, "logger": 115200, "bus": 9600}, axes, time_out)
        self._add("pinger", {"main": None}, {}, None)
        self.arm = self.runtime.devices["arm"]

    def _add(
        self, name: str, bauds: Mapping[str, int | None], axes: Mapping[str, AxisPlan], time_out: Any
    ) -> None:
        group = self.runtime.open_group()
        spec = DeviceSpec(
            name=name, profile="t", firmware=Arm, bauds=bauds, nvm={}, facts={}, verbs=VERBS,
            power_up={"elbow": {"diaagc": 0x123}}, time_out=time_out, follow=follow,
        )  # fmt: skip
        device = self.runtime.make(spec, axes, group)
        for uart in device.uarts:
            device.uarts[uart].listeners.append(partial(self._hear, device.uarts.label(name, uart)))
        self.runtime.add(group, device)

    def _hear(self, at: str, at_ns: int, data: bytes) -> None:
        self.heard.append((at, data.decode()))

    def run(self, ms: float) -> None:
        self.runtime.advance(SimTimeNs(self.runtime.now_ns + round(ms * NS_PER_MS)))

    def value(self, axis: str, field: str) -> float:
        return float(getattr(self.runtime.snapshot(axis), field))

    def inputs(self) -> list[dict[str, Any]]:
        lines = map(json.loads, self.log.getvalue().splitlines()[1:])
        return [line for line in lines if "input" in line]


@pytest.fixture
def rig() -> Rig:
    made = Rig()
    made.run(1)
    return made


def test_each_uart_has_bytes_of_its_own(rig: Rig) -> None:
    for uart in ("", "logger", "bus"):
        rig.runtime.apply_to(rig.arm, Bytes(b"x", port=uart))
    rig.run(10)
    assert sorted(rig.heard) == [("arm", "main:x;"), ("arm.bus", "bus:x;"), ("arm.logger", "logger:x;")]
    assert [line.get("port") for line in rig.inputs()] == [None, "logger", "bus"]


def test_each_axis_has_an_address(rig: Rig) -> None:
    assert list(rig.runtime.parts.axes) == ["arm", "arm.elbow", "arm.grip"]
    assert rig.runtime.parts.axis_address("arm.shoulder") == "arm"
    for wrong in ("arm.wrist", "arm.logger", "arm.", "pinger", "leg"):
        assert rig.runtime.parts.axis_address(wrong) is None


def test_what_is_for_an_axis_reaches_this_one_alone(rig: Rig) -> None:
    rig.runtime.apply_input("arm.elbow", SetField("load_torque_Nm", 0.01))
    rig.runtime.apply_to(rig.arm, Pin("D2", 1), "elbow")
    loads = [rig.value(axis, "load_torque_Nm") for axis in rig.runtime.parts.axes]
    assert loads == [0.0, 0.01, 0.0]
    assert [line["device"] for line in rig.inputs()] == ["arm.elbow", "arm.elbow"]
    rig.run(1)
    assert rig.heard == [("arm", "enable of elbow;")]
    assert [rig.value(axis, "diaagc") for axis in ("arm", "arm.elbow")] == [0.0, 0x123]


def test_a_verb_of_an_axis_is_told_which(rig: Rig) -> None:
    rig.runtime.apply_input("arm", Do("aim", (("r", 1.0),)))
    assert rig.runtime.apply_input("arm.elbow", Do("aim", (("r", 2.0),)))[1] == {"r": 2.0}
    assert [rig.value(axis, "r") for axis in ("arm", "arm.elbow")] == [1.0, 2.0]
    rig.runtime.apply_input("arm.elbow", Follow(0, (PathPiece(10**6, 3.0), PathPiece(0, 3.0))))
    rig.arm.axes["elbow"].loop(True)
    rig.run(5)
    assert [rig.value(axis, "r") for axis in ("arm", "arm.elbow")] == [1.0, 3.0]


@pytest.mark.parametrize(
    ("target", "verb", "why"),
    [
        ("arm.elbow", "park", "park is of the whole board: ask arm for it"),
        ("arm.wrist", "aim", "arm has no axis 'wrist'; it has shoulder, elbow, grip"),
        ("pinger", "aim", "pinger has no axis"),
        ("pinger", "pin", "pinger has no axis"),
    ],
)
def test_a_verb_at_the_wrong_place(
    rig: Rig, monkeypatch: pytest.MonkeyPatch, target: str, verb: str, why: str
) -> None:
    given = {"aim": (("r", 1.0),), "pin": (("pin", "D0"), ("level", 1))}.get(verb, ())
    monkeypatch.setattr(BenchRuntime, "check_input", staticmethod(lambda bench, logged: None))
    with pytest.raises(VerbRefused) as caught:
        rig.runtime.apply_input(target, Do(verb, given))
    assert str(caught.value) == why


def test_a_stream_of_set_points_ends_for_its_own_axis() -> None:
    rig = Rig(timeout_ms=20)
    rig.run(1)
    for _ in range(3):
        rig.runtime.apply_input("arm.elbow", Do("aim", (("r", 2.0),)))
        rig.run(10)
    rig.runtime.apply_input("arm", Do("aim", (("r", 1.0),)))
    rig.run(15)
    assert [rig.value(axis, "r") for axis in ("arm", "arm.elbow")] == [1.0, -1.0]
    assert rig.arm.notes == {"set-points of elbow": "no set-point for 20 ms: hold (1 times)"}
    rig.run(10)
    assert rig.value("arm", "r") == -1.0
    assert rig.arm.setpoints.starved == 2
    rig.runtime.apply_input("arm.elbow", Do("aim", (("r", 2.0),)))
    assert "set-points of elbow" not in rig.arm.notes


def test_a_fault_is_on_the_axis_that_it_names(rig: Rig) -> None:
    def inject(kind: str, target: str, **given: object) -> int:
        return rig.runtime.inject(fault_refusal(kind, target, given))

    inject("shaft_load", "arm.elbow", torque_Nm=0.02)
    assert [rig.value(axis, "load_torque_Nm") for axis in ("arm", "arm.elbow")] == [0.0, 0.02]
    assert rig.runtime.faults.load_problem(rig.arm.axes["elbow"], 5.0) is not None
    jam = inject("shaft_jam", "arm.shoulder")
    rig.runtime.clear_fault(jam)
    inject("node_brown_out", "arm")
    rig.run(5)
    assert rig.arm.failed is not None
    for kind, target in (
        ("shaft_jam", "arm.logger"),
        ("node_hang", "arm.elbow"),
        ("encoder_freeze", "arm.grip"),
    ):
        with pytest.raises(FaultRefused, match=f"{kind}: {target} (is|has) no .*; "):
            inject(kind, target)
    with pytest.raises(FaultRefused, match="pinger has no"):
        inject("shaft_jam", "pinger")
    with pytest.raises(FaultRefused, match=r"there is no 'arm\.wrist'"):
        inject("shaft_jam", "arm.wrist")


def test_an_interrupt_says_which_axis_it_is_of(rig: Rig) -> None:
    for axis in ("shoulder", "elbow"):
        rig.arm.axes[axis].set("print_yw", 1)
        rig.arm.axes[axis].loop(True)
    rig.run(2)
    said = "".join(text for at, text in rig.heard if at == "arm")
    assert "step_response of shoulder;" in said
    assert "step_response of elbow;" in said


def test_a_later_verb_is_cancelled_by_what_ends_its_axis(rig: Rig) -> None:
    for axis, r in (("arm", 1.0), ("arm.elbow", 2.0)):
        rig.runtime.apply_input(axis, Do("aim", (("r", r),), rig.runtime.now_ns + 5 * NS_PER_MS))
    rig.run(10)
    assert [rig.value(axis, "r") for axis in ("arm", "arm.elbow")] == [1.0, 2.0]
    for axis in ("arm", "arm.elbow"):
        rig.runtime.apply_input(axis, Do("aim", (("r", 9.0),), rig.runtime.now_ns + 5 * NS_PER_MS))
    rig.runtime.apply_input("arm", Do("park"))
    rig.run(10)
    assert [rig.value(axis, "r") for axis in ("arm", "arm.elbow")] == [1.0, 2.0]


def test_a_board_without_axes_runs(rig: Rig) -> None:
    pinger = rig.runtime.devices["pinger"]
    rig.runtime.apply_to(pinger, Bytes(b"?"))
    rig.run(1)
    assert rig.heard == [("pinger", "main:?;")]
    with pytest.raises(KeyError):
        rig.runtime.snapshot("pinger")
    rig.runtime.remove("pinger")
    rig.runtime.remove("arm")
    assert not rig.runtime.parts.axes


def test_a_board_without_uarts_runs(rig: Rig) -> None:
    rig._add("drive", {}, {"axis": AxisPlan(PARAMETERS, law="mechaduino")}, None)
    rig._add("brick", {}, {}, None)
    rig.run(5)
    drive = rig.runtime.devices["drive"]
    assert (drive.uarts.first, list(drive.uarts), drive.failed) == ("", [], None)
    rig.runtime.apply_input("drive", SetField("load_torque_Nm", 0.01))
    rig.runtime.apply_to(drive, Pin("D3", 1))
    rig.run(5)
    assert (rig.value("drive", "load_torque_Nm"), drive.failed) == (0.01, None)
    hang = rig.runtime.inject(fault_refusal("node_hang", "brick", {}))
    rig.runtime.inject(fault_refusal("node_reset", "drive", {}))
    rig.runtime.clear_fault(hang)
    rig.run(5)
    assert (drive.power.ups, rig.runtime.devices["brick"].failed, rig.heard) == (2, None, [])
    for kind, target in (("host_close", "drive"), ("host_close", "brick"), ("shaft_jam", "brick")):
        with pytest.raises(FaultRefused, match=f"{kind}: {target} (is|has) no .*; "):
            rig.runtime.inject(fault_refusal(kind, target, {}))
    for name in ("drive", "brick"):
        rig.runtime.remove(name)
        assert rig.runtime.parts.place(name) is None


def test_a_firmware_that_looks_for_a_uart_that_is_not_there_stops_alone(rig: Rig) -> None:
    rig._add("drive", {}, {"axis": AxisPlan(PARAMETERS, law="mechaduino")}, None)
    rig.run(1)
    rig.runtime.apply_input("drive", Pin("D2", 1))  # its firmware says so at its first UART
    rig.run(1)
    assert str(rig.runtime.devices["drive"].failed).startswith("KeyError")
    assert rig.arm.failed is None
