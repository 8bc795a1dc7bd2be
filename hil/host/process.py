"""Resources of this process: memory, CPU time, descriptors. Sources: proc(5), getrusage(2), mallopt(3)."""

import ctypes
import errno
import os
import re
import resource
from typing import NamedTuple

WANTED_FILES = 65_536
"""Wanted number of file descriptors: a pty takes three, so the usual limit of 1024 ends at 300."""
LARGE_BYTES = 1 << 20
"""Minimum size of a block that is mapped by itself: rings of watches and long answers. What sockets read
into, 256 KB, is not: it would be mapped and unmapped with each read."""
_OPEN_FDS = "/proc/self/fd"
_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD = -1, -3  # malloc.h


class Process(NamedTuple):
    resident_bytes: int
    locked_bytes: int
    cpu_s: float
    major_faults: int
    open_fds: int
    max_fds: int


def read_process() -> Process:
    """Read the process's resources, in some tens of us. Where no file descriptor is left to read them, all
    are in use, and the memory is 0."""
    usage = resource.getrusage(resource.RUSAGE_SELF)
    max_fds = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    try:
        with open("/proc/self/status") as file:
            status = dict(re.findall(r"^(VmRSS|VmLck):\s*(\d+) kB", file.read(), re.M))
        # The folder's size is their number, and 0 before Linux 6.2. A list of 3000, of 1000 boards, takes
        # 3 ms; one of them is its own.
        open_fds = os.stat(_OPEN_FDS).st_size or len(os.listdir(_OPEN_FDS)) - 1
    except OSError as error:
        status, open_fds = {}, max_fds if error.errno == errno.EMFILE else 0
    return Process(
        resident_bytes=int(status.get("VmRSS", 0)) * 1024,
        locked_bytes=int(status.get("VmLck", 0)) * 1024,
        cpu_s=usage.ru_utime + usage.ru_stime,
        major_faults=usage.ru_majflt,
        open_fds=open_fds,
        max_fds=max_fds,
    )


def allow_many_files() -> None:
    """Raise the limit in force as far as the process itself may, to WANTED_FILES at most."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    most = WANTED_FILES if hard == resource.RLIM_INFINITY else min(hard, WANTED_FILES)
    if soft != resource.RLIM_INFINITY and soft < most:
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))


def give_large_blocks_back() -> None:
    """Let large blocks go back to the system when they are freed. By itself glibc puts them onto its
    heap, once one was freed; small ones above them then keep their memory."""
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:  # other C libraries have none
        mallopt(_M_MMAP_THRESHOLD, LARGE_BYTES)
        mallopt(_M_TRIM_THRESHOLD, LARGE_BYTES)


POLITE = 10
"""Priority, as of `nice`, of work that nobody waits for in real time."""


def be_polite() -> None:
    """Leave the processor to others from now on, for good."""
    if os.getpriority(os.PRIO_PROCESS, 0) < POLITE:
        os.setpriority(os.PRIO_PROCESS, 0, POLITE)
