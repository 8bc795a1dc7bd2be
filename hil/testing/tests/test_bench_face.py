"""The one face of all kinds of bench: the same calls, waits, captures, and refusals of what a kind cannot."""

import inspect
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from hil.compose.decoding import Decoder, decoded
from hil.testing import Bench, NotInTime, ServedBench, UnsupportedHere, live
from hil.testing.bench_face import AnyAxis, AnyBench, AnyDevice, AnyFault, AnyPort, AnyTap
from hil.testing.faces import AxisFace, DeviceFace, FaultFace, PortFace, TapFace
from hil.testing.live_axes import LiveAxis, LiveDevice, LiveFault
from hil.testing.live_ports import LivePort, LiveTap
from hil.vocab.faults import FaultRefused
from hil.vocab.verbs import VerbRefused
from hil.wire.pcapng import read

CONFIG = {
    "bench": "t",
    "speed": 5,
    "devices": {
        "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
        "s1": {"profile": "sac"},
        "s2": {"profile": "sac"},
    },
    "segments": {"bus0": {"stations": ["s1", "s2"], "taps": {"master": {"port": "pty"}}}},
}
FACES: dict[type, tuple[type, type]] = {
    AnyBench: (Bench, ServedBench),
    AnyPort: (PortFace, LivePort),
    AnyTap: (TapFace, LiveTap),
    AnyAxis: (AxisFace, LiveAxis),
    AnyDevice: (DeviceFace, LiveDevice),
    AnyFault: (FaultFace, LiveFault),
}


def calls(face: type) -> dict[str, Any]:
    return {name: of for name, of in vars(face).items() if callable(of) and not name.startswith("_")}


@pytest.mark.parametrize(("common", "of_kinds"), FACES.items())
def test_each_kind_has_the_same_calls(common: type, of_kinds: tuple[type, type]) -> None:
    assert calls(common)
    for name, call in calls(common).items():
        wanted = inspect.signature(call).parameters
        for kind in of_kinds:
            has = inspect.signature(getattr(kind, name)).parameters
            for parameter in wanted.values():
                assert has[parameter.name].kind is parameter.kind, (kind, name)
                if parameter.default is not inspect.Parameter.empty:
                    assert has[parameter.name].default == parameter.default, (kind, name)
            for more in has.keys() - wanted.keys():
                is_any = has[more].kind is inspect.Parameter.VAR_POSITIONAL
                assert is_any or has[more].default is not inspect.Parameter.empty, (kind, name, more)
        for kind in of_kinds:
            for prop in (each for each in vars(common) if isinstance(vars(common)[each], property)):
                assert hasattr(kind, prop), (kind, prop)


@pytest.fixture(scope="module", params=["virtual", pytest.param("live", marks=pytest.mark.long)])
def b(request: pytest.FixtureRequest) -> Iterator[AnyBench]:
    if request.param == "virtual":
        with Bench(CONFIG) as made:
            yield made
    else:
        with live(CONFIG) as served:
            yield served


def test_a_board_answers_at_its_port_and_to_pyserial(b: AnyBench) -> None:
    assert b.start() == []
    port = b.port("s1")
    port.read()
    begin_ns = b.now_ns
    port.write(b"vd\r")
    b.run(ms=200)
    heard = port.read_timed()
    assert b"".join(data for _, data in heard) == b"vd\r\n0\t0\r\nSAC>"
    assert all(begin_ns < at_ns <= b.now_ns for at_ns, _ in heard)
    assert port.read() == b""
    with b.serial("s1", timeout=5) as opened:
        assert opened.baudrate == 38400
        opened.write(b"vd\r")
        assert opened.read_until(b"SAC>").endswith(b"SAC>")
    assert port.read().endswith(b"SAC>")  # it has heard what the other got


