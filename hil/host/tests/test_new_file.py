"""Files that are written: what is there, what is in the way, what somebody has planted."""

import ast
import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

import hil
from hil.host.new_file import begin_file, write_file

ROOT = Path(hil.__file__).parents[1]
STRANGER_UID = 65534
OWN_WAY = {
    "hil/host/new_file.py": {"open", "rename"},
    "hil/live/store.py": {"open", "rename"},  # with a second name for what was there
    "hil/cli/bench/detached.py": {"open", "replace"},  # for a process that writes on
    "hil/telemetry/picture.py": {"write_bytes", "savefig"},  # for scripts
    "hil/telemetry/path_picture.py": {"savefig"},  # into memory
    "hil/net/stable_name.py": {"replace"},  # a link
    "virtual_ports/usb/vhci.py": {"open"},  # a file of sysfs
    "hil/host/day_files.py": {"open"},  # lines are added to the file of a day
    "hil/host/journal.py": {"open"},  # standard streams
    "bridges/zenoh/site_certificates.py": {"open", "replace"},  # exclusively, and in the place of others
    "bridges/zenoh/site_folder.py": {"write_text", "replace"},  # a number, where the folder can be written
    "hil/compose/recordings_folder.py": {"open"},  # exclusively, and written to while the run goes on
    "hil/live/run_recording.py": {"write_text"},  # a mark in the bench's own folder
    "hil/lookback/look_process.py": {"write_text"},  # a file of procfs
    "hil/lookback/standing.py": {"open"},  # a pipe
    "hil/compose/bundles.py": {"open"},  # a temporary folder of its own, exclusively
    "hil/recorded/bundling.py": {"open"},  # files within a zip
    "hil/toolchain/kept_objects.py": {"rename"},  # a folder of its own, whole
    "hil/toolchain/sketch_build.py": {"write_text", "replace"},  # in a temporary folder, and out of it
    "hil/toolchain/arduino_cli.py": {"replace"},  # out of a temporary folder
    "hil/testing/serving.py": {"open", "write_text"},  # in a test's own folder
    "hil/testing/live_traffic.py": {"open"},  # a test's own file
    "hil/testing/failures/bench_capture.py": {"write_bytes"},  # the same
    "hil/testing/failures/failure_folder.py": {"open", "write_bytes", "write_text"},  # the same
    "hil/testing/seeds/seed_results.py": {"open"},  # line by line, while tests run
    "hil/testing/seeds/sent_sources.py": {"rename"},  # a folder of its own, whole
    "hil/testing/owned_time/children.py": {"open", "write_text"},  # a port; a folder of its own
}
"""Files that write in a way of their own, and the calls that they use."""
WRITES = {"write_text", "write_bytes", "rename", "replace", "open", "savefig", "copyfile"}


