"""Boards outside of hil: in folders that a configuration names, and in packages that are installed."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from hil.compose import find_catalogue
from hil.compose.build import TableFileError
from hil.config import ConfigError, from_dict
from hil.discovery.installed import installed
from hil.testing import Bench

YAML = """\
name: {name}
title: A board that says its name
law: mechaduino
plant: simple
uarts:
  main: {{baud: 9600}}
default_hardware: "1"
hardware:
  "1": {{supply_min_V: 8, supply_max_V: 25, inputs_5V: []}}
axis:
  inertia_kg_m2: {{value: 5.4e-6, unit: kg m2, about: Rotor., source: chosen}}
  viscous_Nm_s_per_rad: {{value: 0.004, unit: Nm s/rad, about: Friction., source: chosen}}
  torque_constant_Nm_per_A: {{value: 0.2, unit: Nm/A, about: Torque., source: chosen}}
  rotor_teeth: {{value: 50, unit: teeth, about: Teeth., source: chosen}}
  sense_resistor_ohm: {{value: 0.15, unit: ohm, about: Resistor., source: chosen}}
  start_deg: {{value: 0, unit: deg, about: Angle., source: chosen}}
  load_torque_Nm: {{value: 0, unit: Nm, about: Load., source: chosen}}
registers: {{}}
"""
BOARD = """\
from hil.vocab.profile import Profile

from .firmware import Namer

PROFILE = Profile(firmware=Namer)
"""
FIRMWARE = """\
from hil.vocab.firmware import ByteAvailable


class Namer:
    def __init__(self, board):
        self._uart = board.uart

    def main(self):
        while True:
            yield ByteAvailable()
            self._uart.read()
            self._uart.write(b"{name}")

    def interrupt(self, event):
        pass
