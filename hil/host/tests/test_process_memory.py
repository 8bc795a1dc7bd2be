"""Large blocks that are freed go back to the system, whatever was allocated after them."""

import subprocess
import sys

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
