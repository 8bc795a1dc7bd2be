"""Failures of every system call that a store makes, one by one and from one on: nothing is torn, no failure
is called a success. ``failing_calls.c`` stands between Python and libc, so that no call is left out."""

import ctypes
import errno
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from hil.firmware.nvm import Content
from hil.live.store import Loaded, NvmStore, StoreError

CODES = (errno.ENOSPC, errno.EROFS, errno.EIO, errno.EDQUOT, errno.EMFILE, errno.ENOMEM)
OLD = Content("mechaduino", 1, {"table": b"old" * 1000})
NEW = Content("mechaduino", 2, {"table": b"new" * 1000})
EMPTY = Content("mechaduino", 0, {})
FOR_EVER = 1_000_000


@pytest.mark.long
@pytest.mark.skipif(not shutil.which("cc"), reason="no C compiler")
def test_whatever_call_fails(tmp_path: Path) -> None:
    shim = tmp_path / "failing_calls.so"
    source = Path(__file__).with_name("failing_calls.c")
    flags = ["-shared", "-fPIC", "-O1", "-Wall", "-Wextra", "-Werror"]
    subprocess.run(["cc", *flags, "-o", shim, source, "-ldl"], check=True)
    done = subprocess.run(
        [sys.executable, __file__, shim, tmp_path],
        env=os.environ | {"LD_PRELOAD": str(shim)},
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    commits, loads = (int(word) for word in done.stdout.split())
    # A commit makes about ten calls, a load about five; each fails alone and with all after it.
    assert commits >= 2 * 2 * 10 * len(CODES)
    assert loads >= 4 * len(CODES)


class Failing:
    """Lets calls on files below a directory fail."""

    def __init__(self, shim: str) -> None:
        self._shim = ctypes.CDLL(shim)
        self._shim.seen_calls.restype = ctypes.c_long

    def begin(self, directory: Path, first: int, last: int, code: int) -> None:
        self._shim.fail_calls(bytes(directory), ctypes.c_long(first), ctypes.c_long(last), code)

    def end(self) -> int:
        """Let calls succeed again, and return how many there were."""
        seen = int(self._shim.seen_calls())
        self._shim.fail_calls(b"", ctypes.c_long(0), ctypes.c_long(0), 0)
        return seen


def commit(store: NvmStore, content: Content) -> tuple[bool, str]:
    answers: list[tuple[bool, str]] = []
    store.commit("m1", content, lambda ok, reason: answers.append((ok, reason)))
    store.close()
    (answer,) = answers
    return answer


def stored(directory: Path) -> Content:
    store = NvmStore(directory)
    loaded = store.look("m1", "mechaduino")
    store.close()
    assert loaded.note is loaded.unfit is None, loaded
    return loaded.content


def check_commit(failing: Failing, folder: Path, had_old: bool, first: int, last: int, code: int) -> bool:
    """Check one commit of which some calls fail; return whether a call failed at all."""
    folder.mkdir()
    if had_old:
        assert commit(NvmStore(folder), OLD) == (True, "")
    store = NvmStore(folder)
    failing.begin(folder, first, last, code)
    ok, reason = commit(store, NEW)
    calls = failing.end()
    before = OLD if had_old else EMPTY
    now = stored(folder)
    where = f"calls {first} to {last} with {errno.errorcode[code]}: {ok} {reason!r}, {now}"
    if ok:
        assert now == NEW, where
    else:
        assert reason.startswith(f"m1.nvm was not written: {os.strerror(code)}"), where
        # What could not be taken back is there, and was not called a success.
        assert now == before or (now == NEW and "put back" in reason), where
    assert commit(NvmStore(folder), NEW) == (True, ""), where
    assert stored(folder) == NEW, where
    assert [path.name for path in folder.iterdir()] == ["m1.nvm"], where
    shutil.rmtree(folder)
    return calls > first


def check_load(failing: Failing, folder: Path, first: int, last: int, code: int) -> bool:
    """Check a load of which some calls fail: the content, or a refusal; the file stays as it is."""
    folder.mkdir()
    assert commit(NvmStore(folder), OLD) == (True, "")
    whole = (folder / "m1.nvm").read_bytes()
    store = NvmStore(folder)
    failing.begin(folder, first, last, code)
    try:
        assert store.look("m1", "mechaduino") == Loaded(OLD, None)
    except StoreError as error:
        assert "m1.nvm cannot be read" in str(error)  # noqa: PT017 - either this, or the content
    calls = failing.end()
    store.close()
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == {"m1.nvm": whole}
    shutil.rmtree(folder)
    return calls > first


def main(shim: str, base: str) -> None:
    failing, folder = Failing(shim), Path(base) / "store"
    commits = loads = 0
    for code in CODES:
        for length in (0, FOR_EVER):
            for had_old in (True, False):
                first = 0
                while check_commit(failing, folder, had_old, first, first + length, code):
                    first += 1
                commits += first
            first = 0
            while check_load(failing, folder, first, first + length, code):
                first += 1
            loads += first
    print(commits, loads)


if __name__ == "__main__":
    main(*sys.argv[1:])
