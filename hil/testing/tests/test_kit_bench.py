"""``Bench``: its configuration, its clock, its faces."""

from pathlib import Path
from typing import Any

import pytest

from hil.core import FIELDS
from hil.core.abi import Kind
from hil.testing import Bench, ConfigError, replay_control

DEVICE = {"profile": "mechaduino", "port": "memory", "flash": {"table": "identity"}}
CONFIG: dict[str, Any] = {"bench": "kit", "devices": {"m1": DEVICE}}
TEXT = """\
bench: kit
devices:
  m1: {profile: mechaduino, port: memory, flash: {table: identity}}
"""


def answer(bench: Bench) -> bytes:
    bench.run(5000)
    bench.port("m1").read()
    bench.port("m1").write(b"p")
    bench.run(100)
    return bench.port("m1").read()


@pytest.mark.parametrize("given", ["dict", "text", "path", "path as text"])
def test_a_configuration_is_a_dict_yaml_text_or_a_path(given: str, tmp_path: Path) -> None:
    path = tmp_path / "bench.yaml"
    path.write_text(TEXT)
    config: Any = {"dict": CONFIG, "text": TEXT, "path": path, "path as text": str(path)}[given]
    bench = Bench(config)
    assert list(bench.config.devices) == ["m1"]
    assert answer(bench).startswith(b"stepNumber: 0 , Angle: 6.")


def test_a_tables_file_is_looked_up_beside_the_configuration(tmp_path: Path) -> None:
    (tmp_path / "table.txt").write_text(" ".join(["12.5"] * 16384))
    path = tmp_path / "bench.yaml"
    path.write_text(TEXT.replace("identity", "./table.txt"))
    assert b"Angle: 12.50," in answer(Bench(path))


def test_all_problems_of_a_configuration_are_told_at_once() -> None:
    with pytest.raises(ConfigError) as caught:
        Bench("bench: kit\ndevices:\n  m1: {profile: mechadiuno, port: memory}\nspeed: fast\n")
    assert [(problem.line, problem.file) for problem in caught.value.problems] == [
        (3, "<text>"),
        (4, "<text>"),
    ]
    assert "mechaduino" in str(caught.value)


def test_no_option_is_taken_by_the_memory_port() -> None:
    with pytest.raises(ConfigError):
        Bench({"bench": "kit", "devices": {"m1": DEVICE | {"port": {"kind": "memory", "size": 3}}}})


def test_nothing_runs_until_run() -> None:
    bench = Bench(CONFIG)
    assert bench.now_ns == 0
    assert bench.port("m1").read() == b""
    assert bench.axis("m1").snapshot().at_ns == 0


def test_run_goes_on_and_run_until_never_goes_back() -> None:
    bench = Bench(CONFIG)
    bench.run(1.5)
    bench.run(0.0000014)  # rounded to 1 ns
    assert bench.now_ns == 1_500_001
    bench.run_until(2)
    assert bench.now_ns == bench.axis("m1").snapshot().at_ns == 2_000_000
    with pytest.raises(ValueError, match="time does not go back"):
        bench.run_until(1)
    assert bench.now_ns == 2_000_000


def test_unknown_names_are_key_errors() -> None:
    bench = Bench(CONFIG)
    for face in (bench.port, bench.axis, bench.device):
        with pytest.raises(KeyError):
            face("m2")
    with pytest.raises(KeyError):
        bench.device("m1").pin("D9", 1)


def test_a_glance_reads_what_a_snapshot_has() -> None:
    with Bench(
        {"bench": "t", "devices": {"m1": {"profile": "mechaduino"}, "s1": {"profile": "sac"}}}
    ) as bench:
        bench.run(ms=10)
        for name in ("m1", "s1"):
            axis = bench._runtime.devices[name].axis
            assert repr((*axis.glance().values,)) == repr(axis.snapshot().values)
            assert axis.glance().at_ns == axis.snapshot().at_ns == 10_000_000


def test_a_snapshot_has_every_field_and_no_other() -> None:
    snapshot = Bench(CONFIG).axis("m1").snapshot()
    assert list(snapshot.as_dict()) == [
        name for name, f in FIELDS.items() if f.kind == Kind.any or f.kind & Kind.servo
    ]
    assert snapshot == Bench(CONFIG).axis("m1").snapshot()
    with pytest.raises(AttributeError, match="position_deg"):
        _ = snapshot.position


def test_the_port_tells_bytes_with_their_times_once() -> None:
    bench = Bench(CONFIG)
    bench.run(5000)
    port = bench.port("m1")
    port.read()
    told = len(port.timeline)
    port.write(b"p")
    bench.run(100)
    (first, second) = port.read_timed()
    assert (first[0], second[0]) == (5_000_000_000, 5_100_000_000)
    assert port.read_timed() == []
    assert port.read() == b""
    assert b"".join(data for _, data in port.timeline[told:]) == first[1] + second[1]


def counts(bench: Bench, times_ms: list[float]) -> list[int]:
    found = []
    for at_ms in times_ms:
        bench.run_until(at_ms)
        found.append(bench.axis("m1").snapshot().raw)
    return found


def test_a_held_script_steps_at_its_points() -> None:
    bench = Bench(CONFIG)
    bench.axis("m1").script_encoder([(10, 100), (20, 200), (30, -1), (40, 16384 + 5)])
    assert counts(bench, [0, 10, 19.999999, 20, 29, 30, 39, 40, 1000]) == [
        100,
        100,
        100,
        200,
        200,
        16383,
        16383,
        5,
        5,
    ]


