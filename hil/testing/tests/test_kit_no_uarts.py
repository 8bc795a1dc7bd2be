"""Boards outside hil without a serial interface, with one axis and with none, to the replay of a log; and the
speeds of a board's several interfaces."""

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import hil
from hil.compose import find_catalogue
from hil.compose.replay import MemoryOptions, replay
from hil.compose.simulated_config import as_simulated
from hil.config import ConfigError, from_dict, parse
from hil.config import schema as json_schema
from hil.sim.bench import BenchHooks
from hil.sim.input_log import InputLogWriter
from hil.testing import Bench, CheckFailed, check_profile
from hil.testing.config_reading import read_config
from hil.vocab.faults import FaultRefused
from hil.vocab.verbs import VerbRefused

BOARDS = Path(hil.__file__).parents[1] / "tests/boards"
CONFIG: dict[str, Any] = {
    "bench": "mute",
    "profile_path": [str(BOARDS)],
    "devices": {
        "d1": {"profile": "drive"},
        "d2": {"profile": "drive", "axis": {"start_deg": 10.0}},
        "b1": {"profile": "brick"},
        "s1": {"profile": "sac"},
    },
    "wires": [{"from": "s1.clk", "to": "d1.step"}, {"from": "s1.dir", "to": "d1.dir"}],
}


@pytest.fixture
def bench() -> Iterator[Bench]:
    with Bench(CONFIG) as made:
        made.run(ms=1200)
        yield made


def test_another_boards_wires_turn_it(bench: Bench) -> None:
    before_deg = bench.axis("d1").snapshot().position_deg
    bench.port("s1").write(b"m20v60\r")
    bench.run(ms=2000)
    after_deg = bench.axis("d1").snapshot().position_deg
    assert after_deg - before_deg == pytest.approx(20 * 1.8 / 16, abs=0.2)
    assert bench.axis("d2").snapshot().position_deg == pytest.approx(10, abs=0.2)


def test_verbs_runs_pins_and_loads_reach_its_axis(bench: Bench) -> None:
    assert bench.axis("d1").do("position", position_deg=60.0)["set_point"] == 60.0
    bench.run(ms=300)
    assert bench.axis("d1").snapshot().position_deg == pytest.approx(60, abs=0.5)
    done = bench.perform(
        {"run": "r", "axes": {"d1": {}, "d2": {}}, "steps": [{"line": {"d1": 90, "d2": 30}}]}
    )
    assert (done.state, done.why) == ("done", None)
    bench.device("d2").pin("D3", 1)
    bench.axis("d2").load_torque_Nm = 0.01
    bench.run(ms=100)
    assert bench.axis("d2").snapshot().load_torque_Nm == 0.01


def test_its_memory_its_notes_and_a_reset(bench: Bench) -> None:
    assert dict(bench.device("d1").notes) == {"starts": "1 starts"}
    bench.device("d1").reset()
    bench.device("b1").reset()
    bench.run(ms=10)
    assert dict(bench.device("d1").notes) == {"starts": "2 starts"}
    assert [bench.device(name).failed for name in CONFIG["devices"]] == [None] * 4


def test_it_has_no_port_and_nobody_types_there(bench: Bench) -> None:
    for name, uart, why in (
        ("d1", "", "d1 has no serial interface"),
        ("b1", "", "b1 has no serial interface"),
        ("d1", "main", "d1 has no serial interface 'main'; it has none"),
        ("d1.main", "", "d1 has no serial interface 'main'; it has none"),
        ("s1", "bus", "s1 has no serial interface 'bus'; it has main, network"),
    ):
        with pytest.raises(KeyError) as caught:
            bench.port(name, uart)
        assert caught.value.args == (why,)
    for name in ("d1", "b1"):
        with pytest.raises(VerbRefused, match="has no 'type'; "):
            bench.device(name).do("type", text="x")
    with pytest.raises(KeyError, match="b1 has no pin 'D0'; there are none"):
        bench.device("b1").pin("D0")


