"""The maps of examples/drives, asked by pymodbus in memory, as their makers' manuals say they answer."""

import json
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from time import process_time
from typing import Any

import pytest
import yaml

from bridges.modbus.maps.drive_map_text import read_drive_map
from hil.compose import find_catalogue
from hil.compose.simulated_config import as_simulated
from hil.config import from_dict, parse
from hil.testing import Bench

DRIVES = Path(__file__).parents[3] / "examples" / "drives"
STEPPER, SERVO, FAN, METER, SLIDE = 1, 2, 3, 4, 5


def drive_map(name: str) -> Any:
    return yaml.safe_load((DRIVES / f"{name}.yaml").read_text())


class Plant:
    """Bench of examples/drives and a PLC at its door."""

    def __init__(self) -> None:
        config = drive_map("bench")
        for device in config["devices"].values():
            device["map"] = drive_map(device["map"].removesuffix(".yaml"))
        del config["bridges"]["modbus"]["rtu"]
        self.bench = Bench(config)
        self.bench.start()
        self.bench.run(ms=300)
        self.plc = self.bench.modbus()

    def get(self, unit: int, address: int, count: int = 1, *, inputs: bool = False) -> Any:
        ask = self.plc.read_input_registers if inputs else self.plc.read_holding_registers
        answer = ask(address, count=count, device_id=unit)
        return answer.exception_code if answer.isError() else answer.registers

    def put(self, unit: int, address: int, *words: int, single: bool = False) -> int | None:
        """Write; answers the exception, or None."""
        if single:
            answer = self.plc.write_register(address, words[0], device_id=unit)
        else:
            answer = self.plc.write_registers(address, list(words), device_id=unit)
        return answer.exception_code if answer.isError() else None

    def run(self, ms: float) -> None:
        self.bench.run(ms=ms)


@pytest.fixture(scope="module")
def plant() -> Iterator[Plant]:
    made = Plant()
    yield made
    made.bench.close()


def i32(words: list[int]) -> int:
    return int(struct.unpack(">i", struct.pack(">2H", *words))[0])


def low_first(number: int) -> tuple[int, int]:
    return number & 0xFFFF, number >> 16 & 0xFFFF


def test_a_stepper_starts_a_path_with_one_frame_and_its_trigger_clears_itself(plant: Plant) -> None:
    assert plant.put(STEPPER, 0x0F, 1, single=True) is None
    assert plant.put(STEPPER, 0x6200, 1, 0, 10000, 200, 100, 100, 0, 0x10) is None
    assert plant.get(STEPPER, 0x1003) == [0x06]  # enabled, running
    plant.run(2000)
    assert plant.get(STEPPER, 0x1003) == [0x32]  # enabled, command and path completed
    assert i32(plant.get(STEPPER, 0x1014, 2)) == pytest.approx(10000, abs=30)
    assert plant.get(STEPPER, 0x6200, 8) == [1, 0, 10000, 200, 100, 100, 0, 0]
    assert plant.put(STEPPER, 0x6208, 0x41, *divmod(-10000 & 0xFFFFFFFF, 0x10000), 100, 50, 500, 0, 0) is None
    assert plant.put(STEPPER, 0x6002, 0x11, single=True) is None
    assert plant.get(STEPPER, 0x6002) == [0]
    plant.run(2500)
    assert i32(plant.get(STEPPER, 0x1014, 2)) == pytest.approx(0, abs=30)


def test_a_stepper_counts_by_its_register_of_pulses(plant: Plant) -> None:
    assert plant.put(STEPPER, 0x0001, 200, single=True) is None
    assert abs(i32(plant.get(STEPPER, 0x1014, 2))) <= 1
    assert plant.put(STEPPER, 0x6200, 1, 0, 100, 200, 100, 100, 0, 0x10) is None
    plant.run(1500)
    assert i32(plant.get(STEPPER, 0x1014, 2)) == pytest.approx(100, abs=1)
    assert plant.put(STEPPER, 0x0001, 10000, single=True) is None
    assert i32(plant.get(STEPPER, 0x1014, 2)) == pytest.approx(5000, abs=30)


