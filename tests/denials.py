"""Takes rights away from a child process, as Linux does where a bench is not allowed something."""

import ctypes
import errno
import platform
import resource
import struct
from collections.abc import Callable

import pytest

PR_SET_NO_NEW_PRIVS, PR_SET_SECCOMP, SECCOMP_MODE_FILTER = 38, 22, 2  # linux/prctl.h, linux/seccomp.h
SECCOMP_RET_ALLOW, SECCOMP_RET_ERRNO = 0x7FFF0000, 0x00050000
CALLS = {
    "x86_64": {"sched_setscheduler": 144, "mlock": 149, "sched_setaffinity": 203},
    "aarch64": {"sched_setscheduler": 119, "mlock": 228, "sched_setaffinity": 122},
}.get(platform.machine(), {})
"""Numbers of system calls."""
needs_calls = pytest.mark.skipif(not CALLS, reason="the numbers of system calls are not known here")


def limited(number: int, soft: int, hard: int | None = None) -> Callable[[], None]:
    """Function that sets a limit in a child. Skips the test where that needs a right that we do not have."""
    limits = (soft, soft if hard is None else hard)
    before = resource.getrlimit(number)
    if limits[1] > before[1] != resource.RLIM_INFINITY:
        try:
            resource.setrlimit(number, (before[0], limits[1]))
        except (OSError, ValueError):
            pytest.skip(f"the hard limit ({before[1]}) cannot be raised here")
        resource.setrlimit(number, before)
    return lambda: resource.setrlimit(number, limits)


def install_filter(call: int) -> None:
    """Install a seccomp filter under which one system call fails with EPERM. Source: seccomp(2)."""
    program = b"".join(
        struct.pack("=HBBI", *instruction)
        for instruction in (
            (0x20, 0, 0, 0),  # load the number of the call
            (0x15, 0, 1, call),
            (0x06, 0, 0, SECCOMP_RET_ERRNO | errno.EPERM),
            (0x06, 0, 0, SECCOMP_RET_ALLOW),
        )
    )
    instructions = ctypes.create_string_buffer(program, len(program))
    # struct sock_fprog: the number of instructions, padding, their address
    header = ctypes.create_string_buffer(
        struct.pack("@HP", len(program) // 8, ctypes.addressof(instructions))
    )
    libc = ctypes.CDLL(None, use_errno=True)
    libc.prctl.argtypes = [ctypes.c_int, *[ctypes.c_ulong] * 4]
    for call in (
        (PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0),
        (PR_SET_SECCOMP, SECCOMP_MODE_FILTER, ctypes.addressof(header), 0, 0),
    ):
        if libc.prctl(*call):
            raise OSError(ctypes.get_errno(), "prctl")