"""


def write(folder: Path, **changed: str) -> Path:
    """Write a board; ``changed`` has other texts of its files, by their names without ends."""
    folder.mkdir(parents=True)
    (folder / "profile.yaml").write_text(changed.get("profile", YAML.format(name=folder.name)))
    (folder / "board.py").write_text(changed.get("board", BOARD))
    (folder / "firmware.py").write_text(changed.get("firmware", FIRMWARE.format(name=folder.name)))
    return folder


def bench(folder: Path, *names: str, path: str = "[boards]") -> Path:
    text = f"bench: t\nprofile_path: {path}\ndevices:\n"
    file = folder / "bench.yaml"
    file.write_text(text + "".join(f"  d{index}: {{profile: {name}}}\n" for index, name in enumerate(names)))
    return file


def answers(file: Path, device: str = "d0") -> bytes:
    with Bench(file) as made:
        made.run(ms=10)
        made.port(device).write(b"?")
        made.run(ms=100)
        return made.port(device).read()


def problems(file: Path) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        Bench(file)
    return [str(problem).replace(f"{file.parent}/", "") for problem in caught.value.problems]


def board_problem(tmp_path: Path, **changed: str) -> str:
    """Problem of a board with this mistake, beside a good one that works on."""
    write(tmp_path / "boards" / "bad", **changed)
    write(tmp_path / "boards" / "good")
    assert answers(bench(tmp_path, "good")) == b"good"
    first, *others = problems(bench(tmp_path, "good", "bad"))
    assert first == (
        "bench.yaml:5:17: devices.d1.profile: the board bad cannot be used (mend what is said of it below)"
    )
    (found,) = others
    return found


def test_a_board_in_a_folder_beside_the_configuration(tmp_path: Path) -> None:
    write(tmp_path / "boards" / "namer")
    assert answers(bench(tmp_path, "namer")) == b"namer"
    assert answers(bench(tmp_path, "mechaduino", "namer", path=f"['{tmp_path}/boards']"), "d1") == b"namer"


def test_boards_of_one_name_in_two_benches_are_two(tmp_path: Path) -> None:
    for place, said in (("one", "first"), ("two", "second")):
        write(tmp_path / place / "boards" / "namer", firmware=FIRMWARE.format(name=said))
        assert answers(bench(tmp_path / place, "namer")) == said.encode()


def test_its_module_may_stand_in_a_package(tmp_path: Path) -> None:
    board = write(
        tmp_path / "boards" / "namer", board=BOARD.replace("Namer", "Other").replace(".firmware", ".")
    )
    (board / "__init__.py").write_text("from .firmware import Namer as Other\n")
    assert answers(bench(tmp_path, "namer")) == b"namer"


def test_two_boards_of_one_name_are_refused_with_both_places(tmp_path: Path) -> None:
    write(tmp_path / "boards" / "namer")
    write(tmp_path / "more" / "namer")
    _, found = problems(bench(tmp_path, "namer", path="[boards, more]"))
    assert found == (
        f"more/namer/profile.yaml:1:1: there are two boards namer: {tmp_path}/boards/namer, and"
        f" {tmp_path}/more/namer (give one of them another name, or leave one place out)".replace(
            f"{tmp_path}/", ""
        )
    )
    assert answers(bench(tmp_path, "namer", path="[boards, boards]")) == b"namer"  # one place, said twice


def test_a_board_of_hils_own_name_is_refused(tmp_path: Path) -> None:
    write(tmp_path / "boards" / "sac")
    _, found = problems(bench(tmp_path, "sac"))
    assert "there are two boards sac: that of hil, " in found


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ("[nowhere]", "profile_path.0: there is no folder nowhere (a relative one is looked up from this"),
        ("[boards, boards/namer]", "profile_path.1: boards/namer is a board itself (name the folder it"),
        ("[empty]", "profile_path.0: there is no board in empty (a board is a folder with board.py and"),
        ("boards", "profile_path: "),
        ("[1]", "profile_path.0: YAML takes this for the number 1; text is wanted"),
        ("[~/boards]", "profile_path.0: no shell expands ~ here"),
    ],
)
def test_a_wrong_path_is_said_with_its_place(tmp_path: Path, path: str, said: str) -> None:
    write(tmp_path / "boards" / "namer")
    (tmp_path / "empty").mkdir()
    (found, *_) = problems(bench(tmp_path, "mechaduino", path=path))
    assert found.startswith("bench.yaml:2:")
    assert said in found


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    board = write(tmp_path / "boards" / "namer")
    (board / "board.py").unlink()
    (board / "profile.yaml").rename(board / "profile.yml")
    with pytest.raises(ConfigError, match="there is no board in"):
        Bench(bench(tmp_path, "namer"))
    (board / "profile.yml").rename(board / "profile.yaml")
    assert problems(bench(tmp_path, "namer"))[1].startswith(
        "boards/namer/board.py:1:1: this file is missing ("
    )
    (board / "board.py").write_text(BOARD)
    (board / "profile.yaml").unlink()
    assert problems(bench(tmp_path, "namer"))[1].startswith("boards/namer/profile.yaml:1:1: No such file")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("name: bad", "name: other", "1:7: name: this is not its folder's name"),
        ("law: ", "lwa: ", '3:1: lwa: unknown key (did you mean "law"?)'),
        ("law: mechaduino", "law: mechanical", "3:6: law: there is no such control law"),
        (
            "value: 0.2",
            "value: strong",
            "13:37: axis.torque_constant_Nm_per_A.value: a number is wanted here",
        ),
        ("unit: Nm/A", "unit: Ncm/A", '13:48: axis.torque_constant_Nm_per_A.unit: "Ncm/A" is not the unit'),
        ("start_deg", "stop_deg", "16:3: axis.stop_deg: neither the law mechaduino nor a plant has this"),
        ("  main: {{baud: 9600}}", "  main: {{}}\n  main: {{}}", "7:3: uarts.main: this key is given twice"),
        ("baud: 9600", "baud: fast", "6:16: uarts.main.baud: a whole number is wanted here"),
    ],
)
def test_a_mistake_in_profile_yaml(tmp_path: Path, old: str, new: str, said: str) -> None:
    text = YAML.replace(old.replace("bad", "{name}"), new, 1).format(name="bad")
    write(tmp_path / "boards" / "bad", profile=text)
    write(tmp_path / "boards" / "good")
    assert answers(bench(tmp_path, "good")) == b"good"
    found = problems(bench(tmp_path, "bad"))[1:]
    assert any(each.startswith(f"boards/bad/profile.yaml:{said}") for each in found), found


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"board": "x = 1\n"}, "board.py:1:1: there is no PROFILE here (write PROFILE = Profile("),
        ({"board": "\nPROFILE = {}\n"}, "board.py:2:11: PROFILE is no Profile, but a dict"),
        ({"board": "import nowhere_at_all\n"}, "board.py:1:1: ModuleNotFoundError: No module named"),
        ({"board": BOARD.replace(".firmware", "bad.firmware")}, "board.py:3:1: ModuleNotFoundError: No mod"),
        ({"board": BOARD.replace("Namer", "Nmr")}, "board.py:3:1: ImportError: cannot import name 'Nmr'"),
        ({"board": BOARD.replace("firmware=", "firmwre=")}, "board.py:5:11: TypeError: Profile.__init__()"),
        ({"board": BOARD + "PROFILE = 1 / 0\n"}, "board.py:6:11: ZeroDivisionError: division by zero (mend"),
        ({"board": "\nif\n"}, "board.py:2:3: SyntaxError: invalid syntax"),
        ({"board": "raise SystemExit('no')\n"}, "board.py:1:1: SystemExit: no"),
        ({"firmware": "\n\nraise OSError('no adapter')\n"}, "firmware.py:3:1: OSError: no adapter"),
        (
            {"board": "from hil.vocab.profile import Profile\n\nPROFILE = Profile(\n    firmware='Namer')\n"},
            "board.py:4:14: firmware: a class or a function that takes a Board is wanted here, not this str",
        ),
    ],
)  # fmt: skip
def test_a_mistake_in_its_python(tmp_path: Path, changed: dict[str, str], said: str) -> None:
    assert board_problem(tmp_path, **changed).startswith(f"boards/bad/{said}")


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ("uarts=9600", "14: uarts: a mapping of names to UartSpec is wanted here, not this int"),
        (
            "axes={'elbow': AxisSpec(about='')}",
            "13: axes: these are elbow, and those of profile.yaml none (write the same names in both)",
        ),
        ("axes=('elbow',)", "13: axes: a mapping of names to AxisSpec is wanted here, not this tuple"),
        ("uarts={}", "14: uarts: there is none, which a device's port is at (write one)"),
        (
            "uarts={'usb': UartSpec(about='')}",
            "14: uarts: these are usb, and those of profile.yaml main (write the same names in both)",
        ),
        (
            "uarts={'main': UartSpec(about=''), 'bus': UartSpec(about='')}",
            "14: uarts: these are main, bus, and those of profile.yaml main (write the same names in both)",
        ),
        ("uarts={'main': UartSpec(about='a'), 'main': UartSpec(about='b')}", "44: 'main' is given twice"),
        ("verbs=[Verb('ping', '')]", "14: verbs: a tuple of Verb is wanted here, not this list"),
        ("verbs=(Verb('ping', ''), Verb('ping', ''))", '14: verbs: there are two verbs "ping"'),
        ("verbs=(Verb('reset', ''),)", '14: verbs: there are two verbs "reset"'),
        ("dialogues={'stpo': Namer}", '18: dialogues: there is no verb "stpo" (write one of pin, reset'),
        ("dialogues={'reset': 1}", "18: dialogues: a mapping of verbs' names to functions is wanted here"),
        ("starve=1", "15: starve: a function is wanted here"),
        ("follow=1", "15: follow: a function is wanted here"),
        ("terminal_axis='x'", "22: terminal_axis: a class is wanted here"),
        ("commands=()", "17: commands: a function is wanted here"),
        ("shown_first=['r']", "20: shown_first: a tuple of fields' names is wanted here"),
        ("examples=('?',)", "17: examples: a tuple of Example with bytes is wanted here"),
        ("examples=(Example(types='?', answer=b''),)", "17: examples: a tuple of Example with bytes is"),
        (
            "examples=(Example(types=b'', answer=b'', uart='bus'),)",
            '17: examples: there is no serial interface "bus" (write one of main)',
        ),
        ("memory_file='table'", "20: memory_file: a MemoryFile is wanted here"),
    ],
)  # fmt: skip
def test_a_part_of_profile_that_does_not_do(tmp_path: Path, parts: str, said: str) -> None:
    text = (
        "from hil.vocab.profile import AxisSpec, Example, Profile, UartSpec\n"
        "from hil.vocab.verbs import Verb\n"
        f"from .firmware import Namer\nPROFILE = Profile(\n       {parts},\n    firmware=Namer)\n"
    )
    assert board_problem(tmp_path, board=text).startswith(f"boards/bad/board.py:5:{said}")


@pytest.mark.parametrize(
    ("file", "content", "said"),
    [
        ("profile.yaml", b"", "profile.yaml:1:1: keys are wanted here, not nothing"),
        ("profile.yaml", b"\xff\xfe", "profile.yaml:1:1: this is not UTF-8 text"),
        ("profile.yaml", b"name: bad\n\tlaw: sac\n", "profile.yaml:2:1: found character"),
        ("board.py", b"\xff\xfe", "board.py:1:2: SyntaxError: (unicode error)"),
        ("board.py", b"{}['x']\n", "board.py:1:1: KeyError: 'x' (mend this line)"),
        (
            "board.py",
            b"def f():\n    f()\n\n\nf()\n",
            "board.py:2:5: RecursionError: maximum",
        ),
    ],
)
def test_a_file_that_is_none(tmp_path: Path, file: str, content: bytes, said: str) -> None:
    (write(tmp_path / "boards" / "bad") / file).write_bytes(content)
    assert problems(bench(tmp_path, "bad"))[1].startswith(f"boards/bad/{said}")


def test_its_python_may_be_in_another_encoding(tmp_path: Path) -> None:
    board = write(tmp_path / "boards" / "namer")
    (board / "board.py").write_bytes("# coding: latin-1\n# Gerät\n".encode("latin-1") + BOARD.encode())
    assert answers(bench(tmp_path, "namer")) == b"namer"


def test_a_mended_board_works_in_the_same_process(tmp_path: Path) -> None:
    board = write(tmp_path / "boards" / "namer", firmware="1 / 0\n")
    assert "firmware.py:1:1: ZeroDivisionError" in problems(bench(tmp_path, "namer"))[1]
    (board / "firmware.py").write_text(FIRMWARE.format(name="well again"))
    assert answers(bench(tmp_path, "namer")) == b"well again"


MEMORY = """\
from hil.vocab.profile import MemoryFile, Profile

