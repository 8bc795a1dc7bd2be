"""Fields of a board's own, and what firmware may ask: its time, the size of its receive buffer."""

import struct
from collections.abc import Callable, Iterator
from io import StringIO
from pathlib import Path
from typing import Any

import pytest

from hil.compose.replay import replay
from hil.config import ConfigError
from hil.sim.bench import BenchHooks
from hil.sim.input_log import InputLogWriter
from hil.testing import Bench
from hil.vocab.address import DeviceParts
from hil.vocab.faults import FaultRefused
from hil.vocab.firmware import Board
from hil.vocab.time import SimTimeNs

FIRMWARE = """
from hil.vocab.firmware import Delay, ByteAvailable

class Tank:
    def __init__(self, board):
        self.board, self.fields = board, board.fields

    def main(self):
        while True:
            yield Delay(duration_ns=10_000_000)
            self.fields["passes"] += 1
            self.fields["valve"] = self.fields["level_mm"] < 100
            self.fields["ms"] = self.board.millis()
            for byte in self.board.uart.read_all():
                self.answer(bytes((byte,)))

    def answer(self, letter):
        if letter == b"!":
            self.fields["valve"] = 7
        elif letter == b"x":
            self.fields["vavle"] = 1
        self.board.uart.write(letter)

    def interrupt(self, event):
        pass
"""
BOARD = """
from hil.vocab.profile import Profile
from .firmware import Tank

PROFILE = Profile(firmware=Tank)
"""
FIELDS = """
fields:
  level_mm: {about: level, unit: mm, minimum: 0, maximum: 1000, value: 50, input: true}
  valve: {about: inlet, type: switch}
  passes: {about: passes of its loop, type: whole, minimum: 0}
  ms: {about: its clock, unit: ms, type: whole, minimum: 0, maximum: 4294967295}
"""
PLAIN = "name: tank\ntitle: Tank\nuarts: {main: {baud: 9600, receive_buffer_bytes: 4}}\n" + FIELDS
SERVO = (
    PLAIN
    + """
law: mechaduino
motor: nema17-2A
axis:
  sense_resistor_ohm: {value: 0.15, unit: ohm, above: 0, about: Sense resistor., source: chosen}
"""
)

BARE = "from hil.vocab.profile import Profile\n\nPROFILE = Profile()\n"

Made = Callable[..., Bench]


@pytest.fixture
def tank(tmp_path: Path) -> Iterator[Made]:
    """Maker of a bench with a tank, ``t1``."""
    benches = []

    def make(profile: str = PLAIN, log: StringIO | None = None, **device: Any) -> Bench:
        folder = tmp_path / "tank"
        folder.mkdir(exist_ok=True)
        for name, text in {"firmware.py": FIRMWARE, "board.py": BOARD, "profile.yaml": profile}.items():
            (folder / name).write_text(text)
        others, bridges = device.pop("others", {}), device.pop("bridges", {})
        faults = device.pop("faults", [])
        config = {
            "bench": "t",
            "profile_path": [str(tmp_path)],
            "devices": {**others, "t1": {"profile": "tank", **device}},
            "bridges": bridges,
            "faults": faults,
        }
        around = BenchHooks(log=InputLogWriter(log, "test", config, {})) if log else BenchHooks()
        benches.append(Bench(config, around=around))
        return benches[-1]

    yield make
    for each in benches:
        each.close()


def state(bench: Bench) -> dict[str, float]:
    return bench.axis("t1").snapshot().as_dict()


def test_fields_are_the_firmwares_and_the_worlds(tank: Made) -> None:
    bench = tank()
    bench.run(ms=105)
    now = state(bench)
    assert list(now) == ["at_ns", "level_mm", "valve", "passes", "ms"]
    assert (now["level_mm"], now["valve"], now["passes"], now["ms"]) == (50.0, 1, 10, 100)
    bench.axis("t1").set("level_mm", 500)
    assert bench.wait_until("t1", "valve == 0") <= 115_000_000


def test_a_reset_leaves_the_world_as_it_is(tank: Made) -> None:
    bench = tank(fields={"level_mm": 300})
    bench.run(ms=105)
    bench.axis("t1").set("level_mm", 400)
    bench.device("t1").reset()
    now = state(bench)
    assert (now["level_mm"], now["passes"], now["ms"]) == (400.0, 0, 0)
    bench.run(ms=25)
    assert state(bench)["ms"] == 20  # since the start of the firmware, not of the bench


def test_a_value_outside_stops_the_device_and_says_where(tank: Made) -> None:
    bench = tank()
    bench.port("t1").write(b"!")
    bench.run(ms=20)
    assert bench.device("t1").failed == ("ValueError: field valve: 7 is above 1 (firmware.py:19)")
    bench.device("t1").reset()
    bench.port("t1").write(b"x")
    bench.run(ms=20)
    assert "the board has no field 'vavle'; it has level_mm, valve, passes, ms" in str(
        bench.device("t1").failed
    )