def test_a_wait_ends_when_its_condition_holds(b: AnyBench) -> None:
    b.start()
    axis = b.axis("m1")
    axis.do("enable")
    axis.do("move-abs", position_deg=90)
    at_ns = b.wait_until("m1", "position_deg > 80 and loop_on == 1", within_ms=3000)
    assert axis.snapshot().position_deg > 80
    assert b.now_ns >= at_ns
    b.wait_until(lambda: axis.snapshot().position_deg > 85, within_ms=3000)
    with pytest.raises(
        NotInTime, match=r"^m1: position_deg > 300 did not hold within 50 ms: position_deg is \d"
    ):
        b.wait_until("m1", "position_deg > 300", within_ms=50)

    def never() -> bool:
        return False

    begin_ns = b.now_ns
    with pytest.raises(NotInTime, match=r"^never did not hold within 20 ms$"):
        b.wait_until(never, within_ms=20)
    assert b.now_ns >= begin_ns + 20_000_000
    for condition, said in (
        ("position > 1", "m1 has no field 'position'; did you mean \"position_deg\""),
        ("position_deg", "write one of"),
        ("", 'write an axis and a condition, as in "m1", "position_deg > 89"'),
    ):
        with pytest.raises(ValueError, match=said):
            b.wait_until("m1", condition)
    with pytest.raises(ValueError, match="within_ms: write a number from 0 on, not -1"):
        b.wait_until(never, within_ms=-1)


def test_faults_begin_and_end(b: AnyBench) -> None:
    b.start()
    with b.fault("shaft_load", "m1", torque_Nm=0.05) as load:
        assert load.is_active
        assert b.axis("m1").load_torque_Nm == pytest.approx(0.05)
    assert not load.is_active
    load.clear()
    b.axis("m1").load_torque_Nm = 0.01
    assert b.axis("m1").load_torque_Nm == pytest.approx(0.01)
    b.axis("m1").load_torque_Nm = 0
    for kind, target, parameters in (
        ("shaft_jm", "m1", {}),
        ("shaft_jam", "m7", {}),
        ("shaft_load", "m1", {}),
    ):
        with pytest.raises(FaultRefused):
            b.fault(kind, target, **parameters)


def test_what_is_not_there_is_refused_alike(b: AnyBench) -> None:
    b.start()
    for look in (b.port, b.serial, b.tap, b.axis, b.device):
        with pytest.raises(KeyError, match="m11"):
            look("m11")
    with pytest.raises(VerbRefused):
        b.axis("m1").do("fly")
    with pytest.raises(ValueError, match=r"load_torque_Nm: 100 is too large; write -4.95 to 4.95"):
        b.axis("m1").load_torque_Nm = 100
    with pytest.raises(TypeError, match="a port carries bytes"):
        b.port("m1").write("text")  # type: ignore[arg-type]
    with pytest.raises(AttributeError):
        b.prot("m1")  # type: ignore[attr-defined]


def test_a_capture_has_what_passed_in_its_block_alone(b: AnyBench, tmp_path: Path) -> None:
    b.start()
    tap = b.tap("bus0.master")
    b.port("s2").write(b"vd\r")
    b.run(ms=300)
    with b.capture(tmp_path / "part.pcapng"):
        b.port("s1").write(b"vd\r")
        tap.write(b"\x04\x55v")
        b.run(ms=300)
    b.port("s1").write(b"q\r")
    b.run(ms=100)
    items = list(decoded(read((tmp_path / "part.pcapng").read_bytes()), Decoder()))
    assert {item.source for item in items} == {"s1", "bus0"}
    text = "\n".join(item.line(0) for item in items)
    assert "s1 client -> board 'vd\\r'" in text
    assert "'SAC>'" in text
    assert "q" not in text
    with pytest.raises(OSError, match="nowhere"), b.capture(tmp_path / "nowhere" / "x.pcapng"):
        pass


def test_a_board_is_switched_off_and_on(b: AnyBench) -> None:
    b.start()
    board, port = b.device("m1"), b.port("m1")
    board.pin("D3", 1)
    assert b.axis("m1").snapshot().pin_d3 == 1
    port.read()
    board.reset()
    b.run(ms=3500)
    assert b"Mechaduino 0.X" in port.read()
    assert board.failed is None


def test_what_is_longer_than_a_request_is_typed_whole(b: AnyBench) -> None:
    b.start()
    port = b.port("m1")
    port.read()
    port.write(b"z" * 6000 + b"p")
    came = b""

    def is_answered() -> bool:
        nonlocal came
        came += port.read()
        return came.endswith(b"\r\n")

    b.wait_until(is_answered, within_ms=60_000)
    assert came.count(b"raw encoder") == 1


