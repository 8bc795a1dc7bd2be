"""Boards outside hil with two axes and three serial interfaces, and with no axis, to the replay of a log."""

import io
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import hil
from hil.compose.replay import replay
from hil.config import ConfigError
from hil.core import FIELDS
from hil.sim.bench import BenchHooks
from hil.sim.input_log import InputLogWriter
from hil.testing import Bench
from hil.testing.config_reading import read_config
from hil.vocab.faults import FaultRefused
from hil.vocab.verbs import VerbRefused

BOARDS = str(Path(hil.__file__).parents[1] / "tests/boards")
CONFIG: dict[str, Any] = {
    "bench": "many",
    "profile_path": [BOARDS],
    "devices": {
        "arm": {
            "profile": "arm",
            "port": "memory",
            "ports": {"logger": "memory"},
            "axis": {"start_deg": 0.0},
            "axes": {"elbow": {"axis": {"load_torque_Nm": 0.001}}},
        },
        "p1": {"profile": "pinger", "port": "memory"},
        "s1": {"profile": "sac", "port": "memory"},
        "s2": {"profile": "sac", "port": "memory"},
    },
    "wires": [
        {"from": "s1.clk", "to": "arm.step"},
        {"from": "s2.clk", "to": "arm.elbow.step"},
        {"from": "s2.dir", "to": "arm.elbow.dir"},
    ],
    "segments": {"bus0": {"stations": ["arm.bus"], "taps": {"m": {"port": "memory"}}}},
}
ALONE = CONFIG | {
    "devices": {name: CONFIG["devices"][name] for name in ("arm", "p1")},
    "wires": [],
}


@pytest.fixture
def bench() -> Iterator[Bench]:
    with Bench(ALONE) as made:
        made.run(ms=300)  # until both shafts stand where they are held
        made.port("arm").read()
        yield made


def test_each_interface_has_its_own_port(bench: Bench) -> None:
    bench.port("arm").write(b"s")
    bench.port("arm.main").write(b"e")
    bench.port("arm", "logger").write(b"nobody minds")
    bench.tap("bus0.m").write(b"#")
    bench.port("p1").write(b"x")
    bench.run(ms=50)
    shoulder, elbow = (line.split() for line in bench.port("arm").read().splitlines())
    assert (shoulder[0], elbow[0]) == (b"shoulder", b"elbow")
    for said, axis in ((shoulder, "arm"), (elbow, "arm.elbow")):
        assert float(said[1]) == pytest.approx(bench.axis(axis).snapshot().yw, abs=0.2)
    assert float(elbow[1]) - float(shoulder[1]) > 40
    assert bench.port("arm.logger").read() == b"1: s\r\n2: e\r\n"
    assert bench.tap("bus0.m").read() == b"#=2;"[1:]
    assert bench.port("p1").read() == b"ping"


def test_a_run_moves_both_axes_together(bench: Bench) -> None:
    progress = bench.perform(
        {
            "run": "r",
            "axes": {"arm": {}, "arm.elbow": {"following_error_deg": 5}},
            "steps": [
                {"line": {"arm": 30, "arm.elbow": 90}},
                {"pins": {"arm.elbow.D3": 1}},
                {"wait_until": {"axis": "arm.elbow", "field": "yw", "above": 89}},
            ],
        }
    )
    assert (progress.state, progress.why) == ("done", None)
    for axis, position_deg in (("arm", 30), ("arm.elbow", 90)):
        assert progress.axes[axis].position_deg == pytest.approx(position_deg, abs=0.5)
        assert bench.axis(axis).snapshot().position_deg == pytest.approx(position_deg, abs=1)


def test_what_is_configured_is_an_axis_s_own(bench: Bench) -> None:
    shoulder, elbow = bench.axis("arm").snapshot(), bench.axis("arm.elbow").snapshot()
    assert (shoulder.load_torque_Nm, elbow.load_torque_Nm) == (0.0, 0.001)
    assert (shoulder.diaagc, elbow.diaagc) == (0x180, 0x181)
    assert bench.axis("arm.shoulder") is bench.axis("arm")


def test_verbs_recordings_and_loads_are_of_the_axis_that_is_asked(bench: Bench) -> None:
    elbow = bench.axis("arm.elbow")
    recording = elbow.record("r", "yw", interval_ms=1)
    assert elbow.do("position", position_deg=50.0)["set_point"] == 50.0
    bench.run(ms=200)
    assert recording.column("r")[-1] == 50.0
    assert recording.column("yw")[-1] == pytest.approx(50, abs=0.5)
    assert bench.axis("arm").snapshot().r == pytest.approx(0, abs=0.1)
    elbow.load_torque_Nm = 0.01
    assert bench.axis("arm").load_torque_Nm == 0.0
    with pytest.raises(ValueError, match="load_torque_Nm"):
        elbow.load_torque_Nm = 100.0


