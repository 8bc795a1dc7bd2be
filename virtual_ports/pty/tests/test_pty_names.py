"""The stable name and who may open it: what is replaced, what is refused, and with what remedy."""

import asyncio
import grp
import os
import re
import socket
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from pydantic import ValidationError

from hil.testing.ports import open_fds
from hil.vocab.ports import PortContext, PortError
from virtual_ports.pty.port import Options, make


class DeafHost:
    def received(self, data: bytes) -> None: ...

    def room(self) -> int:
        return 1

    def drained(self) -> None: ...

    def client_left(self, baud: int | None) -> None: ...

    def port_failed(self, reason: str) -> None:
        raise AssertionError(reason)


def open_and_close(options: Options, directory: Path, while_open: Callable[[str], None]) -> None:
    async def main() -> None:
        port = make(options, PortContext("b", "m1", directory))
        await port.open(DeafHost())
        try:
            while_open(port.address)
        finally:
            await port.close()

    asyncio.run(main())


def refused(options: Options, directory: Path) -> str:
    """Open a port that is refused, and return the error's text; nothing may be left open."""
    fds = open_fds()
    with pytest.raises(PortError) as error:
        open_and_close(options, directory, lambda address: None)
    assert open_fds() == fds
    text = str(error.value)
    assert text.startswith("pty port of m1: ")
    assert "\n" not in text
    return text


def test_the_name_is_a_symlink_to_a_pts_and_goes_with_the_port(tmp_path: Path) -> None:
    directory = tmp_path / "run" / "bench"

    def while_open(address: str) -> None:
        assert address == str(directory / "m1")
        assert re.fullmatch(r"/dev/pts/\d+", os.readlink(address))
        assert os.listdir(directory) == ["m1"]

    directory.mkdir(parents=True)
    open_and_close(Options(), directory, while_open)
    assert os.listdir(directory) == []


def test_folders_that_were_made_for_names_go_with_the_last_of_them(tmp_path: Path) -> None:
    kept, made = tmp_path / "kept", tmp_path / "kept" / "new" / "arms"
    kept.mkdir()

    async def two() -> None:
        ports = [
            make(Options(path=str(made / name)), PortContext("b", "m1", tmp_path))
            for name in ("left", "right")
        ]
        for port in ports:
            await port.open(DeafHost())
        await ports[0].close()
        assert os.listdir(made) == ["right"]
        await ports[1].close()

    asyncio.run(two())
    assert os.listdir(kept) == []

    def with_notes(address: str) -> None:
        (made.parent / "notes").write_text("")

    open_and_close(Options(path=str(made / "left")), tmp_path, with_notes)
    assert os.listdir(made.parent) == ["notes"]
    (made.parent / "notes").unlink()
    made.mkdir()  # another's now
    open_and_close(Options(path=str(made / "left")), tmp_path, lambda address: None)
    assert made.is_dir()


@pytest.mark.thorough
def test_folders_of_a_name_that_cannot_be_are_not_left(tmp_path: Path) -> None:
    for path in ("new/arms/" + "x" * 300, "new/" + "x" * 300 + "/m1"):
        assert "choose another path:" in refused(Options(path=str(tmp_path / path)), tmp_path)
        assert os.listdir(tmp_path) == []


def test_a_path_of_ones_own(tmp_path: Path) -> None:
    for given, expected in (
        (str(tmp_path / "abs" / "tty"), tmp_path / "abs" / "tty"),
        ("arms/left", tmp_path / "run" / "arms" / "left"),
    ):

        def while_open(address: str, expected: Path = expected) -> None:
            assert address == str(expected)
            assert expected.is_symlink()

        open_and_close(Options(path=given), tmp_path / "run", while_open)
        assert not expected.is_symlink()


def test_a_stale_symlink_is_replaced(tmp_path: Path) -> None:
    master, slave = os.openpty()
    try:
        for target in ("/dev/pts/999999", "/nowhere/at/all", os.ttyname(slave)):
            (tmp_path / "m1").symlink_to(target)

            def while_open(address: str, target: str = target) -> None:
                assert os.readlink(address) != target

            open_and_close(Options(), tmp_path, while_open)
            assert os.listdir(tmp_path) == []
    finally:
        os.close(master)
        os.close(slave)


@pytest.mark.parametrize("leaves_first", [0, 1, 2])
def test_of_ports_with_one_name_it_points_at_the_newest_that_is_open(
    tmp_path: Path, leaves_first: int
) -> None:
    async def main() -> None:
        ports = [make(Options(), PortContext("b", "m1", tmp_path)) for _ in range(3)]
        targets = []
        for port in ports:
            await port.open(DeafHost())
            targets.append(os.readlink(port.address))
        for n in (leaves_first, *({0, 1, 2} - {leaves_first})):
            await ports[n].close()
            targets[n] = ""
            left = [target for target in targets if target]
            assert [os.readlink(path) for path in tmp_path.iterdir()] == left[-1:]

    asyncio.run(main())


