"""Mistakes of a configuration file's author, and the lines with which the daemon answers."""

from pathlib import Path
from typing import Any

import pytest
from pydantic import BaseModel, ConfigDict, Field

from hil.compose import find_catalogue
from hil.config import BenchConfig, Catalogue, ConfigError, from_dict, parse, profile_from_yaml

ROOT = Path(__file__).parents[3]
PROFILE = ROOT / "device_profiles" / "mechaduino"


class PtyLike(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid")
    mode: str = Field(default="0660", pattern="^0[0-7]{3}$")
    group: str | None = None
    path: str | None = None


class TcpLike(BaseModel):
    host: str = "127.0.0.1"
    port: int = Field(ge=0, le=65535)
    log: Path | None = None


class MemoryLike(BaseModel):
    pass


CATALOGUE = Catalogue(
    {"mechaduino": profile_from_yaml((PROFILE / "profile.yaml").read_text(), PROFILE)},
    {"pty": PtyLike, "tcp": TcpLike, "memory": MemoryLike},
)


def problems(text: str) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        parse(text, "b.yaml", CATALOGUE)
    assert str(caught.value) == "\n".join(map(str, caught.value.problems))
    return [str(problem) for problem in caught.value.problems]


def device(**keys: object) -> dict[str, Any]:
    return {"bench": "t", "devices": {"m1": {"profile": "mechaduino", **keys}}}


def refusal(**keys: object) -> str:
    """The one problem of a bench whose device has these keys."""
    with pytest.raises(ConfigError) as caught:
        from_dict(device(**keys), CATALOGUE)
    (problem,) = caught.value.problems
    assert (problem.file, problem.line, problem.column) == ("<dict>", 0, 0)
    return f"{problem.message} ({problem.remedy})"


def test_the_demo_is_a_valid_bench_with_both_boards_and_defaults() -> None:
    catalogue = find_catalogue()
    demo = parse((ROOT / "examples" / "demo.yaml").read_text(), "demo.yaml", catalogue)
    calibrated = {"profile": "mechaduino", "flash": {"table": "identity"}}
    devices = {"m1": calibrated, "s1": {"profile": "sac"}}
    assert demo == from_dict({"bench": "demo", "devices": devices, "bridges": {"web": {}}}, catalogue)
    assert demo.devices["s1"].baud == 38400
    assert (demo.rate_hz, demo.speed, demo.seed, demo.cpu) == (1000, 1.0, 0, None)
    m1 = demo.devices["m1"]
    assert m1.port.kind == "pty"
    assert (m1.baud, m1.flash.table, m1.hardware, m1.plant) == (None, "identity", "0.1", "simple")
    assert m1.spi_previous_command == 0xFFFF
    assert m1.axis_parameters(CATALOGUE.profiles["mechaduino"])["supply_V"] == 12.0


def test_the_shortest_bench_of_a_test() -> None:
    config = from_dict(device(port="memory", flash={"table": "identity"}), CATALOGUE)
    assert config.devices["m1"].port.kind == "memory"
    assert config.devices["m1"].flash.table == "identity"


FULL = """\
bench: full-1
rate_hz: 6500
speed: 0.5
seed: 7
cpu: 3
runtime_dir: /run/x
state_dir: /var/x
devices:
  m1:
    profile: mechaduino
    port: {kind: pty, mode: "0666", group: dialout}
    baud: 115200
    flash: {table: ./table.bin}
    hardware: "0.2"
    plant: simple
    axis: {inertia_kg_m2: 5e-6, supply_V: 30, start_deg: -1}
    registers: {diaagc: 0x0180, errfl: 0}
    spi_previous_command: 0x3FFC
  m2: {profile: mechaduino, port: {kind: tcp, port: 5001, log: /tmp/log}}
"""


def test_every_key_is_read() -> None:
    config = parse(FULL, "b.yaml", CATALOGUE)
    m1, m2 = config.devices.values()
    assert (config.bench, config.rate_hz, config.speed, config.seed, config.cpu) == (
        "full-1",
        6500,
        0.5,
        7,
        3,
    )
    assert (config.runtime_dir, config.state_dir) == (Path("/run/x"), Path("/var/x"))
    assert m1.port.options == PtyLike(mode="0666", group="dialout")
    assert m2.port.options == TcpLike(port=5001, log=Path("/tmp/log"))
    assert (m1.baud, m1.hardware, m1.spi_previous_command) == (115200, "0.2", 0x3FFC)
    assert m1.flash.table == "./table.bin"
    axis = m1.axis_parameters(CATALOGUE.profiles["mechaduino"])
    assert (axis["inertia_kg_m2"], axis["supply_V"], axis["start_deg"]) == (5e-6, 30.0, -1.0)
    assert axis["rotor_teeth"] == 50.0
    assert m1.register_values(CATALOGUE.profiles["mechaduino"]) == {"diaagc": 0x180, "errfl": 0}


def test_all_problems_are_reported_at_once_in_file_order() -> None:
    text = """\
bench: Big
devices:
  on: {profile: mechaduno}
  1: {profil: mechaduino}
  m2:
  m3:
    profile: mechaduino
    port: {kind: pty, mode: 0660, grop: x}
    axis: {supply_V: 30, inertia: 3, start_deg: .nan}
    baud: "9600"
  m3: {}
spede: 3
"""
    assert problems(text) == [
        'b.yaml:1:8: bench: "Big" is not a name'
        " (write big: a name is a letter a-z and up to 31 more of a-z, 0-9, _ and -)",
        "b.yaml:3:3: devices.on: YAML takes this key for the truth value true, not for a name"
        ' (write it in quotes: "on")',
        'b.yaml:3:17: devices.on.profile: there is no profile "mechaduno"'
        ' (did you mean "mechaduino"? known are: mechaduino)',
        "b.yaml:4:3: devices.1: YAML takes this key for a number, not for a name"
        " (a name begins with a letter, as in m1)",
        'b.yaml:4:7: devices.1.profil: unknown key (did you mean "profile"?)',
        "b.yaml:5:6: devices.m2: keys are wanted here, not nothing"
        " (write {profile: ...}, with what it is to be)",
        "b.yaml:8:29: devices.m3.port.mode: 0660 is a number in base 8 to YAML: 432"
        ' (write 660 for the number, or "0660" in quotes for a text)',
        'b.yaml:8:35: devices.m3.port.grop: unknown key (did you mean "group"?)',
        "b.yaml:9:22: devices.m3.axis.supply_V: 30 V is outside the supply range of mechaduino 0.1"
        ' (write 8 to 25, or hardware: "0.2")',
        'b.yaml:9:26: devices.m3.axis.inertia: unknown key (did you mean "inertia_kg_m2"?)',
        "b.yaml:9:49: devices.m3.axis.start_deg: nan is not a number to compute with (write a finite number)",
        'b.yaml:10:11: devices.m3.baud: a whole number is wanted here, not "9600" (write it without quotes)',
        "b.yaml:11:3: devices.m3: this key is given twice, first in line 6 (keep one of the two)",
        'b.yaml:12:1: spede: unknown key (did you mean "speed"?)',
    ]


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", '1:1: the file is empty (begin with "bench: NAME" and "devices:")'),
        ("# nothing yet\n", '1:1: the file is empty (begin with "bench: NAME" and "devices:")'),
        ("- a\n", '1:1: keys are wanted here, not a list (write "key: value" lines, indented below)'),
        ("demo", '1:1: keys are wanted here, not "demo" (write {bench: ..., devices: ...})'),
        ("bench: t\ndevices:\n\tm1: x\n", "3:1: a tab stands where YAML wants spaces"
         " (indent with spaces, not with tabs)"),
        ("bench: a: b\n", '1:9: a colon cannot stand here: "key: value" begins a line of its own'
         " (check the indentation; text with a colon in it wants quotes)"),
        ("bench: [\n", "2:1: a value is wanted here, not the end of the file"
         " (write it, or quotes around the text)"),
        ("bench: *x\n",
         '1:8: there is no anchor "x" (an alias (*name) wants its anchor (&name) further up)'),
        ("a: 1\n---\nb: 2\n", "2:1: a second document begins here"
         " (keep one document in a file: remove the line ---)"),
        ("bench: t\x07\n", "1:9: the character U+0007 is not allowed"
         " (remove it; in double quotes it can be written as an escape)"),
        ('bench: "\\UFFFFFFFF"\n', "1:11: a number here is out of range"
         " (check the escapes (\\U...) on this line)"),
        ("[" * 3000, "1:22: nested more than 20 deep (no key is nested so deep)"),
        ("&a [*a, *a]", "1:1: there are more than 100000 values (use aliases (*) sparingly)"),
    ],
)  # fmt: skip
def test_text_that_is_no_bench_at_all(text: str, problem: str) -> None:
    assert problems(text) == ["b.yaml:" + problem]


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("yes: 1",
         "YAML takes this key for the truth value true, not for a name (write it in quotes: \"yes\")"),
        ("~: 1", "YAML takes this key for nothing, not for a name (a name begins with a letter, as in m1)"),
        ("? [a]\n: 1", "a key must be a name (write a plain name before the colon)"),
        ("<<: {a: 1}", "keys cannot be merged in with << (write them out)"),
        ("seed: !!python/name:os.system x",
         "the tag !!python/name:os.system does not fit here"
         " (remove the tag)"),
        ("seed: !!set {a}", "the tag !!set is not used here (remove the tag)"),
        ("seed: 0b_", "'0b_' is not a number (write a number)"),
        ("seed: 0x" + "f" * 17, "is too large a number (a whole number has at most 64 bits)"),
        ("seed: " + "9" * 5000, "is too long for a number (write fewer digits)"),
        ("seed: 0115200", "0115200 is a number in base 8 to YAML: 39552"
         ' (write 115200 for the number, or "0115200" in quotes for a text)'),
        ("seed: 1:30", 'a whole number is wanted here, not "1:30" (write a whole number)'),
        ("speed: 1,5", '"1,5" has a comma (write a point before decimals, as 1.5)'),
        ("seed: 9600bd",
         '"9600bd" has a unit (write it without a unit, as 9600)'),
        ("segments: {bus0: {stations: s1}}", 'a list is wanted here, not "s1" (write [s1])'),
        ("faults: none", 'a list is wanted here, not "none" (write [] for none, or leave the key out)'),
        ("speed: .inf", "inf is not a number to compute with (write a finite number)"),
        ("speed: 1e999", "inf is not a number to compute with (write a finite number)"),
        ("speed: 0", "the number 0 is too small (write more than 0.0)"),
        ("speed: 1000.5", "1000.5 is too large (write 1000.0 or less)"),
        ("rate_hz: 99", "the number 99 is too small (write 100 or more)"),
        ("rate_hz: 6501", "the number 6501 is too large (write 6500 or less)"),
        ("rate_hz: 1000.0", "a whole number is wanted here, not 1000.0 (write a whole number)"),
        ("rate_hz: on", "a whole number is wanted here, not true (write a whole number)"),
        ("cpu: -1", "the number -1 is too small (write 0 or more)"),
        ("runtime_dir: 2026",
         'YAML takes this for the number 2026; text is wanted (write it in quotes: "2026")'),
        ("runtime_dir: ~/run", "no shell expands ~ here (write the whole path)"),
        ('state_dir: ""', "this is not a path (write the path, or null)"),
        ('state_dir: "a\\0"', "holds the character NUL, which no name and no path can have (leave it out)"),
        ('state_dir: "\\uD800"', "holds half of a surrogate pair (write the character itself)"),
    ],
)  # fmt: skip
def test_one_bad_line_gives_one_problem_on_that_line(line: str, problem: str) -> None:
    (found,) = problems("bench: t\ndevices: {m1: {profile: mechaduino}}\n" + line)
    assert found.startswith("b.yaml:3:")
    assert found.endswith(problem)


