"""The description of a kind of board: the real one, and broken ones."""

from pathlib import Path

import pytest

from hil.config import ConfigError
from hil.config.board_numbers import AxisParameter, HardwareVersion
from hil.config.catalogue import profile_from_yaml

FOLDER = Path(__file__).parents[3] / "device_profiles" / "mechaduino"
TEXT = (FOLDER / "profile.yaml").read_text()


def problem(old: str, new: str) -> str:
    assert old in TEXT
    with pytest.raises(ConfigError) as caught:
        profile_from_yaml(TEXT.replace(old, new, 1), FOLDER)
    (found,) = caught.value.problems
    assert found.file == str(FOLDER / "profile.yaml")
    assert found.line > 1
    return f"{found.message} ({found.remedy})"


def test_mechaduino_is_the_motor_and_board_of_the_reference_data() -> None:
    profile = profile_from_yaml(TEXT, FOLDER)
    assert (profile.name, profile.law, profile.plant) == ("mechaduino", "mechaduino", "simple")
    assert (list(profile.uarts), profile.baud()) == (["main"], None)
    assert profile.usb == "native"
    assert profile.usb_device
    assert (profile.usb_device.vendor_id, profile.usb_device.product_id) == (0x2341, 0x804D)
    assert {name: parameter.value for name, parameter in profile.axis.items()} == {
        "inertia_kg_m2": 5.4e-6,
        "viscous_Nm_s_per_rad": 0.004,
        "torque_constant_Nm_per_A": 0.225,
        "rotor_teeth": 50,
        "sense_resistor_ohm": 0.150,
        "ambient_degC": 25.0,
        "start_deg": 6.3,
        "load_torque_Nm": 0.0,
        "supply_V": 12.0,
        "phase_resistance_ohm": 1.1,
        "phase_inductance_H": 2.6e-3,
        "detent_torque_Nm": 0.015,
        "coulomb_torque_Nm": 0.008,
        "full_step_error_pct": 5.0,
        "encoder_eccentricity_deg": 0.5,
        "encoder_nonlinearity_deg": 0.2,
        "encoder_noise_counts": 0.7,
    }
    assert {name: item.full for name, item in profile.axis.items() if item.full is not None} == {
        "viscous_Nm_s_per_rad": 4e-5,
        "torque_constant_Nm_per_A": 0.155,
        "supply_V": 24.0,
    }
    assert all(item.unit and item.source and item.about for item in profile.axis.values())
    assert profile.registers == {"diaagc": 0x0180, "errfl": 0}
    assert profile.default_hardware == "0.1"
    assert profile.hardware == {
        "0.1": HardwareVersion(supply_min_V=8, supply_max_V=25, inputs_5V=["D0", "D1"]),
        "0.2": HardwareVersion(supply_min_V=8, supply_max_V=35, inputs_5V=["D0", "D1", "D2", "D3"]),
    }


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("name: mechaduino", "name: other", "name: this is not its folder's name (write \"mechaduino\")"),
        ("law: ", "lwa: ", 'lwa: unknown key (did you mean "law"?)'),
        ("plant: simple", "plant: cubic",
         "plant: \"cubic\" is none of the choices (write 'simple' or 'full')"),
        ('default_hardware: "0.1"', 'default_hardware: "0.3"',
         'default_hardware: there is no such version (did you mean "0.2"?)'),
        ('  "0.1":', "  0.1:", 'hardware."0.1": YAML takes this key for a number'),
        ("usb: native", "usb: native\nuarts: {main: {baud: 9}}",
         "uarts.main.baud: the number 9 is too small (write 50 or more)"),
        ("usb: native", "usb: native\nuarts: {main: {}, main: {}}",
         "uarts.main: this key is given twice"),
        ("usb: native", "uarts: {}", "greeting: this board has no UART (leave this key out)"),
        ("vendor_id: 0x2341", "vendor_id: 0x12341",
         "usb_device.vendor_id: the number 74561 is too large (write 65535 or less)"),
        ("  product_id: 0x804d\n", "", "usb_device.product_id: this key is missing (add the line "),
        ("product: Arduino Zero (virtual)", "product: Zürich", "usb_device.product: "),
        ("value: 0.150", "value: -1",
         "axis.sense_resistor_ohm.value: -1 ohm is too small (write more than 0)"),
        ("    unit: ohm\n", "",
         'axis.sense_resistor_ohm.unit: this key is missing (add the line "unit: ...")'),
        ("    unit: ohm\n", "    unit: ohm\n    unot: x\n",
         "axis.sense_resistor_ohm.unot: unknown key (known are: "),
        ("inputs_5V: [D0, D1]", "inputs_5V: D0", 'hardware."0.1".inputs_5V: '),
    ],
)  # fmt: skip
def test_a_broken_profile_says_where(old: str, new: str, expected: str) -> None:
    assert problem(old, new).replace("'0.1'", '"0.1"').startswith(expected)


def test_limits_of_a_parameter() -> None:
    limited = AxisParameter(value=1.0, unit="V", minimum=-1.0, maximum=2.0, about="", source="here")
    assert limited.refusal(-1.0) is None
    assert limited.refusal(2.0) is None
    assert limited.refusal(-1.5) == ("-1.5 V is too small", "write -1 or more")
    assert limited.refusal(2.5) == ("2.5 V is too large", "write 2 or less")
    above = AxisParameter(value=1.0, unit="V", about="", source="here", above=0.0)
    assert above.refusal(0.0) == ("0 V is too small", "write more than 0")
    assert above.refusal(1e-300) is None