def test_a_name_that_another_has_taken_meanwhile_is_left_to_it(tmp_path: Path) -> None:
    def take(address: str) -> None:
        os.unlink(address)
        os.symlink("/dev/pts/999999", address)

    open_and_close(Options(), tmp_path, take)
    assert os.readlink(tmp_path / "m1") == "/dev/pts/999999"
    os.unlink(tmp_path / "m1")
    open_and_close(Options(), tmp_path, os.unlink)
    assert os.listdir(tmp_path) == []


@pytest.mark.thorough
@pytest.mark.long
def test_what_is_no_symlink_to_a_pts_is_refused_and_kept(tmp_path: Path) -> None:
    name = tmp_path / "m1"

    def identity() -> tuple[int, int, int]:
        found = name.lstat()
        return found.st_ino, found.st_mode, found.st_mtime_ns

    def expect(kind: str) -> None:
        before = identity()
        text = refused(Options(), tmp_path)
        assert f"{name} is {kind}, not a symlink to a terminal; remove it or choose another path:" in text
        assert identity() == before
        assert os.listdir(tmp_path) == ["m1"]

    name.write_text("notes")
    expect("a regular file")
    name.unlink()
    name.mkdir()
    expect("a directory")
    name.rmdir()
    os.mkfifo(name)
    expect("a fifo")
    name.unlink()
    with socket.socket(socket.AF_UNIX) as bound:
        bound.bind(str(name))
        expect("a socket")
    name.unlink()
    name.symlink_to("/dev/null")
    expect("a symlink to /dev/null")


def test_a_directory_that_cannot_be_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for directory in (tmp_path / "file", tmp_path / "file" / "below"):
        text = refused(Options(), directory)
        assert "is not a directory; choose another path:" in text
    assert "choose another path:" in refused(Options(path="x" * 300), tmp_path)


def test_a_directory_without_write_permission_is_refused_with_the_remedy() -> None:
    """Open the port in a child of another user: root may write anywhere."""
    code = (
        "import os,sys\n"
        "import asyncio\n"
        "from pathlib import Path\n"
        "from hil.vocab.ports import PortContext, PortError\n"
        "from virtual_ports.pty.port import Options\n"
        "from virtual_ports.pty.pty_port import PtyPort\n"
        "if os.geteuid() == 0: os.setgroups([]); os.setgid(65534); os.setuid(65534)\n"
        "for options in (Options(), Options(group=sys.argv[2])):\n"
        "    try: asyncio.run(PtyPort(options, PortContext('b', 'm1', Path(sys.argv[1]))).open(None))\n"
        "    except PortError as error: print(error)\n"
    )
    foreign = next(group.gr_name for group in grp.getgrall() if group.gr_gid not in (65534, *os.getgroups()))
    child = subprocess.run(
        [sys.executable, "-c", code, "/usr", foreign], capture_output=True, text=True, check=True
    )
    no_directory, no_group = child.stdout.splitlines()
    assert "no permission to write in /usr; give user " in no_directory
    assert "or choose another path:" in no_directory
    assert f"to group '{foreign}'; add user " in no_group
    assert "or set group: null" in no_group


def test_mode_and_group_are_those_asked_for(tmp_path: Path) -> None:
    group = grp.getgrgid(os.getegid())

    def while_open(address: str) -> None:
        status = os.stat(address)
        assert stat.S_IMODE(status.st_mode) == 0o600
        assert status.st_gid == group.gr_gid

    open_and_close(Options(mode="0600", group=group.gr_name), tmp_path, while_open)

    def by_default(address: str) -> None:
        assert stat.S_IMODE(os.stat(address).st_mode) == 0o660

    open_and_close(Options(), tmp_path, by_default)


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may give a terminal to any group")
def test_the_services_group_is_for_ports_that_name_none(tmp_path: Path) -> None:
    async def group_of(options: Options) -> str:
        port = make(options, PortContext("b", "m1", tmp_path, "dialout"))
        await port.open(DeafHost())
        try:
            return grp.getgrgid(os.stat(port.address).st_gid).gr_name
        finally:
            await port.close()

    assert asyncio.run(group_of(Options())) == "dialout"
    assert asyncio.run(group_of(Options(group="audio"))) == "audio"


def test_an_unknown_group_is_refused(tmp_path: Path) -> None:
    text = refused(Options(group="no-such-group"), tmp_path)
    assert "there is no group 'no-such-group'; create it or choose another group:" in text
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize(
    "options",
    [
        {"mode": 0o660},
        {"mode": "rw-rw----"},
        {"mode": "0060"},
        {"mode": "4660"},
        {"path": ""},
        {"baud": 9600},
    ],
)
def test_options_that_mean_nothing_are_refused(options: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        Options.model_validate(options)


def test_every_option_is_described() -> None:
    assert all("description" in field for field in Options.model_json_schema()["properties"].values())