def test_what_a_stepper_refuses(plant: Plant) -> None:
    assert plant.put(STEPPER, 0x6002, 0x77, single=True) == 3
    assert plant.get(STEPPER, 0x5000) == 2
    assert plant.get(STEPPER, 0x1014, 101) == 3
    assert plant.plc.read_coils(0, count=1, device_id=STEPPER).exception_code == 1
    assert plant.get(STEPPER, 0, inputs=True) == 1


def test_a_steppers_settings_survive_its_power_when_they_were_stored(plant: Plant) -> None:
    assert plant.put(STEPPER, 0x0191, 42, single=True) is None
    plant.bench.device("stepper").reset()
    plant.run(400)
    assert plant.get(STEPPER, 0x0191) == [30]
    assert plant.put(STEPPER, 0x0191, 42, single=True) is None
    assert plant.put(STEPPER, 0x1801, 0x2211, single=True) is None
    plant.run(50)
    plant.bench.device("stepper").reset()
    plant.run(400)
    assert plant.get(STEPPER, 0x0191) == [42]
    assert plant.put(STEPPER, 0x1801, 0x2233, single=True) is None
    assert plant.get(STEPPER, 0x0191) == [30]


def test_a_stepper_keeps_options_and_pauses_of_its_paths(plant: Plant) -> None:
    assert plant.put(STEPPER, 0x0F, 1, single=True) is None
    assert plant.put(STEPPER, 0x6208, 0x4011, 0, 0, 100, 0, 0, 250, 0) is None  # jump, interrupt; no ramps
    assert plant.get(STEPPER, 0x6208, 8) == [0x4011, 0, 0, 100, 0, 0, 250, 0]
    assert plant.put(STEPPER, 0x6002, 0x11, single=True) is None
    plant.run(1000)
    assert i32(plant.get(STEPPER, 0x1014, 2)) == pytest.approx(0, abs=30)


def test_a_stepper_says_when_it_is_home_and_when_its_settings_are_stored(plant: Plant) -> None:
    assert plant.put(STEPPER, 0x0F, 1, single=True) is None
    assert plant.put(STEPPER, 0x6200, 1, 0, 2000, 200, 100, 100, 0, 0x10) is None
    plant.run(1000)
    assert not plant.get(STEPPER, 0x1003)[0] & 0x40
    assert plant.put(STEPPER, 0x6002, 0x20, single=True) is None
    assert not plant.get(STEPPER, 0x1003)[0] & 0x40
    plant.run(2000)
    assert plant.get(STEPPER, 0x1003)[0] & 0x40
    assert plant.put(STEPPER, 0x6002, 0x10, single=True) is None
    assert plant.get(STEPPER, 0x1003)[0] & 0x44 == 0x44  # it was home, and moves
    plant.run(1000)
    assert plant.put(STEPPER, 0x0191, 35, single=True) is None
    assert plant.get(STEPPER, 0x1901) == [0]
    assert plant.put(STEPPER, 0x1801, 0x2211, single=True) is None
    assert plant.get(STEPPER, 0x1901) == [0x5555]
    assert plant.put(STEPPER, 0x1801, 0x2233, single=True) is None


def test_a_servo_has_blocks_that_overlap_and_counts_of_48_bits(plant: Plant) -> None:
    assert plant.put(SERVO, 0xF5, 250, 300, 0, 0x4000) is None  # one turn
    assert plant.get(SERVO, 0xF1, inputs=True) == [2]
    plant.run(2000)
    assert plant.get(SERVO, 0xF1, inputs=True) == [1]
    high, middle, low = plant.get(SERVO, 0x31, 3, inputs=True)
    assert (high << 32 | middle << 16 | low) == pytest.approx(0x4000, abs=50)
    carry = plant.get(SERVO, 0x30, 3, inputs=True)
    assert (i32(carry[:2]) * 0x4000 + carry[2]) == pytest.approx(0x4000, abs=50)
    assert plant.get(SERVO, 0x31, 2, inputs=True) == 3
    assert plant.put(SERVO, 0xF4, 250, 300, *divmod(-0x8000 & 0xFFFFFFFF, 0x10000)) is None
    plant.run(2500)
    high, middle, low = plant.get(SERVO, 0x31, 3, inputs=True)
    assert (high << 32 | middle << 16 | low) - (1 << 48) == pytest.approx(-0x4000, abs=50)