def test_faults_of_the_board_and_of_its_shaft_and_none_of_a_port(bench: Bench) -> None:
    with bench.fault("node_hang", "d1"), bench.fault("shaft_jam", "d1"):
        bench.run(ms=10)
    with bench.fault("node_brown_out", "b1"):
        bench.run(ms=10)
        assert bench.device("b1").failed == "no power (fault 3)"
    bench.fault("node_reset", "d1")
    bench.run(ms=10)
    assert bench.device("d1").notes["starts"] == "2 starts"
    for kind, target in (
        ("byte_drop", "d1"),
        ("host_close", "d1"),
        ("wire_cut", "d1"),
        ("shaft_jam", "b1"),
        ("node_hang", "d1.axis"),
    ):
        with pytest.raises(FaultRefused, match=rf"{kind}: {target} .*; (there are|this bench has none)"):
            bench.fault(kind, target, **({"rate": 1.0} if kind == "byte_drop" else {}))
    with pytest.raises(FaultRefused, match=r"there is no 'd1\.main'"):
        bench.fault("byte_drop", "d1.main", rate=1.0)


def test_a_log_of_it_replays() -> None:
    log = io.StringIO()
    with Bench(CONFIG, around=BenchHooks(log=InputLogWriter(log, "test", CONFIG, {}))) as bench:
        bench.run(ms=1200)
        bench.perform({"run": "r", "axes": {"d2": {}}, "steps": [{"move": {"d2": 80}}]})
        bench.port("s1").write(b"m3v60\r")
        bench.fault("encoder_noise", "d1", counts=3, seed=4, for_s=0.05)
        bench.device("b1").reset()
        bench.run(ms=100)
        now_ns, states = bench.now_ns, [bench.axis(name).snapshot() for name in ("d1", "d2")]
    log.seek(0)
    replayed = replay(log)
    assert replayed.difference() is None
    assert replayed.sent["d1"] == []
    replayed.runtime.advance(now_ns)
    assert [replayed.runtime.snapshot(name) for name in ("d1", "d2")] == states


def test_the_configuration_in_a_log_is_read_again() -> None:
    config, _ = read_config(CONFIG)
    dumped = as_simulated(config)
    assert (dumped["devices"]["d1"]["port"], dumped["devices"]["d1"]["baud"]) == (None, None)
    again = from_dict(dumped, find_catalogue({"memory": MemoryOptions}))
    assert again.devices["d1"] == config.devices["d1"]


@pytest.mark.parametrize("board", ["drive", "brick"])
def test_it_passes_the_checks_of_all_boards(board: str) -> None:
    check_profile(BOARDS / board)


def test_what_its_axis_does_by_chance_is_found(tmp_path: Path) -> None:
    board = tmp_path / "drive"
    board.mkdir()
    (board / "profile.yaml").write_text((BOARDS / "drive" / "profile.yaml").read_text())
    text = (BOARDS / "drive" / "board.py").read_text()
    by_chance = text.replace(
        "yield Delay(NS_PER_S)", 'yield Delay(NS_PER_S)\n            axis.set("r", random())'
    )
    (board / "board.py").write_text(f"from random import random\n{by_chance}")
    with pytest.raises(CheckFailed) as caught:
        check_profile(board)
    assert "it does the same however time passes: at axis once b'" in str(caught.value)


