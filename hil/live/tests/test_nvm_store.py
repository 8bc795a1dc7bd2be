import errno
import struct
import threading
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from hil.firmware.nvm import MAGIC, Content, encode
from hil.live.store import Loaded, NvmStore, StoreCalls, StoreError

DATA = Path(__file__).parent / "data"
OLD = Content("mechaduino", 1, {"table": b"old" * 1000})
NEW = Content("mechaduino", 2, {"table": b"new" * 1000})
EMPTY = Content("mechaduino", 0, {})


class FailingFiles(StoreCalls):
    """The real calls, of which those that ``fails(number)`` picks (counted from 0) fail with ``code``.

    As on Linux, a failing close has closed, and a failing write may have written a part.
    """

    def __init__(self, code: int, fails: Callable[[int], bool]) -> None:
        self.calls: list[str] = []
        self._code = code
        self._fails = fails

    def _call(self, name: str) -> None:
        number = len(self.calls)
        self.calls.append(name)
        if self._fails(number):
            raise OSError(self._code, errno.errorcode[self._code])

    def create(self, path: Path) -> int:
        self._call("create")
        return super().create(path)

    def write(self, fd: int, data: memoryview) -> int:
        written = super().write(fd, data[: max(1, len(data) // 2)])
        self._call("write")
        return written

    def open_directory(self, path: Path) -> int:
        self._call("open_directory")
        return super().open_directory(path)

    def fsync(self, fd: int) -> None:
        self._call("fsync")
        super().fsync(fd)

    def close(self, fd: int) -> None:
        super().close(fd)
        self._call("close")

    def link(self, existing: Path, new: Path) -> None:
        self._call("link")
        super().link(existing, new)

    def rename(self, old: Path, new: Path) -> None:
        self._call("rename")
        super().rename(old, new)

    def unlink(self, path: Path) -> None:
        self._call("unlink")
        super().unlink(path)


@contextmanager
def opened(directory: Path, files: StoreCalls | None = None) -> Iterator[NvmStore]:
    store = NvmStore(directory, files)
    try:
        yield store
    finally:
        store.close()


def commit(directory: Path, content: Content, files: StoreCalls | None = None) -> tuple[bool, str]:
    answers: list[tuple[bool, str]] = []
    with opened(directory, files) as store:
        store.commit("m1", content, lambda ok, reason: answers.append((ok, reason)))
    (answer,) = answers
    return answer


def load(directory: Path) -> Loaded:
    with opened(directory) as store:
        return loaded_from(store, "m1")


def loaded_from(store: NvmStore, device: str) -> Loaded:
    """Load a memory as a start does: a file that is of no use is kept aside."""
    found = store.look(device, "mechaduino")
    kept = store.keep_aside(device, found.unfit) if found.unfit else None
    return replace(found, note=kept.note) if kept else found


def names(directory: Path) -> set[str]:
    return {path.name for path in directory.iterdir()}


def version_1(body: bytes) -> bytes:
    signed = MAGIC + struct.pack("<H", 1)
    return signed + struct.pack("<I", zlib.crc32(signed + body)) + body


def test_a_device_without_a_file_has_an_empty_memory(tmp_path: Path) -> None:
    assert load(tmp_path) == Loaded(EMPTY, None)


def test_what_was_committed_is_loaded(tmp_path: Path) -> None:
    assert commit(tmp_path, OLD) == (True, "")
    assert commit(tmp_path, NEW) == (True, "")
    assert load(tmp_path) == Loaded(NEW, None)
    assert names(tmp_path) == {"m1.nvm"}


def test_commits_are_answered_in_order_and_off_the_callers_thread(tmp_path: Path) -> None:
    answers: list[tuple[int, bool, bool]] = []

    def done(counter: int) -> Callable[[bool, str], None]:
        here = threading.get_ident()
        return lambda ok, reason: answers.append((counter, ok, threading.get_ident() != here))

    with opened(tmp_path) as store:
        for counter in range(50):
            store.commit("m1", Content("mechaduino", counter, {}), done(counter))
    assert answers == [(counter, True, True) for counter in range(50)]
    assert load(tmp_path).content.counter == 49


def test_a_commit_stores_the_content_of_its_own_time(tmp_path: Path) -> None:
    sections = {"table": b"then"}
    held = threading.Event()

    def hold_the_worker(ok: bool, reason: str) -> None:
        held.wait(10)

    with opened(tmp_path) as store:
        store.commit("m0", EMPTY, hold_the_worker)
        store.commit("m1", Content("mechaduino", 1, sections), lambda ok, reason: None)
        sections["table"] = b"later"
        held.set()
    assert load(tmp_path).content.sections == {"table": b"then"}


def test_a_done_that_raises_does_not_stop_the_store(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    def gone(ok: bool, reason: str) -> None:
        raise RuntimeError("Event loop is closed")

    with opened(tmp_path) as store:
        store.commit("m1", OLD, gone)
        store.commit("m1", NEW, gone)
    assert load(tmp_path).content == NEW
    assert "m1: the end of a commit could not be reported" in caplog.text


def test_a_closed_store_takes_nothing(tmp_path: Path) -> None:
    store = NvmStore(tmp_path)
    store.close()
    store.close()
    with pytest.raises(RuntimeError, match="closed"):
        store.commit("m1", OLD, lambda ok, reason: None)


@pytest.mark.parametrize("device", ["", "../m1", "a/b", "/etc/m1", "a/"])
def test_a_device_name_cannot_leave_the_directory(tmp_path: Path, device: str) -> None:
    with opened(tmp_path) as store, pytest.raises(ValueError, match="not a file name"):
        store.commit(device, OLD, lambda ok, reason: None)


def test_a_missing_directory_is_named(tmp_path: Path) -> None:
    with pytest.raises(StoreError, match="no-such is not a directory"):
        NvmStore(tmp_path / "no-such")


def test_damaged_files_are_kept_aside(tmp_path: Path) -> None:
    path = tmp_path / "m1.nvm"
    for number, data in enumerate([encode(OLD)[:-1], b"", encode(OLD) + b"\x00"], start=1):
        path.write_bytes(data)
        loaded = load(tmp_path)
        aside = f"m1.nvm.damaged-{number}"
        assert loaded.content == EMPTY
        assert loaded.note is not None
        assert aside in loaded.note
        assert "\n" not in loaded.note
        assert (tmp_path / aside).read_bytes() == data
        assert not path.exists()
    assert load(tmp_path) == Loaded(EMPTY, None)


def test_a_newer_file_is_refused_and_stays_as_it_is(tmp_path: Path) -> None:
    signed = MAGIC + struct.pack("<H", 3)
    newer = signed + struct.pack("<I", zlib.crc32(signed))
    (tmp_path / "m1.nvm").write_bytes(newer)
    with pytest.raises(StoreError, match=r"m1\.nvm: format version 3 is unknown: .* newer program"):
        load(tmp_path)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"m1.nvm": newer}


@pytest.mark.parametrize("version", [1, 2])
def test_a_file_that_an_earlier_program_wrote_is_read(tmp_path: Path, version: int) -> None:
    """The files were written when the version was new; they are never written again."""
    (tmp_path / "m1.nvm").write_bytes((DATA / f"memory_v{version}.nvm").read_bytes())
    counter, name = (0, "") if version == 1 else (41, "lookup")
    assert load(tmp_path).content == Content("mechaduino", counter, {name: bytes(range(256)) * 4})


def test_the_memory_of_another_profile_is_kept_aside(tmp_path: Path) -> None:
    (tmp_path / "m1.nvm").write_bytes(encode(Content("walter", 5, {"id": b"9"})))
    loaded = load(tmp_path)
    assert loaded.content == EMPTY
    assert loaded.note is not None
    assert "'walter'" in loaded.note
    assert "m1.nvm.damaged-1" in loaded.note


def test_an_older_file_is_migrated(tmp_path: Path) -> None:
    (tmp_path / "m1.nvm").write_bytes(version_1(b"settings"))
    loaded = load(tmp_path)
    assert loaded.content == Content("mechaduino", 0, {"": b"settings"})
    assert loaded.note is not None
    assert "version 1 was migrated to 2" in loaded.note
    assert commit(tmp_path, loaded.content) == (True, "")
    assert load(tmp_path) == Loaded(loaded.content, None)


def test_a_file_that_cannot_be_read_or_kept_aside_stops_the_load(tmp_path: Path) -> None:
    (tmp_path / "m1.nvm").mkdir()
    with opened(tmp_path) as store, pytest.raises(StoreError, match="cannot be read"):
        loaded_from(store, "m1")
    (tmp_path / "m2.nvm").write_bytes(b"junk")
    read_only = FailingFiles(errno.EROFS, lambda number: True)
    with opened(tmp_path, read_only) as store, pytest.raises(StoreError, match=r"cannot be kept as .*EROFS"):
        loaded_from(store, "m2")
    assert (tmp_path / "m2.nvm").read_bytes() == b"junk"


def calls_of_a_commit(directory: Path, content: Content) -> list[str]:
    counting = FailingFiles(errno.EIO, lambda number: False)
    assert commit(directory, content, counting) == (True, "")
    return counting.calls


def prepared(directory: Path, had_old: bool) -> Path:
    directory.mkdir()
    if had_old:
        assert commit(directory, OLD) == (True, "")
        (directory / "m1.nvm.old").write_bytes(b"of a process that was killed")
        (directory / "m1.nvm.new").write_bytes(b"likewise")
    return directory


@pytest.mark.parametrize("had_old", [True, False])
@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EROFS, errno.EIO])
def test_one_failing_call_leaves_the_old_content(tmp_path: Path, code: int, had_old: bool) -> None:
    calls = calls_of_a_commit(prepared(tmp_path / "sound", had_old), NEW)
    assert calls.count("fsync") == 2
    for failing, name in enumerate(calls[:-1]):  # the last call tidies up a commit that is done
        directory = prepared(tmp_path / str(failing), had_old)
        files = FailingFiles(code, failing.__eq__)
        ok, reason = commit(directory, NEW, files)
        assert (ok, reason) == (False, f"m1.nvm was not written: {errno.errorcode[code]}"), name
        assert load(directory) == Loaded(OLD if had_old else EMPTY, None), name
        assert "m1.nvm.new" not in names(directory), name
        assert files.calls.count("fsync") <= 2, "a failed fsync was tried again"
        assert commit(directory, NEW) == (True, "")
        assert load(directory) == Loaded(NEW, None)
        assert names(directory) == {"m1.nvm"}


def test_a_failing_tidying_up_does_not_undo_a_commit(tmp_path: Path) -> None:
    last = len(calls_of_a_commit(prepared(tmp_path / "sound", True), NEW)) - 1
    directory = prepared(tmp_path / "failing", True)
    assert commit(directory, NEW, FailingFiles(errno.EIO, last.__eq__)) == (True, "")
    assert load(directory) == Loaded(NEW, None)
    assert commit(directory, OLD) == (True, "")
    assert names(directory) == {"m1.nvm"}


@pytest.mark.parametrize("had_old", [True, False])
@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EROFS, errno.EIO])
def test_a_disk_that_fails_for_good_never_tears_a_file(tmp_path: Path, code: int, had_old: bool) -> None:
    calls = calls_of_a_commit(prepared(tmp_path / "sound", had_old), NEW)
    renamed = calls.index("rename")
    for first, name in enumerate(calls[:-1]):
        directory = prepared(tmp_path / str(first), had_old)
        ok, reason = commit(directory, NEW, FailingFiles(code, first.__le__))
        assert not ok, name
        # Past the rename, the old content cannot come back on a disk that takes no more renames.
        assert ("put back" in reason) == (first > renamed), name
        before = OLD if had_old else EMPTY
        assert load(directory) == Loaded(NEW if first > renamed else before, None), name


def test_the_bytes_of_a_stored_file_are_the_formats(tmp_path: Path) -> None:
    commit(tmp_path, NEW)
    assert (tmp_path / "m1.nvm").read_bytes() == encode(NEW)


def test_a_look_moves_nothing_and_what_was_kept_aside_can_be_put_back(tmp_path: Path) -> None:
    assert commit(tmp_path, OLD) == (True, "")
    before = (tmp_path / "m1.nvm").read_bytes()
    with opened(tmp_path) as store:
        looked = store.look("m1", "sac")
        assert (looked.content, looked.note) == (Content("sac", 0, {}), None)
        assert looked.unfit == "it belongs to a 'mechaduino', not to a 'sac'"
        assert names(tmp_path) == {"m1.nvm"}
        kept = store.keep_aside("m1", looked.unfit)
        assert kept is not None
        assert names(tmp_path) == {"m1.nvm.damaged-1"}
        assert store.keep_aside("m1", looked.unfit) is None  # there is none
        store.put_back(kept)
    assert names(tmp_path) == {"m1.nvm"}
    assert (tmp_path / "m1.nvm").read_bytes() == before