def left(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


def test_a_new_file_has_the_umasks_mode_and_an_old_one_keeps_its_own(tmp_path: Path) -> None:
    old = os.umask(0o027)
    try:
        write_file(tmp_path / "a", b"1")
        begin_file(tmp_path / "b").close()
    finally:
        os.umask(old)
    assert (mode(tmp_path / "a"), mode(tmp_path / "b")) == (0o640, 0o640)
    (tmp_path / "a").chmod(0o604)
    write_file(tmp_path / "a", b"2")
    assert (mode(tmp_path / "a"), (tmp_path / "a").read_bytes()) == (0o604, b"2")
    assert left(tmp_path) == {"a", "b"}


@pytest.mark.skipif(os.getuid() != 0, reason="only root can give files away")
def test_a_file_stays_its_owners(tmp_path: Path) -> None:
    (tmp_path / "a").touch()
    os.chown(tmp_path / "a", STRANGER_UID, STRANGER_UID)
    write_file(tmp_path / "a", b"1")
    found = (tmp_path / "a").stat()
    assert (found.st_uid, found.st_gid) == (STRANGER_UID, STRANGER_UID)


def test_a_link_stays_and_what_it_leads_to_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to("second")
    (tmp_path / "second").symlink_to("real/file")
    for text in (b"1", b"2"):  # to nothing, then to a file
        write_file(tmp_path / "link", text)
        assert (tmp_path / "real" / "file").read_bytes() == text
    with begin_file(tmp_path / "link", b"3") as file:
        assert (tmp_path / "real" / "file").read_bytes() == b"3"
        file.write(b"4")
    assert (tmp_path / "real" / "file").read_bytes() == b"34"
    assert (tmp_path / "link").is_symlink()
    (tmp_path / "circle").symlink_to("circle")
    with pytest.raises(OSError, match="symbolic links"):
        write_file(tmp_path / "circle", b"")


def test_what_is_planted_under_a_guessed_name_is_not_written(tmp_path: Path) -> None:
    (tmp_path / "victim").write_bytes(b"mine")
    for name in ("q.part", "q.tmp", "q.new", ".q.swp"):
        (tmp_path / name).symlink_to("victim")
    write_file(tmp_path / "q", b"1")
    assert (tmp_path / "victim").read_bytes() == b"mine"


@pytest.mark.skipif(os.getuid() != 0, reason="only root can make another user's link")
def test_a_strangers_link_in_a_folder_of_all_is_refused(tmp_path: Path) -> None:
    (tmp_path / "victim").write_bytes(b"mine")
    (tmp_path / "tmp").mkdir()
    (tmp_path / "tmp").chmod(0o1777)
    (tmp_path / "tmp" / "out").symlink_to(tmp_path / "victim")
    os.chown(tmp_path / "tmp" / "out", STRANGER_UID, STRANGER_UID, follow_symlinks=False)
    with pytest.raises(PermissionError):
        write_file(tmp_path / "tmp" / "out", b"1")
    assert (tmp_path / "victim").read_bytes() == b"mine"


def test_what_is_no_file_is_written_into(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="No space left"):
        write_file(Path("/dev/full"), b"1")
    assert stat.S_ISCHR(Path("/dev/full").stat().st_mode)
    write_file(Path("/dev/null"), b"1")
    os.mkfifo(tmp_path / "fifo")
    reader = os.open(tmp_path / "fifo", os.O_RDONLY | os.O_NONBLOCK)
    write_file(tmp_path / "fifo", b"1")
    assert os.read(reader, 9) == b"1"
    os.close(reader)
    with pytest.raises(IsADirectoryError):
        write_file(tmp_path, b"1")
    assert left(tmp_path) == {"fifo"}


@pytest.mark.parametrize("how", ["pipe", "new", "append"])
def test_dev_stdout_is_where_the_shell_has_it(tmp_path: Path, how: str) -> None:
    said = tmp_path / "said"
    said.write_bytes(b"before ")
    program = (
        "from pathlib import Path; from hil.host.new_file import write_file\n"
        "print('head', end=' ', flush=True); write_file(Path('/dev/stdout'), b'data '); print('tail', end='')"
    )
    command = f'{sys.executable} -c "{program}"'
    if how == "pipe":
        assert subprocess.check_output(["sh", "-c", command]) == b"head data tail"
        return
    subprocess.run(["sh", "-c", f"{command} {'>' if how == 'new' else '>>'} {said}"], check=True)
    assert said.read_bytes() == (b"" if how == "new" else b"before ") + b"head data tail"


def test_a_failure_leaves_what_was_and_nothing_beside_it(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"old")
    with pytest.raises(TypeError):
        write_file(tmp_path / "a", "text")  # type: ignore[arg-type]
    assert (tmp_path / "a").read_bytes() == b"old"
    assert left(tmp_path) == {"a"}
    with pytest.raises(FileNotFoundError):
        write_file(tmp_path / "no" / "a", b"")


@pytest.mark.skipif(os.getuid() == 0, reason="root may write all")
def test_what_is_protected_stays(tmp_path: Path) -> None:
    (tmp_path / "a").touch(0o444)
    with pytest.raises(PermissionError):
        write_file(tmp_path / "a", b"1")


def _writing_calls(tree: ast.AST) -> set[str]:
    found = set()
    for call in (node for node in ast.walk(tree) if isinstance(node, ast.Call)):
        name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
        texts = [each.value for each in call.args if isinstance(each, ast.Constant)]
        if name == "open":
            flags = {node.attr for node in ast.walk(call) if isinstance(node, ast.Attribute)}
            modes = {
                text for text in texts if isinstance(text, str) and len(text) < 4 and set(text) & set("wax+")
            }
            if not (modes or "O_CREAT" in flags):
                continue
        if name == "replace" and len(call.args) + len(call.keywords) != 1:
            continue  # of a text, or of a dataclass
        if name == "replace" and any(keyword.arg for keyword in call.keywords):
            continue
        if name in WRITES:
            found.add(name)
    return found


@pytest.mark.long
def test_all_of_the_product_writes_by_it() -> None:
    found = {}
    for package in ("hil", "device_profiles", "virtual_ports", "bridges"):
        for path in sorted((ROOT / package).rglob("*.py")):
            if "tests" not in path.parts and (calls := _writing_calls(ast.parse(path.read_text()))):
                found[str(path.relative_to(ROOT))] = calls
    assert not [name for name, calls in found.items() if calls - OWN_WAY.get(name, set())], found