@pytest.mark.parametrize(
    ("keys", "problem"),
    [
        ({"hardware": 0.1}, 'hardware: YAML takes this for 0.1; text is wanted (write it in quotes: "0.1")'),
        ({"hardware": "9"}, 'hardware: there is no hardware version "9" (known are: 0.1, 0.2)'),
        ({"plant": "cubic"}, "plant: \"cubic\" is none of the choices (write 'simple' or 'full')"),
        ({"baud": 49}, "baud: the number 49 is too small (write 50 or more)"),
        ({"baud": True}, "baud: a whole number is wanted here, not true (write a whole number)"),
        ({"axis": {"rotor_teeth": 50.5}},
         "axis.rotor_teeth: 50.5 is not a whole number (write a whole number)"),
        ({"axis": {"rotor_teeth": 0}}, "axis.rotor_teeth: 0 teeth is too small (write 1 or more)"),
        ({"axis": {"inertia_kg_m2": 0}}, "axis.inertia_kg_m2: 0 kg m2 is too small (write more than 0)"),
        ({"axis": {"supply_V": 7.9}}, "axis.supply_V: 7.9 V is outside the supply range of mechaduino 0.1"
         " (write 8 to 25)"),
        ({"axis": {"supply_V": 36}, "hardware": "0.2"}, "axis.supply_V: 36 V is outside the supply range of"
         " mechaduino 0.2 (write 8 to 35)"),
        ({"axis": {"supply_V": None}},
         "axis.supply_V: a number is wanted here, not nothing (write a number)"),
        ({"axis": []}, 'axis: keys are wanted here, not a list (write "key: value" lines, indented below)'),
        ({"registers": {"diaagc": 0x8000}},
         "registers.diaagc: the number 32768 is too large (write 32767 or less)"),
        ({"registers": {"diagac": 0}}, 'registers.diagac: unknown key (did you mean "diaagc"?)'),
        ({"spi_previous_command": -1}, "spi_previous_command: the number -1 is too small (write 0 or more)"),
        ({"flash": {"table": "identty"}}, 'flash.table: there is no such table (did you mean "identity"?;'
         " a file is written with its folder, as in ./x)"),
        ({"flash": {"tabel": "empty"}}, 'flash.tabel: unknown key (did you mean "table"?)'),
        ({"flash": None},
         'flash: keys are wanted here, not nothing (write {table: ...}; its keys are table, address)'),
        ({"port": "ptty"},
         'port: there is no kind of port "ptty" (did you mean "pty"? known are: memory, pty, tcp)'),
        ({"port": 5}, "port: the name of a kind of port is wanted here, or its options, not the number 5"
         " (known kinds are: memory, pty, tcp)"),
        ({"port": {"mode": "0660"}},
         'port.kind: this key is missing (say which kind of port, as in "kind: pty")'),
        ({"port": {"knd": "pty"}}, 'port.knd: unknown key (did you mean "kind"?)'),
        ({"port": {"kind": None}}, "port.kind: the name of a kind of port is wanted here, not nothing"
         " (known kinds are: memory, pty, tcp)"),
        ({"port": {"kind": "pty", "mode": 660}},
         "port.mode: YAML takes this for the number 660; text is wanted"
         ' (write it in quotes: "660")'),
        ({"port": {"kind": "pty", "mode": "rw"}},
         'port.mode: "rw" has the wrong form (the form is ^0[0-7]{3}$)'),
        ({"port": "tcp"}, 'port.port: this key is missing (add the line "port: ...")'),
        ({"port": {"kind": "tcp", "prot": 1}}, 'port.prot: unknown key (did you mean "port"?)'),
        ({"port": {"kind": "tcp", "port": True}}, "port.port: a whole number is wanted here, not true"
         " (write a whole number)"),
        ({"axis": {1: 2}}, "axis.1: the key 1 is not text (keys are names)"),
        ({"baud": object}, "baud: an object of type type is no configuration value"
         " (give text, a number, true, false, None, a mapping or a list)"),
        ({"baud": 10**5000}, "baud: is too large a number (a whole number has at most 64 bits)"),
    ],
)  # fmt: skip
def test_one_bad_key_of_a_device(keys: dict[str, object], problem: str) -> None:
    assert refusal(**keys) == "devices.m1." + problem