def test_a_fault_of_each_axis_and_each_interface(bench: Bench) -> None:
    before_deg = bench.axis("arm.elbow").snapshot().position_deg
    with bench.fault("shaft_jam", "arm.elbow"):
        for axis in ("arm", "arm.elbow"):
            bench.axis(axis).do("position", position_deg=60.0)
        bench.run(ms=300)
        assert bench.axis("arm").snapshot().position_deg == pytest.approx(60, abs=1)
        assert bench.axis("arm.elbow").snapshot().position_deg == pytest.approx(before_deg, abs=0.01)
    with bench.fault("host_stop_reading", "arm.logger"):
        bench.port("arm").write(b"s")
        bench.run(ms=20)
        assert bench.port("arm.logger").read() == b""
        assert bench.port("arm").read().startswith(b"shoulder 60")
    with bench.fault("wire_cut", "arm.bus"):
        bench.tap("bus0.m").write(b"#")
        bench.run(ms=20)
        assert b"=" not in bench.tap("bus0.m").read()
    for target in ("p1", "arm.wrist", "arm.logger"):
        with pytest.raises(FaultRefused):
            bench.fault("shaft_jam", target)


def test_pins_of_each_axis() -> None:
    with Bench(CONFIG) as bench:
        bench.run(ms=1200)
        bench.port("s1").write(b"m20v60\r")
        bench.port("s2").write(b"m-20v60\r")
        bench.run(ms=2000)
        moved = [bench.axis(axis).snapshot().r for axis in ("arm", "arm.elbow")]
        assert moved[0] > 1
        assert moved[1] < 44
        bench.device("arm").pin("elbow.D3", 1)
        with pytest.raises(KeyError, match=r"arm\.elbow has no pin 'clk'"):
            bench.device("arm").pin("elbow.clk")
        with pytest.raises(KeyError):
            bench.device("p1").pin("D0")


def test_a_stream_of_set_points_that_ends() -> None:
    config = ALONE | {
        "devices": {"arm": CONFIG["devices"]["arm"] | {"setpoints": {"timeout_ms": 30, "policy": "hold"}}}
    }
    with Bench(config) as bench:
        bench.run(ms=20)
        bench.axis("arm.elbow").do("position", position_deg=46.0)
        bench.run(ms=40)
        assert list(bench.device("arm").notes) == ["set-points of elbow"]


def logged(config: dict[str, Any], act: Callable[[Bench], None]) -> io.StringIO:
    with Bench(config) as fresh:
        memories = {name: dict(device.nvm) for name, device in fresh._runtime.devices.items()}
    log = io.StringIO()
    act(Bench(config, around=BenchHooks(log=InputLogWriter(log, "test", config, memories))))
    log.seek(0)
    return log


def test_the_log_of_such_a_board_replays() -> None:
    def act(bench: Bench) -> None:
        bench.run(ms=1200)
        bench.perform({"run": "r", "axes": {"arm.elbow": {}}, "steps": [{"move": {"arm.elbow": 80}}]})
        bench.fault("encoder_noise", "arm.elbow", counts=3, seed=4, for_s=0.05)
        bench.axis("arm").load_torque_Nm = 0.02
        bench.device("arm").pin("elbow.D2", 1)
        bench.port("arm").write(b"se?")
        bench.port("arm.logger").write(b"x")
        bench.tap("bus0.m").write(b"#")
        bench.port("p1").write(b"x")
        bench.port("s2").write(b"m3v60\r")
        bench.run(ms=300)
        bench.device("arm").reset()
        bench.run(ms=100)

    log = logged(CONFIG, act)
    assert '"device":"arm.elbow","input":"follow"' in log.getvalue()
    replayed = replay(log)
    assert replayed.difference() is None
    assert {sent.port for sent in replayed.sent["arm"]} == {"", "logger", "bus"}
    assert len(replayed.sent["p1"]) == 1


@pytest.mark.parametrize(
    ("device", "problem"),
    [
        ({"ports": {"loger": "memory"}}, "devices.arm.ports.loger: there is no serial interface of a arm"),
        ({"ports": {"main": "memory"}}, "devices.arm.ports.main: the port of main is the key port"),
        ({"network": "memory"}, "devices.arm.network: a arm has no serial interface 'network'"),
        ({"axes": {"wrist": {}}}, 'devices.arm.axes.wrist: there is no axis of a arm "wrist"'),
        ({"axes": {"elbow": {"axis": {"start": 1}}}}, "devices.arm.axes.elbow.axis.start: unknown key"),
        ({"axes": {"elbow": {"load": {"kind": "spring"}}}}, "devices.arm.axes.elbow.load: the simple"),
        ({"axes": {"elbow": {"plant": "full"}}}, ""),
        ({"axes": {"elbow": {"axis": {"load_torque_Nm": 99}}}}, "devices.arm.axes.elbow.axis.load_torque"),
    ],
)  # fmt: skip
def test_a_configuration_that_does_not_fit(device: dict[str, Any], problem: str) -> None:
    arm = {"profile": "arm", "port": "memory", "ports": {}, "axes": {}} | device
    config = {"bench": "b", "profile_path": [BOARDS], "devices": {"arm": arm}}
    if not problem:
        read_config(config)
        return
    with pytest.raises(ConfigError) as caught:
        read_config(config)
    (said,) = str(caught.value).splitlines()
    assert said.removeprefix("<dict>: ").startswith(problem)