def test_a_servo_turns_at_a_speed_and_has_the_acceleration_of_its_formula(plant: Plant) -> None:
    assert plant.put(SERVO, 0xF6, 0x0100 | 236, 120) is None  # 1 rpm each 20 x 50 us: 1000 rpm/s
    plant.run(60)
    speed = plant.get(SERVO, 0x32, inputs=True)[0] - 0x10000
    assert -75 < speed < -40
    plant.run(500)
    assert plant.get(SERVO, 0x32, inputs=True)[0] - 0x10000 == pytest.approx(-120, abs=2)
    assert plant.get(SERVO, 0xF1, inputs=True) == [4]
    assert plant.put(SERVO, 0xF7, 1, single=True) is None
    plant.run(300)
    assert plant.get(SERVO, 0x32, inputs=True) == [0]


def test_a_servo_starts_without_a_ramp_where_its_acceleration_is_0(plant: Plant) -> None:
    assert plant.put(SERVO, 0xF6, 0, 300) is None
    plant.run(100)
    assert plant.get(SERVO, 0x32, inputs=True)[0] == pytest.approx(300, abs=6)
    assert plant.put(SERVO, 0xF6, 0, 0) is None
    plant.run(100)
    assert plant.get(SERVO, 0x32, inputs=True) == [0]


def test_a_servo_moves_by_pulses_in_its_direction_and_stops_at_a_speed_of_0(plant: Plant) -> None:
    def turns() -> float:
        carry = plant.get(SERVO, 0x30, 3, inputs=True)
        return i32(carry[:2]) + carry[2] / 0x4000

    begin = turns()
    for direction, ends_at in ((0x100, begin - 1), (0, begin)):
        assert plant.put(SERVO, 0xFD, direction | 250, 300, 0, 3200) is None
        plant.run(1500)
        assert turns() == pytest.approx(ends_at, abs=0.01)
    assert plant.put(SERVO, 0xFD, 250, 60, 1, 0) is None
    plant.run(300)
    assert plant.put(SERVO, 0xFD, 250, 0, 0, 0) is None
    plant.run(300)
    assert plant.get(SERVO, 0xF1, inputs=True) == [1]
    assert turns() < begin + 2


def test_an_inverter_turns_at_the_frequency_of_the_mains_and_turns_about(plant: Plant) -> None:
    for address in (0x010C, 0x010D):
        assert plant.put(FAN, address, 200, single=True) is None
    assert plant.put(FAN, 0x2000, 0x12, 5000) is None
    plant.run(3000)
    assert plant.get(FAN, 0x2103)[0] == pytest.approx(5000, abs=50)
    assert plant.put(FAN, 0x2000, 0x1032, single=True) is None
    plant.run(5000)
    assert plant.get(FAN, 0x2101) == [0x051B]
    assert plant.put(FAN, 0x2000, 0x11, single=True) is None
    plant.run(3000)
    assert plant.get(FAN, 0x2103) == [0]


def test_an_inverter_turns_by_frequency_with_the_time_of_its_ramp(plant: Plant) -> None:
    assert plant.get(FAN, 0x2100, 5)[1] & 3 == 0
    assert plant.put(FAN, 0x2001, 1000, single=True) is None  # 10 Hz: 300 rpm
    assert plant.put(FAN, 0x010C, 600, single=True) is None  # 6 s to 60 Hz: 1 s to 10 Hz
    assert plant.put(FAN, 0x010D, 300, single=True) is None
    assert plant.put(FAN, 0x2000, 0x12, single=True) is None
    plant.run(500)
    assert plant.get(FAN, 0x2103)[0] == pytest.approx(500, abs=20)
    plant.run(1000)
    assert plant.get(FAN, 0x2100, 4) == [0, 0x0503, 1000, pytest.approx(1000, abs=5)]
    assert plant.put(FAN, 0x2001, 500, single=True) is None  # it changes at once
    plant.run(1000)
    assert plant.get(FAN, 0x2103)[0] == pytest.approx(500, abs=5)
    assert plant.put(FAN, 0x2000, 0x22, single=True) is None  # reverse
    plant.run(1500)
    assert plant.get(FAN, 0x2101) == [0x051B]
    assert plant.put(FAN, 0x2000, 0x01, single=True) is None
    plant.run(1000)
    assert plant.get(FAN, 0x2103) == [0]
    assert plant.get(FAN, 0x2101)[0] & 3 == 0


