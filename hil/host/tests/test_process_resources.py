"""Resources of a process: large blocks that are freed go back to the system, whatever was allocated after
them; open file descriptors are counted."""

import os
import subprocess
import sys
from types import SimpleNamespace

import pytest

from hil.host.process import read_process

MB = 1 << 20
SOURCE = """
import sys
from hil.host.process import give_large_blocks_back, read_process

if "back" in sys.argv:
    give_large_blocks_back()
bytes(4 << 20)  # freed: glibc's own threshold rises
before = read_process().resident_bytes
blocks, small = [], []
for _ in range(16):
    blocks.append(b"x" * (3 << 20))
    small.append(bytes(4096 + len(small)))
del blocks
print(read_process().resident_bytes - before)
"""


def _grown_bytes(*arguments: str) -> int:
    command = [sys.executable, "-c", SOURCE, *arguments]
    return int(subprocess.run(command, capture_output=True, check=True, text=True).stdout)


def test_large_blocks_that_are_freed_go_back() -> None:
    assert _grown_bytes("back") < 2 * MB


@pytest.mark.parametrize("is_old", [False, True])
def test_open_files_are_counted(monkeypatch: pytest.MonkeyPatch, is_old: bool) -> None:
    if is_old:  # a kernel that tells no size
        old = SimpleNamespace(stat=lambda _: SimpleNamespace(st_size=0), listdir=os.listdir)
        monkeypatch.setattr("hil.host.process.os", old)
    before = read_process().open_fds
    ends = os.pipe()
    assert read_process().open_fds == before + len(ends)
    for end in ends:
        os.close(end)
    assert read_process().open_fds == before == len(os.listdir("/proc/self/fd")) - 1