from .firmware import Namer


def read(content):
    if not content.startswith(b"names:"):
        raise ValueError("it does not begin with names:")
    return content[6:]


FILE = MemoryFile(section="names", most_bytes=100, read=read, named={"identity": lambda: b"myself"})
PROFILE = Profile(firmware=Namer, memory_file=FILE)
"""


def test_a_memory_begins_with_a_file_that_the_board_reads(tmp_path: Path) -> None:
    write(tmp_path / "boards" / "namer", board=MEMORY)
    (tmp_path / "good.txt").write_text("names:ab")
    (tmp_path / "bad.txt").write_text("ab")
    file = tmp_path / "bench.yaml"
    text = "bench: t\nprofile_path: [boards]\ndevices:\n  d: {profile: %s, flash: {table: %s}}\n"
    for table, content in (
        ("./good.txt", {"names": b"ab"}),
        ("identity", {"names": b"myself"}),
        ("empty", {}),
    ):
        file.write_text(text % ("namer", table))
        with Bench(file) as made:
            assert made.device("d").nvm == content
    file.write_text(text % ("namer", "./bad.txt"))
    with pytest.raises(TableFileError, match=r"bad\.txt: it does not begin with names:"):
        Bench(file)
    file.write_text(text % ("sac", "./good.txt"))
    assert problems(file) == [
        "bench.yaml:4:36: devices.d.flash.table: the memory of a sac begins with no table"
        " (write stored or empty)"
    ]
    file.write_text(text % ("sac", "identity"))
    with Bench(file) as made:
        assert made.device("d").nvm == {}


def test_a_table_that_the_board_does_not_know_is_refused(tmp_path: Path) -> None:
    write(tmp_path / "boards" / "namer", board=MEMORY.replace("identity", "mine"))
    file = tmp_path / "bench.yaml"
    devices = "devices: {d: {profile: namer, flash: {table: identity}}}\n"
    file.write_text(f"bench: t\nprofile_path: [boards]\n{devices}")
    assert problems(file) == [
        "bench.yaml:3:46: devices.d.flash.table: a namer has no such table (known are: empty, mine, stored)"
    ]


@pytest.fixture
def packages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder that packages are imported from, as if they were installed."""
    folder = tmp_path / "site"
    folder.mkdir()
    monkeypatch.syspath_prepend(folder)
    installed.cache_clear()
    yield folder
    installed.cache_clear()
    for name in [name for name in sys.modules if name.startswith("lab_")]:
        del sys.modules[name]