@pytest.mark.long
def test_what_the_bench_in_memory_alone_has_is_refused_with_the_kind() -> None:
    with live(CONFIG) as b, Bench(CONFIG) as virtual:
        parts: list[tuple[object, object]] = [
            (virtual, b),
            (virtual.port("m1"), b.port("m1")),
            (virtual.axis("m1"), b.axis("m1")),
            (virtual.device("m1"), b.device("m1")),
            (virtual.tap("bus0.master"), b.tap("bus0.master")),
        ]
        refused: dict[str, str] = {}
        for of_virtual, of_live in parts:
            for name in (each for each in dir(of_virtual) if not each.startswith("_")):
                try:
                    getattr(of_live, name)
                except UnsupportedHere as error:
                    refused[name] = str(error)
        why = "kind=live: {!r} is of a bench in memory alone (--hil=virtual)"
        assert {name: why.format(name) for name in refused} == refused
        assert {
            "runtime",
            "inputs",
            "config",
            "seed",
            "timeline",
            "record",
            "nvm",
        } <= refused.keys()
        assert refused.keys().isdisjoint(calls(AnyBench))
        with pytest.raises(UnsupportedHere, match=r"s1.network has no port: it is on a segment or a bus"):
            b.port("s1.network")
        with pytest.raises(UnsupportedHere, match="client_baud"):
            b.port("s1").write(b"v", client_baud=9600)


@pytest.mark.long
def test_a_port_of_a_bench_that_is_served_is_its_path_too() -> None:
    with live(CONFIG, capture=False) as b:
        port = b.port("s1")
        assert Path(port).exists()
        assert port == b.ports["s1"]
        assert port.read() == b""  # heard from now on: there is no capture
        port.write(b"\r")
        b.run(ms=300)
        assert port.read() == b"\r\nSAC>"


@pytest.mark.parametrize("kind", ["virtual", pytest.param("live", marks=pytest.mark.long)])
def test_frames_go_out_on_a_can_bus_and_come_back(kind: str) -> None:
    nodes = {"m1": {"id": 5}}
    config = {
        "bench": "t",
        "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}},
        "can": {"can0": {"bit_rate": 1_000_000, "nodes": nodes}},
    }
    with Bench(config) if kind == "virtual" else live(config) as b:
        face: AnyBench = b
        assert face.start() == []
        bus = face.can()
        assert face.can("can0") is bus
        bus.send(0x605, bytes.fromhex("4041600000000000"))  # the statusword
        answer = bus.expect(0x585, within_ms=2000)
        assert answer.frame.data[:4] == bytes.fromhex("4b416000")
        assert 0 < answer.at_ns <= face.now_ns
        bus.read()
        with pytest.raises(AssertionError, match=r"no 7FF# on can0 within 20 ms; the last: .*585#4B416000"):
            bus.expect(0x7FF, within_ms=20)
        with pytest.raises(TypeError, match="a port carries bytes"):
            bus.send(1, "text")
        with pytest.raises(KeyError, match="can9"):
            face.can("can9")
        if kind == "live":
            with pytest.raises(UnsupportedHere, match="'drives' is of a bench in memory alone"):
                bus.drives()


@pytest.mark.thorough
@pytest.mark.long
def test_a_modbus_client_reads_at_the_door_of_a_served_bench() -> None:
    door = {"listen": "127.0.0.1:0"}
    devices = {"s1": {"profile": "sac"}}
    config: dict[str, Any] = {"bench": "t", "devices": devices, "bridges": {"modbus": door}}
    with live(config, capture=False) as b:
        client = b.modbus(timeout=5)
        assert client.connected
        assert not client.read_input_registers(0, count=2, device_id=1).isError()
        with pytest.raises(KeyError, match="there is no serial line of the Modbus bridge '/dev/ttyS9'"):
            b.modbus("/dev/ttyS9")
    del config["bridges"]
    with (
        live(config, capture=False) as b,
        pytest.raises(KeyError, match="the bench has no bridge modbus; write"),
    ):
        b.modbus()