def test_a_mistyped_profile_key_is_not_reported_as_missing_too() -> None:
    with pytest.raises(ConfigError) as caught:
        from_dict({"bench": "t", "devices": {"m1": {"profle": "mechaduino"}}}, CATALOGUE)
    (problem,) = caught.value.problems
    assert problem.message == "devices.m1.profle: unknown key"


def test_a_port_that_is_not_installed_is_reported_even_as_the_default() -> None:
    without = Catalogue(CATALOGUE.profiles, {})
    with pytest.raises(
        ConfigError, match=r'devices\.m1\.port: there is no kind of port "pty" \(known are: none\)'
    ):
        from_dict(device(), without)


@pytest.mark.parametrize(
    ("first", "second", "where"),
    [
        ({"kind": "pty", "path": "/x/y"}, {"kind": "pty", "path": "/x//z/../y"}, "path"),
        ({"kind": "pty", "path": "/run/t/t/y"}, {"kind": "pty", "path": "y"}, "path"),
        ({"kind": "pty"}, {"kind": "pty", "path": "m1"}, "path"),
        ({"kind": "tcp", "port": 5000}, {"kind": "tcp", "port": 5000, "host": "127.0.0.1"}, "port"),
    ],
)
def test_two_devices_cannot_be_in_one_place(
    first: dict[str, object], second: dict[str, object], where: str
) -> None:
    data = device(port=first) | {"runtime_dir": Path("/run/t")}
    data["devices"]["m2"] = {"profile": "mechaduino", "port": second}
    with pytest.raises(ConfigError) as caught:
        from_dict(data, CATALOGUE)
    (problem,) = caught.value.problems
    assert problem.message.startswith(f"devices.m2.port.{where}: device m1 has its port in the same place")