def test_a_linear_script_rounds_down_and_wraps() -> None:
    bench = Bench(CONFIG)
    bench.axis("m1").script_encoder([(10, 100), (20, 110), (30, 90), (40, -10)], "linear")
    assert counts(bench, [0, 10, 10.5, 10.999999, 11, 20, 20.25, 30, 39, 39.05, 40, 50]) == [
        100, 100, 100, 100, 101, 110, 109, 90, 0, 16383, 16374, 16374
    ]  # fmt: skip


def test_no_points_give_the_encoder_back_to_the_shaft() -> None:
    bench = Bench(CONFIG)
    on_the_shaft = bench.axis("m1").snapshot().raw
    assert on_the_shaft == int(6.3 * 16384 / 360)
    bench.axis("m1").script_encoder([(0, 5)])
    assert counts(bench, [1]) == [5]
    bench.axis("m1").script_encoder([])
    assert counts(bench, [2]) == [on_the_shaft]


@pytest.mark.parametrize("points", [[(1, 0), (1, 5)], [(2, 0), (1, 5)]])
def test_a_scripts_times_ascend(points: list[tuple[float, float]]) -> None:
    with pytest.raises(ValueError, match="ascend"):
        Bench(CONFIG).axis("m1").script_encoder(points)


def test_a_script_is_held_or_linear() -> None:
    with pytest.raises(ValueError, match="cubic"):
        Bench(CONFIG).axis("m1").script_encoder([(0, 1)], "cubic")  # type: ignore[arg-type]


def test_a_load_bends_the_shaft_from_its_rest() -> None:
    # At rest with 37 counts (0.3192 A) in each coil the motor pulls with 0.225 Nm/A * 0.3192 A * sqrt(2)
    # * sin(50 x) against the load: 0.05 Nm bend it by asin(0.05 / 0.10158) / 50 = 0.590 deg.
    bench = Bench(CONFIG)
    axis = bench.axis("m1")
    bench.run(100)
    rest_deg = axis.snapshot().position_deg
    axis.load_torque_Nm = 0.05
    assert axis.load_torque_Nm == 0.05
    bench.run(500)
    assert axis.snapshot().position_deg - rest_deg == pytest.approx(0.590, abs=0.002)
    assert axis.snapshot().torque_Nm == pytest.approx(-0.05, abs=1e-6)
    axis.load_torque_Nm = 0.0
    bench.run(500)
    assert axis.snapshot().position_deg == pytest.approx(rest_deg, abs=1e-6)


def test_registers_of_the_encoder() -> None:
    bench = Bench(CONFIG)
    device = bench.device("m1")
    device.set_register("diaagc", 0x7FFF)
    device.set_register("errfl", 1)
    now = bench.axis("m1").snapshot()
    assert (now.diaagc, now.errfl) == (0x7FFF, 1)
    with pytest.raises(ValueError, match="0x8000"):
        device.set_register("errfl", 0x8000)
    with pytest.raises(ValueError, match="magnet"):
        device.set_register("magnet", 1)  # type: ignore[arg-type]


def test_devices_of_a_bench_do_not_touch_each_other() -> None:
    bench = Bench({"bench": "two", "devices": {"m1": DEVICE, "m2": DEVICE}})
    bench.run(5000)
    bench.port("m2").read()
    bench.port("m1").write(b"s")
    bench.run(200)
    assert bench.port("m2").read() == b""
    assert bench.axis("m1").snapshot().position_deg != bench.axis("m2").snapshot().position_deg


def test_a_closed_bench_is_closed_twice_without_harm() -> None:
    with Bench(CONFIG) as bench:
        bench.run(10)
    bench.close()


def test_replay_control_refuses_what_it_cannot_replay() -> None:
    table = [0.0] * 16384
    with pytest.raises(ValueError, match="walter"):
        replay_control("walter", [0], [0.0], ["x"], table, {})
    with pytest.raises(ValueError, match="length"):
        replay_control("mechaduino", [0, 1], [0.0], ["x"], table, {})
    with pytest.raises(KeyError):
        replay_control("mechaduino", [0], [0.0], ["x"], table, {"gain": 1.0})
    with pytest.raises(AttributeError):
        replay_control("mechaduino", [0], [0.0], ["x"], table, {"yw": 1.0})


def test_replay_control_by_hand() -> None:
    # Two steps of mode x with pKp = 2, pKi = 0.5, pKd = 0 at 0 deg and set-points 3 and 4:
    # u = 2 * 3 + 0.5 * 3 and 2 * 4 + 0.5 * (3 + 4).
    columns = replay_control(
        "mechaduino", [0, 0, 0], [3.0, 4.0, 4.0], "xx\0", [0.0] * 16384,
        {"pKp": 2.0, "pKi": 0.5, "pKd": 0.0}, [(2, "pKp", 9.0)],
    )  # fmt: skip
    assert columns["u"].tolist() == [7.5, 11.5, 0.0]
    assert columns["U"].tolist() == [7, 11, 0]
    assert columns["e"].tolist() == [3.0, 4.0, 4.0]
    assert columns["mode"].tolist() == [120, 120, 0]
    assert str(columns["u"].dtype) == "float32"