@pytest.mark.parametrize(
    ("field", "value", "why"),
    [
        ("level_mm", 1001, "level_mm: 1001 is too large; write 0 to 1000 mm"),
        ("level_mm", float("nan"), "level_mm: nan is no number; write 0 to 1000 mm"),
        ("valve", 1, "t1 has no field 'valve' that can be set; there are level_mm"),
    ],
)
def test_what_cannot_be_set_is_refused(tank: Made, field: str, value: float, why: str) -> None:
    bench = tank()
    with pytest.raises(ValueError, match=f"^{why}$"):
        bench.axis("t1").set(field, value)


def test_an_axis_has_them_beside_its_own(tank: Made) -> None:
    bench = tank(SERVO)
    bench.run(ms=105)
    now = bench.axis("t1").snapshot()
    assert (now.passes, now.loop_on) == (10, 0)
    bench.axis("t1").load_torque_Nm = 0.05
    bench.run(ms=10)
    now = bench.axis("t1").snapshot()
    assert (now.load_torque_Nm, now.level_mm, now.passes) == (0.05, 50.0, 11)
    assert now.velocity_rpm != 0


def test_samples_and_recordings_have_them(tank: Made) -> None:
    bench = tank()
    recording = bench.axis("t1").record("passes", "level_mm", interval_ms=5)
    bench.run(ms=52)
    assert recording.column("passes") == [0, 0, 1, 1, 2, 2, 3, 3, 4, 4]
    assert set(recording.column("level_mm")) == {50.0}
    assert (recording.label("level_mm"), recording.label("passes")) == ("level_mm [mm]", "passes")


def test_pairs_of_extremes_have_them(tank: Made) -> None:
    bench = tank()
    axis = bench.runtime.parts.axis("t1")
    axis.watch(0, 50_000_000, 100, points=50)
    bench.run(ms=120)
    rows = axis.take_rows(0, ["at_ns", "passes", "level_mm"])
    assert [row[1:] for row in rows] == [(0, 50.0), (4, 50.0), (5, 50.0), (9, 50.0)]


def test_faults_of_fields_are_between_firmware_and_world(tank: Made) -> None:
    log = StringIO()
    bench = tank(log=log)
    bench.run(ms=15)
    with bench.fault("field_offset", "t1", field="level_mm", offset=200):
        bench.run(ms=10)
        assert (state(bench)["level_mm"], state(bench)["valve"]) == (50.0, 0)  # it reads 250
    bench.run(ms=10)
    assert state(bench)["valve"] == 1
    reads = bench.fault("field_stuck", "t1", field="level_mm")
    bench.axis("t1").set("level_mm", 900)
    bench.run(ms=10)
    assert (state(bench)["level_mm"], state(bench)["valve"]) == (900.0, 1)  # it reads 50
    stuck = bench.fault("field_stuck", "t1", field="valve")
    reads.clear()
    bench.run(ms=10)
    assert state(bench)["valve"] == 1
    bench.device("t1").reset()
    bench.run(ms=15)
    assert state(bench)["valve"] == 1  # a welded contact stays closed without power
    stuck.clear()
    bench.run(ms=10)
    assert state(bench)["valve"] == 0
    assert replay(log.getvalue().splitlines(keepends=True)).difference() is None


def test_faults_are_of_fields_that_are_there(tank: Made) -> None:
    bench = tank()
    with pytest.raises(FaultRefused, match=r"^field: t1 has no 'lvel_mm'"):
        bench.fault("field_stuck", "t1", field="lvel_mm")


def test_a_replay_gives_them_again(tank: Made) -> None:
    log = StringIO()
    bench = tank(log=log)
    bench.run(ms=33)
    bench.axis("t1").set("level_mm", 700.5)
    bench.port("t1").write(b"ab")
    bench.run(ms=50)
    assert '"input":"set_field","field":"level_mm","value":700.5' in log.getvalue()
    replayed = replay(log.getvalue().splitlines(keepends=True))
    assert replayed.difference() is None


LEVEL_AT, VALVE_AT = 1004, 1028
"""Registers of the fields, as `hil modbus map` prints them."""