@pytest.mark.parametrize(
    ("top", "problem"),
    [
        ({"segments": {"b": {"stations": ["arm"]}}}, "arm has several serial interfaces (write arm.UART"),
        ({"segments": {"b": {"stations": ["arm.main"]}}}, "the serial interface main of a arm is USB"),
        ({"segments": {"b": {"stations": ["p1", "arm.bus"]}}}, ""),
        ({"wires": [{"from": "s1.clk", "to": "arm.wrist.step"}]}, "arm has no axis 'wrist'; it has"),
        ({"wires": [{"from": "s1.clk", "to": "p1.step"}]}, "p1 has no axis"),
        ({"wires": [{"from": "s1.clk", "to": "arm.step"}, {"from": "s1.clk", "to": "arm.shoulder.step"}]},
         "arm.shoulder.step is driven by s1.clk already"),
        ({"faults": [{"fault": "shaft_jam", "target": "p1"}]}, 'shaft_jam cannot be on "p1"'),
        ({"faults": [{"fault": "shaft_jam", "target": "arm.bus"}]}, 'shaft_jam cannot be on "arm.bus"'),
        ({"faults": [{"fault": "node_hang", "target": "arm.elbow"}]}, 'node_hang cannot be on "arm.elbow"'),
        ({"faults": [{"fault": "shaft_jam", "target": "arm.elbow"}]}, ""),
        ({"faults": [{"fault": "supply_sag", "target": "arm.elbow", "supply_V": 9}]}, "supply_sag cannot"),
        ({"faults": [{"fault": "shaft_load", "target": "arm.elbow", "torque_Nm": 99}]}, "the number 99"),
        ({"faults": [{"fault": "byte_drop", "target": "arm.logger", "rate": 0.5}]}, ""),
    ],
)  # fmt: skip
def test_what_names_a_part(top: dict[str, Any], problem: str) -> None:
    devices = {
        name: {"profile": profile} for name, profile in (("arm", "arm"), ("p1", "pinger"), ("s1", "sac"))
    }
    config: dict[str, Any] = {"bench": "b", "profile_path": [BOARDS], "devices": devices} | top
    if not problem:
        Bench(config).close()
        return
    with pytest.raises(ConfigError) as caught:
        read_config(config)
    (said,) = str(caught.value).splitlines()
    assert said.partition(": ")[2].partition(": ")[2].startswith(problem)


def test_a_board_without_axes(bench: Bench) -> None:
    with pytest.raises(KeyError):
        bench.axis("p1")
    with pytest.raises(ConfigError, match="there is no"):
        bench.perform({"run": "r", "axes": {"p1": {}}, "steps": [{"dwell_s": 1}]})
    bench.device("p1").reset()
    bench.port("p1").write(b"x")
    bench.run(ms=20)
    assert bench.port("p1").read() == b"ping"


def test_a_verb_of_the_whole_board_is_not_an_axis_s(bench: Bench) -> None:
    with pytest.raises(VerbRefused, match=r"arm\.elbow has no 'jump'; "):
        bench.axis("arm.elbow").do("jump")
    assert "position_deg" in FIELDS


def test_as_many_axes_as_a_profile_may_have(tmp_path: Path) -> None:
    text = (Path(BOARDS) / "arm/profile.yaml").read_text()
    head, _, rest = text.partition("  elbow:\n")
    elbow, _, tail = rest.partition("default_hardware")
    for count, fits in ((15, True), (16, False)):
        folder = tmp_path / str(count) / "arm"
        folder.mkdir(parents=True)
        more = "".join(f"  a{number}:\n{elbow}" for number in range(count))
        (folder / "profile.yaml").write_text(f"{head}{more}default_hardware{tail}")
        names = "".join(f'"a{number}": AxisSpec(about=""), ' for number in range(count))
        for name in ("board.py", "firmware.py", "verbs.py"):
            text = (Path(BOARDS) / "arm" / name).read_text()
            (folder / name).write_text(text.replace('"elbow": AxisSpec(about="bends it")', names))
        config = {"bench": "b", "profile_path": [str(folder.parent)], "devices": {"arm": {"profile": "arm"}}}
        if not fits:
            with pytest.raises(ConfigError, match="16"):
                read_config(config)
            continue
        with Bench(config) as bench:
            bench.run(ms=20)
            assert bench.axis("arm.a14").snapshot().loop_on == 1
