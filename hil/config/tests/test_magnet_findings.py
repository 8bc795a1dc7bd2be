"""``magnet:`` of a device: which shafts it may name, and what is said of others, with their places."""

import pytest

from hil.compose.find import find_catalogue
from hil.config import BenchConfig
from hil.config.check import parse
from hil.vocab.problem import ConfigError

HEAD = """bench: b
devices:
  m1: {profile: mechaduino}
  arm: {profile: walter}
  u1: {profile: uno}
  r1: {profile: sac, at: /dev/ttyUSB7}
"""


def read(line: str) -> BenchConfig:
    return parse(HEAD + line, "b.yaml", find_catalogue())


@pytest.mark.parametrize("of", ["m1", "arm", "arm.ellbow"])
def test_a_shaft_is_a_device_or_one_of_its_axes(of: str) -> None:
    for magnet in (of, f"{{of: {of}}}"):
        config = read(f"  e1: {{profile: as5047d, magnet: {magnet}}}\n")
        magnet_read = config.devices["e1"].magnet
        assert magnet_read
        assert (magnet_read.of, magnet_read.zero_deg, magnet_read.reversed) == (of, 0.0, False)
        assert ("e1", of.partition(".")[0]) in config.joints()


def test_a_magnet_is_dumped_as_it_is_read() -> None:
    config = read("  e1: {profile: as5047d, magnet: {of: m1, zero_deg: 90, reversed: true}}\n")
    assert config.model_dump(mode="json")["devices"]["e1"]["magnet"] == {
        "of": "m1",
        "zero_deg": 90.0,
        "reversed": True,
    }


def test_there_may_be_no_magnet() -> None:
    assert read("  e1: {profile: as5047d}\n").devices["e1"].magnet is None


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (
            "  e1: {profile: as5047d, magnet: m2}\n",
            'b.yaml:7:34: devices.e1.magnet: there is no device "m2" (known are: arm, e1, m1',
        ),
        (
            "  e1: {profile: as5047d, magnet: {of: u1}}\n",
            'b.yaml:7:39: devices.e1.magnet.of: "u1" has no motor, and so no shaft that a magnet could be on'
            " (write one of m1, arm,",
        ),
        ("  e1: {profile: as5047d, magnet: e1}\n", 'b.yaml:7:34: devices.e1.magnet: "e1" has no motor'),
        (
            "  e1: {profile: as5047d, magnet: arm.elbo}\n",
            "b.yaml:7:34: devices.e1.magnet: arm has no axis 'elbo'; it has ",
        ),
        ("  e1: {profile: as5047d, magnet: r1}\n", "b.yaml:7:34: devices.e1.magnet: r1 is a real board"),
        (
            "  u2: {profile: uno, magnet: m1}\n",
            "b.yaml:7:22: devices.u2.magnet: a uno reads no magnet (leave this key out)",
        ),
        ("  e1: {profile: as5047d, magnet: {zero_deg: 3}}\n", "devices.e1.magnet.of: "),
        ("  e1: {profile: as5047d, magnet: {of: m1, zero: 3}}\n", "devices.e1.magnet.zero: "),
        ("  e1: {profile: as5047d, magnet: 3}\n", "b.yaml:7:34: devices.e1.magnet: "),
        ("  e1: {profile: as5047d, magnet: {of: m1, zero_deg: .nan}}\n", "devices.e1.magnet.zero_deg: "),
        ("  e1: {profile: as5047d, port: pty}\n", "a as5047d has no serial interface"),
        ("  e1: {profile: as5047d, plant: full}\n", "profile as5047d has no motor (leave"),
        ("  e1: {profile: as5047d, registers: {diaagk: 3}}\n", "devices.e1.registers.diaagk: "),
    ],
)
def test_what_cannot_be_is_said_where_it_stands(line: str, said: str) -> None:
    with pytest.raises(ConfigError) as refused:
        read(line)
    assert said in str(refused.value)


WIRED = """  e1: {profile: as5047d, magnet: m1}
  e2: {profile: as5047d, magnet: m1}
wires:
"""


@pytest.mark.parametrize(
    ("wires", "said"),
    [
        (
            "{from: e1.CSn, to: u1.D10}",
            "b.yaml:10:12: wires.0.from: CSn of e1 is an input (write one of MISO)",
        ),
        ("{from: u1.D12, to: e1.MISO}", "wires.0.to: MISO of e1 is an output (write one of CSn, CLK, MOSI)"),
        ("{from: u1.D13, to: e1.SCK}", 'wires.0.to: e1 has no pin "SCK" ('),
        (
            "{from: e1.MISO, to: u1.D12}\n  - {from: u1.D2, to: u1.D12}",
            "wires.1.to: u1.D12 is driven by e1.MISO already",
        ),
        (
            "{from: u1.D2, to: u1.D12}\n  - {from: e1.MISO, to: u1.D12}",
            "wires.1.to: u1.D12 is driven by u1.D2 already",
        ),
    ],
)
def test_a_wrong_wire_is_said_where_it_stands(wires: str, said: str) -> None:
    with pytest.raises(ConfigError) as refused:
        read(f"{WIRED}  - {wires}\n")
    assert said in str(refused.value)


def test_outputs_that_are_open_at_times_share_an_input() -> None:
    assert (
        len(read(f"{WIRED}  - {{from: e1.MISO, to: u1.D12}}\n  - {{from: e2.MISO, to: u1.D12}}\n").wires) == 2
    )