def test_ports_in_different_places_and_any_free_port_are_fine() -> None:
    ports: list[dict[str, object]] = [
        {"kind": "tcp", "port": 0},
        {"kind": "tcp", "port": 0},
        {"kind": "tcp", "port": 5000},
        {"kind": "tcp", "port": 5000, "host": "::1"},
        {"kind": "pty"},
        {"kind": "pty", "path": "x"},
    ]
    devices = {f"m{index}": {"profile": "mechaduino", "port": port} for index, port in enumerate(ports)}
    assert isinstance(from_dict({"bench": "t", "devices": devices}, CATALOGUE), BenchConfig)


def test_a_place_is_reported_where_its_option_stands() -> None:
    text = """\
bench: t
devices:
  m1: {profile: mechaduino, port: {kind: tcp, port: 7}}
  m2: {profile: mechaduino, port: {kind: tcp, port: 7}}
"""
    assert problems(text) == [
        'b.yaml:4:53: devices.m2.port.port: device m1 has its port in the same place, "127.0.0.1:7"'
        " (give each device a place of its own)"
    ]


def test_aliases_are_read_and_errors_point_to_the_anchor() -> None:
    text = "bench: t\ndevices:\n  m1: &d {profile: mechaduino, baud: 9600}\n  m2: *d\n"
    config = parse(text, "b.yaml", CATALOGUE)
    assert config.devices["m1"] == config.devices["m2"]
    assert problems(text.replace("9600", "1"))[1].startswith("b.yaml:3:38: devices.m2.baud: ")


def test_a_hundred_devices_with_a_mistake_each_are_all_reported() -> None:
    devices = {f"m{index}": {"profile": "mechaduino", "bad": index} for index in range(100)}
    with pytest.raises(ConfigError) as caught:
        from_dict({"bench": "t", "devices": devices}, CATALOGUE)
    assert [p.message for p in caught.value.problems] == [
        f"devices.m{index}.bad: unknown key" for index in range(100)
    ]


def test_a_board_that_is_nowhere_near_a_known_one_may_be_of_your_own() -> None:
    assert problems("bench: b\ndevices: {t1: {profile: thermo}}\n") == [
        'b.yaml:2:25: devices.t1.profile: there is no profile "thermo"'
        " (known are: mechaduino; where boards of your own are, profile_path says)"
    ]