def test_an_inverter_has_a_password_limits_and_exceptions_of_its_own(plant: Plant) -> None:
    assert plant.put(FAN, 0x0016, 1, single=True) == 4
    assert plant.put(FAN, 0x0008, 1, single=True) is None
    assert plant.put(FAN, 0x0016, 1, single=True) is None
    assert plant.get(FAN, 0x0008) == 2  # it is only written
    assert plant.get(FAN, 0x2100, 21) == 3
    assert plant.put(FAN, 0x2000, 0x12, single=True) is None
    plant.run(100)
    assert plant.put(FAN, 0x0100, 5000, single=True) == 4  # while it turns
    assert plant.put(FAN, 0x2000, 0x01, single=True) is None
    plant.run(1000)
    assert plant.put(FAN, 0x0100, 5000, single=True) is None


def test_a_meter_has_no_axis_and_values_that_are_set_from_outside(plant: Plant) -> None:
    def read(address: int) -> float:
        return float(struct.unpack(">f", struct.pack(">2H", *plant.get(METER, address, 2, inputs=True)))[0])

    assert (read(0), read(0x46), read(0x06)) == (230.0, 50.0, 0.0)
    meter = plant.bench.device("meter")
    meter.do("cells", values="l1_voltage_V=240.5 l1_power_W=0")
    assert read(0) == 240.5
    meter.do("cells", values="l1_power_W=1000", over_s=1)
    plant.run(500)
    assert read(0x0C) == pytest.approx(500, abs=30)
    plant.run(600)
    assert read(0x0C) == 1000
    assert plant.get(METER, 0x24, 4, inputs=True) == [0, 0, 0, 0]  # reserved
    assert plant.get(METER, 0, 81, inputs=True) == 3
    assert plant.put(METER, 0x14, 0x4000, 0) == 2
    assert plant.put(METER, 0x18, 0x447A, 0) is None  # the password, 1000
    assert plant.put(METER, 0x14, 0x4000, 0) is None
    assert plant.get(METER, 0x14, 2) == [0x4000, 0]


def test_a_meter_reads_and_takes_whole_values(plant: Plant) -> None:
    assert plant.get(METER, 0, 1, inputs=True) == 2
    assert plant.get(METER, 1, 2, inputs=True) == 2
    assert plant.put(METER, 0x18, 0x447A) == 2
    assert plant.put(METER, 0x18, 0x447A, 0) is None  # 1000
    assert plant.put(METER, 0x02, 0x41F0, 0) is None  # 30
    assert plant.get(METER, 0x02, 2) == [0x41F0, 0]


def test_a_drive_of_cia_402_says_that_it_is_home(plant: Plant) -> None:
    assert plant.put(SLIDE, 0x3500, 6, single=True) is None
    for word in (0x06, 0x07, 0x0F, 0x1F):
        assert plant.put(SLIDE, 0x3100, word, single=True) is None
    plant.run(1000)
    assert plant.get(SLIDE, 0x3200)[0] & 0x1400 == 0x1400
    assert plant.put(SLIDE, 0x3100, 0x00, single=True) is None
    assert plant.put(SLIDE, 0x3500, 1, single=True) is None


def test_a_drive_of_cia_402_goes_through_its_states(plant: Plant) -> None:
    def state() -> int:
        return int(plant.get(SLIDE, 0x3200)[0]) & 0x6F

    assert state() == 0x40  # switch on disabled
    assert plant.put(SLIDE, 0x3100, 0x0F, single=True) is None
    assert state() == 0x40
    for word, expected in ((0x06, 0x21), (0x07, 0x23), (0x0F, 0x27)):
        assert plant.put(SLIDE, 0x3100, word, single=True) is None
        assert state() == expected
    assert plant.put(SLIDE, 0x4A00, *low_first(round(100 / 0.0003662109375))) is None
    for address in (0x4B00, 0x4C00):
        assert plant.put(SLIDE, address, *low_first(1638)) is None  # 600 rpm/s
    assert plant.put(SLIDE, 0x4000, *low_first(10000)) is None
    assert plant.put(SLIDE, 0x3100, 0x1F, single=True) is None
    assert plant.get(SLIDE, 0x3200)[0] & 0x1400 == 0x1000  # acknowledged, not there
    plant.run(2500)
    assert plant.get(SLIDE, 0x3200)[0] & 0x0400
    assert plant.get(SLIDE, 0x3700, 2) == [pytest.approx(10000, abs=30), 0]
    assert plant.put(SLIDE, 0x3100, 0x0F, single=True) is None
    assert plant.put(SLIDE, 0x6F00, *low_first(round(60 / 0.0003662109375))) is None
    assert plant.put(SLIDE, 0x3500, 3, single=True) is None  # it turns at once
    plant.run(1000)
    low, high = plant.get(SLIDE, 0x3B00, 2)
    assert (high << 16 | low) * 0.0003662109375 == pytest.approx(60, abs=2)
    assert plant.put(SLIDE, 0x3100, 0x06, single=True) is None
    assert state() == 0x21
    assert plant.put(SLIDE, 0x3500, 1, single=True) is None