def install(packages: Path, distribution: str, group: str, **points: str) -> None:
    info = packages / f"{distribution}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: 1.0\n")
    lines = "".join(f"{name} = {value}\n" for name, value in points.items())
    (info / "entry_points.txt").write_text(f"[{group}]\n{lines}")


def test_a_board_of_an_installed_package(tmp_path: Path, packages: Path) -> None:
    board = write(packages / "lab_boards" / "lab_namer", profile=YAML.format(name="namer"))
    (board.parent / "__init__.py").touch()
    (board / "__init__.py").touch()
    install(packages, "lab-boards", "hil.profiles", namer="lab_boards.lab_namer")
    assert answers(bench(tmp_path, "namer", path="[]")) == b"lab_namer"
    write(tmp_path / "boards" / "namer")
    _, found = problems(bench(tmp_path, "namer"))
    assert "two boards namer: lab_boards.lab_namer of the package lab-boards, and boards/namer (give" in found


def test_a_package_that_is_not_there_spoils_its_board_only(tmp_path: Path, packages: Path) -> None:
    install(packages, "lab-boards", "hil.profiles", namer="lab_gone", other="lab_gone.deeper")
    write(tmp_path / "boards" / "good")
    assert answers(bench(tmp_path, "good")) == b"good"
    _, found = problems(bench(tmp_path, "namer", path="[]"))
    assert found == (
        "lab_gone of the package lab-boards:0:0: there is no package lab_gone"
        ' (mend the entry point namer = "lab_gone" of its package)'
    )
    assert "lab_gone.deeper cannot be found" in problems(bench(tmp_path, "other", path="[]"))[1]