def test_registers_have_them_and_boards_with_nothing_take_no_number(tank: Made, tmp_path: Path) -> None:
    bare = tmp_path / "bare"
    bare.mkdir()
    (bare / "board.py").write_text(BARE)
    (bare / "profile.yaml").write_text("name: bare\ntitle: Bare\n")
    bench = tank(others={"a0": {"profile": "bare"}}, bridges={"modbus": {}})
    with bench.modbus() as client:
        bench.run(ms=100)
        read = client.read_input_registers(LEVEL_AT, count=4, device_id=1)
        assert struct.unpack(">d", struct.pack(">4H", *read.registers)) == (50.0,)
        read = client.read_input_registers(VALVE_AT, count=2, device_id=1)
        assert read.registers == [0, 1]
        full = struct.unpack(">4H", struct.pack(">d", 900.0))
        assert not client.write_registers(LEVEL_AT, [*full], device_id=1).isError()
        bench.run(ms=20)
        assert client.read_input_registers(VALVE_AT, count=2, device_id=1).registers == [0, 0]
        assert client.write_registers(LEVEL_AT, [0x4100] * 4, device_id=1).isError()  # 131,000 mm and more
        assert client.read_input_registers(0, count=1, device_id=2).exception_code == 10
    assert state(bench)["level_mm"] == 900.0


def test_its_receive_buffer_has_the_size_that_it_says(tank: Made) -> None:
    bench = tank()
    bench.run(ms=1)
    bench.port("t1").write(b"abcdef")  # 6.25 ms, before the loop reads
    bench.run(ms=30)
    assert bench.port("t1").read() == b"abcd"
    assert bench.runtime.devices["t1"].uarts[""].overrun_bytes == 2


def test_millis_begin_again_after_32_bits() -> None:
    times = {"now": 0}
    board = Board(
        uarts=DeviceParts({}),
        axes=DeviceParts({}),
        nvm={},
        clock=lambda: SimTimeNs(times["now"]),
        started_ns=lambda: SimTimeNs(7_000_000),
    )
    times["now"] = 7_000_000 + 999_999
    assert (board.millis(), board.micros()) == (0, 999)
    times["now"] = 7_000_000 + 1_000 * 2**32
    assert (board.millis(), board.micros()) == (2**32 // 1000, 0)
    times["now"] = 7_000_000 + 1_000_000 * 2**32 - 1
    assert (board.millis(), board.micros(), board.now_ns) == (2**32 - 1, 2**32 - 1, times["now"])
    times["now"] += 1
    assert (board.millis(), board.micros()) == (0, 0)


@pytest.mark.parametrize(
    ("fields", "problems"),
    [
        ("Level: {about: x}", ['"Level" is no name of a field']),
        ("raw: {about: x}", ["raw is the name of a field of hil's"]),
        ("and: {about: x}", ["and is a word of conditions, or of Python"]),
        ("a: {about: x, minimum: 5}", ["its first value: 0 is below 5"]),
        ("a: {about: x, minimum: 5, maximum: 5, value: 5}", ["the range is empty: 5 to 5"]),
        ("a: {about: x, type: switch, maximum: 2}", ["a switch is 0 or 1"]),
        ("a: {about: x, type: whole, value: 1.5}", ["its first value: 1.5 is no whole number"]),
        (
            "Level: {about: x}\n  b: {about: x, value: 2, maximum: 1}",
            ['"Level" is no name', "its first value: 2 is above 1"],
        ),
        ("\n".join(f"  f{i}: {{about: x}}" for i in range(33)).lstrip(), ["33 fields are too many"]),
    ],
)
def test_mistakes_of_a_profile_are_told_together(tank: Made, fields: str, problems: list[str]) -> None:
    with pytest.raises(ConfigError) as told:
        tank(f"name: tank\ntitle: Tank\nfields:\n  {fields}\n")
    for problem in problems:
        assert problem in str(told.value)


def test_an_axis_may_have_no_room_for_all(tank: Made) -> None:
    fields = "\n".join(f"  f{i}: {{about: x}}" for i in range(30))
    with pytest.raises(ConfigError, match="there is no room for this field"):
        tank(SERVO[: SERVO.index("fields:")] + f"fields:\n{fields}\n" + SERVO[SERVO.index("law:") :])


def test_faults_of_a_configuration_name_fields_that_are_there(tank: Made) -> None:
    begun = {"fault": "field_offset", "target": "t1", "field": "level_mm", "offset": 5}
    bench = tank(faults=[begun])
    bench.axis("t1").set("level_mm", 97)
    bench.run(ms=15)
    assert state(bench)["valve"] == 0
    with pytest.raises(ConfigError, match=r"faults\.0\.field: there is no field of t1.s own .lvel."):
        tank(faults=[begun | {"field": "lvel"}])


def test_mistakes_of_a_device_are_told_together(tank: Made) -> None:
    with pytest.raises(ConfigError) as told:
        tank(fields={"level_mm": 2000, "lvel_mm": 3, "valve": 0.5})
    assert "2000 is above 1000" in str(told.value)
    assert "lvel_mm" in str(told.value)
    assert "0.5 is no whole number" in str(told.value)