def test_a_board_without_a_program_of_its_own_drops_what_comes(tmp_path: Path) -> None:
    board = tmp_path / "deaf"
    board.mkdir()
    (board / "board.py").write_text("from hil.vocab.profile import Profile\n\nPROFILE = Profile()\n")
    (board / "profile.yaml").write_text("name: deaf\ntitle: Deaf\nuarts: {main: {baud: 9600}}\n")
    check_profile(board)
    with Bench({"bench": "b", "profile_path": [str(tmp_path)], "devices": {"p": {"profile": "deaf"}}}) as b:
        b.port("p").write(b"x" * 1000)
        b.run(ms=1500)
        assert (b.port("p").read(), b._runtime.devices["p"].uarts[""].overrun_bytes) == (b"", 0)


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("port: pty", "6:5: devices.d1.port: a drive has no serial interface (leave this key out)"),
        ("port: {kind: none}", "6:5: devices.d1.port: a drive has no serial interface (leave this key out)"),
        ("network: pty", "6:5: devices.d1.network: a drive has no serial interface (leave this key out)"),
        ("ports: {main: pty}", "6:5: devices.d1.ports: a drive has no serial interface (leave this key out)"),
        ("baud: 9600", "6:5: devices.d1.baud: a drive has no serial interface (leave this key out)"),
        ("bauds: {a: 9600}", "6:5: devices.d1.bauds: a drive has no serial interface (leave this key out)"),
        ("at: /dev/ttyUSB0", "6:5: devices.d1.at: a drive has no serial interface (leave this key out)"),
        ("prot: pty", '6:5: devices.d1.prot: unknown key (did you mean "port"?)'),
    ],
)
def test_a_key_for_a_port_that_it_has_not(line: str, problem: str) -> None:
    text = f"bench: b\nprofile_path: [{BOARDS}]\ndevices:\n  d1:\n    profile: drive\n    {line}\n"
    with pytest.raises(ConfigError) as caught:
        parse(text, "b.yaml", find_catalogue())
    assert str(caught.value) == f"b.yaml:{problem}"


@pytest.mark.parametrize(
    ("top", "problem"),
    [
        ({"segments": {"b": {"stations": ["d1"]}}}, "segments.b.stations.0: d1 has no serial interface"),
        ({"segments": {"b": {"stations": ["d1.main"]}}}, "segments.b.stations.0: d1 has no serial interf"),
        ({"segments": {"b": {"stations": ["d1.network"]}}}, "segments.b.stations.0: a drive has no network"),
        ({"faults": [{"fault": "byte_drop", "target": "d1", "rate": 1}]}, "faults.0.target: byte_drop"),
        ({"faults": [{"fault": "node_hang", "target": "b1"}]}, ""),
        ({"faults": [{"fault": "shaft_jam", "target": "d1"}]}, ""),
        ({"faults": [{"fault": "shaft_jam", "target": "b1"}]}, "faults.0.target: shaft_jam cannot be on"),
    ],
)  # fmt: skip
def test_what_names_a_board_without_interfaces(top: dict[str, Any], problem: str) -> None:
    if not problem:
        Bench(CONFIG | top).close()
        return
    with pytest.raises(ConfigError) as caught:
        read_config(CONFIG | top)
    (said,) = str(caught.value).splitlines()
    assert said.removeprefix("<dict>: ").startswith(problem)


PROFILES = "from hil.vocab.profile import Commands, Profile\nfrom hil.vocab.verbs import Verb\n"


@pytest.mark.parametrize(
    ("parts", "uarts", "problem"),
    [
        ("uarts={}", "uarts: {main: {}}", "uarts: these are none, and those of profile.yaml main"),
        ("", "uarts: {}", "uarts: these are main, and those of profile.yaml none"),
        ("uarts={}, verbs=(Verb('go', '', types=b'g'),)", "uarts: {}", "verbs: there is no UART at which"),
        ("uarts={}, dialogues={'reset': print}", "uarts: {}", "dialogues: there is no UART at which"),
        ("uarts={}, terminal_axis=print", "uarts: {}", "terminal_axis: there is no UART at which"),
        ("uarts={}, commands=print", "uarts: {}", "commands: there is no UART at which"),
        ("uarts={}", "uarts: {}\nusb: native", "usb: this board has no UART"),
        ("uarts={}", "uarts: {}\ngreeting: x", "greeting: this board has no UART"),
    ],
)
def test_a_profile_that_needs_an_interface(tmp_path: Path, parts: str, uarts: str, problem: str) -> None:
    board = tmp_path / "bad"
    board.mkdir()
    (board / "board.py").write_text(f"{PROFILES}PROFILE = Profile({parts})\n")
    (board / "profile.yaml").write_text(f"name: bad\ntitle: Bad\n{uarts}\n")
    (said,) = find_catalogue(path=[tmp_path]).problems("bad")
    assert f"{said.message} ({said.remedy})".startswith(problem) or problem in str(said)