def test_a_fault_of_cia_402_is_reset_by_its_edge(plant: Plant) -> None:
    for word in (0x06, 0x07, 0x0F):
        assert plant.put(SLIDE, 0x3100, word, single=True) is None
    plant.bench.device("slide").set_register("errfl", 1)
    plant.run(50)
    assert plant.get(SLIDE, 0x3200)[0] & 0x4F == 0x08
    assert plant.get(SLIDE, 0x1F00) == [2]
    plant.bench.device("slide").set_register("errfl", 0)
    assert plant.put(SLIDE, 0x3100, 0x8F, single=True) is None
    assert plant.get(SLIDE, 0x3200)[0] & 0x4F == 0x40


@pytest.mark.parametrize("unit", [STEPPER, SERVO, FAN, METER, SLIDE])
def test_any_registers_read_one_by_one_answer_or_are_refused(plant: Plant, unit: int) -> None:
    ask: Callable[..., Any] = plant.get
    for address in (0, 1, 0xF5, 0x1003, 0x2000, 0x3200, 0x6200, 0xFFFF):
        for inputs in (False, True):
            answer = ask(unit, address, inputs=inputs)
            assert answer in (1, 2, 3) or len(answer) == 1


def test_each_map_is_read_in_a_fraction_of_twenty_milliseconds() -> None:
    def read_ms(name: str) -> float:
        text = (DRIVES / f"{name}.yaml").read_text()
        begun_s = process_time()
        read_drive_map(text, name)
        return (process_time() - begun_s) * 1000

    for name in ("leadshine_pr", "mks_servo42d", "delta_vfd", "eastron_sdm630", "kinco_cia402"):
        assert min(read_ms(name) for _ in range(5)) < 20


def test_a_log_has_the_maps_themselves_and_a_replay_reads_them_back() -> None:
    catalogue = find_catalogue()
    config = parse((DRIVES / "bench.yaml").read_text(), str(DRIVES / "bench.yaml"), catalogue)
    logged = from_dict(json.loads(json.dumps(as_simulated(config))), catalogue)
    for name, device in config.devices.items():
        profile = catalogue.profiles[device.profile]
        assert catalogue.own_map(logged.devices[name], profile) == catalogue.own_map(device, profile)


def test_an_inverter_of_cia_402_without_a_mode_turns_when_it_is_enabled() -> None:
    # Addresses of Schneider's "ATV320 Communication parameters": CMD, LFRD, RFRD, ETA.
    of = {
        "modbus_map": 2,
        "commands": {"cmd": {"holding": 8501, "standard": "cia402", "reads": "written"}},
        "states": {"eta": {"holding": 3201, "standard": "cia402"}},
        "run_velocity_rpm": {"holding": 8602, "type": "i16"},
        "velocity_rpm": {"holding": 8604, "type": "i16"},
    }
    bench = Bench(
        {"bench": "b", "devices": {"atv": {"profile": "modbus_drive", "map": of}}, "bridges": {"modbus": {}}}
    )
    bench.start()
    bench.run(ms=300)
    plc = bench.modbus()
    for address, word in ((8501, 6), (8501, 7), (8602, 300), (8501, 15)):
        assert not plc.write_register(address, word, device_id=1).isError()
    bench.run(ms=1500)
    assert plc.read_holding_registers(8604, count=1, device_id=1).registers == [pytest.approx(300, abs=3)]
    assert plc.read_holding_registers(3201, count=1, device_id=1).registers == [0x0637]
    bench.close()
