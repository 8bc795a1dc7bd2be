"""Boards outside of hil: in folders that a configuration names, and in packages that are installed."""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import cast

import pytest
from kit_boards import BOARD, FIRMWARE, YAML, answers, bench, problems, write

from hil.compose import find_catalogue
from hil.compose.build import TableFileError
from hil.compose.find import make_bridge
from hil.config import from_dict
from hil.discovery.installed import every_point
from hil.testing import Bench
from hil.vocab.bridge_protocol import BridgeError
from hil.vocab.desk_protocol import Desk


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
        ("[empty]", "profile_path.0: there is no board in empty (a board is a folder with profile.yaml and"),
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


def test_its_python_may_be_in_another_encoding(tmp_path: Path) -> None:
    board = write(tmp_path / "boards" / "namer")
    (board / "board.py").write_bytes("# coding: latin-1\n# Gerät\n".encode("latin-1") + BOARD.encode())
    assert answers(bench(tmp_path, "namer")) == b"namer"


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
    every_point.cache_clear()
    yield folder
    every_point.cache_clear()
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
        "lab_gone of the package lab-boards: there is no package lab_gone"
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


def test_a_bridge_whose_package_is_missing_says_so_when_it_is_made(packages: Path) -> None:
    (packages / "lab_radio").mkdir()
    (packages / "lab_radio" / "bridge.py").write_text(
        PORT.replace("    return", "    import lab_aerial\n    return")
    )
    install(packages, "lab-radio", "hil.bridges", radio="lab_radio")
    options = find_catalogue().bridges["radio"]()
    with pytest.raises(
        BridgeError, match=r"bridges.radio: No module named 'lab_aerial'; install what is missing"
    ):
        make_bridge("radio", options, cast(Desk, None))


def test_a_configuration_knows_its_folders_wherever_it_is_read(tmp_path: Path) -> None:
    write(tmp_path / "boards" / "namer")
    with Bench(bench(tmp_path, "namer")) as made:
        config = made.config
    assert config.profile_path == [tmp_path / "boards"]
    dumped = config.model_dump(mode="json", exclude={"devices"}) | {"devices": {"d0": {"profile": "namer"}}}
    again = from_dict(dumped, find_catalogue())
    assert again.profile_path == config.profile_path