def test_the_schema_knows_that_it_has_none() -> None:
    made: Any = json_schema(find_catalogue(path=[BOARDS]))
    rules = {
        rule["if"]["properties"]["profile"]["const"]: rule["then"]["properties"]
        for rule in made["$defs"]["DeviceConfig"]["allOf"]
    }
    assert rules["drive"]["port"] == {"type": "null"}
    assert "port" not in rules["arm"]


# ---- speeds of several interfaces ----


def arm(**keys: Any) -> dict[str, Any]:
    device = {"profile": "arm", **keys}
    return {"bench": "b", "profile_path": [str(BOARDS)], "devices": {"arm": device}}


@pytest.mark.parametrize(
    ("keys", "logger_baud"),
    [({}, 115200), ({"bauds": {"logger": 9600}}, 9600), ({"bauds": {"logger": None, "bus": 50}}, None)],
)
def test_each_interface_has_its_speed(keys: dict[str, Any], logger_baud: int | None) -> None:
    with Bench(arm(**keys)) as bench:
        bench.run(ms=10)
        bench.port("arm").read()
        bench.port("arm").write(b"?")
        bench.run(ms=50)
        ((start_ns, line),) = bench.port("arm.logger").timeline
        ((end_ns, _),) = bench.port("arm.logger").read_complete()
        took_ns = round(len(line) * 10e9 / logger_baud) if logger_baud else 0
        assert (start_ns, end_ns - start_ns) == (10_000_000, pytest.approx(took_ns, abs=1))


def test_the_first_interface_has_its_own_key() -> None:
    with Bench(arm(baud=300, bauds={"logger": 600})) as bench:
        uarts = bench._runtime.devices["arm"].uarts
        assert {name: uart.baud for name, uart in uarts.items()} == {"main": 300, "logger": 600, "bus": 38400}


def test_a_station_listens_at_the_speed_it_was_given() -> None:
    wire = {"segments": {"bus0": {"stations": ["arm.bus"], "taps": {"m": {"port": "memory"}}, "baud": 19200}}}
    for bauds, answer in (({"bus": 19200}, b"=0;"), ({}, b"")):
        with Bench(arm(bauds=bauds) | wire) as bench:
            bench.run(ms=10)
            bench.tap("bus0.m").write(b"#")
            bench.run(ms=20)
            assert bench.tap("bus0.m").read() == answer


@pytest.mark.parametrize(
    ("keys", "problem"),
    [
        ({"baud": 9}, "devices.arm.baud: the number 9 is too small (write 50 or more)"),
        ({"bauds": {"logger": 9}}, "devices.arm.bauds.logger: the number 9 is too small (write 50 or more)"),
        ({"bauds": {"bus": 4_000_001}}, "devices.arm.bauds.bus: the number 4000001 is too large (write"),
        ({"bauds": {"bus": "x"}}, "devices.arm.bauds.bus: a whole number is wanted here"),
        ({"bauds": 9600}, "devices.arm.bauds: keys are wanted here, not the number 9600"),
        ({"bauds": {"loger": 9600}}, 'devices.arm.bauds.loger: there is no serial interface of a arm "loger"'
         ' (did you mean "logger"?'),
        ({"bauds": {"main": 9600}}, "devices.arm.bauds.main: the baud of main is the key baud (leave one"),
        ({"at": "/dev/ttyUSB0", "bauds": {"logger": 9600}}, "devices.arm.bauds: a real board (at: /dev/tt"),
    ],
)  # fmt: skip
def test_a_speed_that_does_not_do(keys: dict[str, Any], problem: str) -> None:
    with pytest.raises(ConfigError) as caught:
        from_dict(arm(**keys), find_catalogue())
    (said,) = str(caught.value).splitlines()
    assert said.removeprefix("<dict>: ").startswith(problem)


def test_a_station_needs_a_speed() -> None:
    for keys, station, where in (
        ({"bauds": {"bus": None}}, "arm.bus", "devices.arm.bauds.bus"),
        ({"profile": "pinger", "baud": None}, "arm", "devices.arm.baud"),
    ):
        with pytest.raises(ConfigError, match=rf"{where}: a station of a segment needs a speed"):
            read_config(arm(**keys) | {"segments": {"b": {"stations": [station]}}})