PORT = """\
from pydantic import BaseModel


class Options(BaseModel):
    depth: int = 1


def make(options, context):
    return ("made", options.depth)
"""


def test_a_port_of_an_installed_package(tmp_path: Path, packages: Path) -> None:
    (packages / "lab_pipe").mkdir()
    (packages / "lab_pipe" / "port.py").write_text(PORT)
    install(packages, "lab-ports", "hil.ports", pipe="lab_pipe", broken="lab_gone", tcp="lab_pipe")
    file = tmp_path / "bench.yaml"
    text = "bench: t\ndevices:\n  m1: {profile: mechaduino, port: {kind: pipe, depth: %s}}\n"
    file.write_text(text % 3)
    with Bench(file) as made:
        assert made.config.devices["m1"].port.options.model_dump() == {"depth": 3}
    file.write_text(text % "deep")
    assert problems(file)[0].startswith("bench.yaml:3:55: devices.m1.port.depth: a whole number is wanted")
    file.write_text("bench: t\ndevices:\n  m1: {profile: mechaduino, port: broken}\n")
    assert problems(file)[0].startswith(
        "bench.yaml:3:35: devices.m1.port: port broken cannot be used: Module"
    )
    file.write_text("bench: t\ndevices:\n  m1: {profile: mechaduino, port: tcp}\n")
    assert problems(file)[0].startswith(
        "bench.yaml:3:35: devices.m1.port: port tcp cannot be used: there are two of this name:"
        " that of hil, and lab_pipe of the package lab-ports (uninstall one of them)"
    )


def test_a_bridge_of_an_installed_package(tmp_path: Path, packages: Path) -> None:
    (packages / "lab_door").mkdir()
    (packages / "lab_door" / "bridge.py").write_text(PORT)
    (packages / "lab_shut").mkdir()
    (packages / "lab_shut" / "bridge.py").write_text("import json\n\nraise OSError('no key')\n")
    install(packages, "lab-doors", "hil.bridges", door="lab_door", shut="lab_shut")
    file = tmp_path / "bench.yaml"
    text = "bench: t\ndevices:\n  m1: {profile: mechaduino}\nbridges:\n  %s\n"
    file.write_text(text % "door: {depth: 2}")
    with Bench(file) as made:
        assert made.config.bridges["door"].model_dump() == {"depth": 2}
    file.write_text(text % "shut: {}")
    (found,) = problems(file)
    assert found.startswith("bench.yaml:5:3: bridges.shut: bridge shut cannot be used: ")
    assert "lab_shut/bridge.py:3: OSError: no key (mend the package lab_shut.bridge)" in found
    assert "door" in find_catalogue().bridges


def test_a_configuration_knows_its_folders_wherever_it_is_read(tmp_path: Path) -> None:
    write(tmp_path / "boards" / "namer")
    with Bench(bench(tmp_path, "namer")) as made:
        config = made.config
    assert config.profile_path == [tmp_path / "boards"]
    dumped = config.model_dump(mode="json", exclude={"devices"}) | {"devices": {"d0": {"profile": "namer"}}}
    again = from_dict(dumped, find_catalogue())
    assert again.profile_path == config.profile_path
