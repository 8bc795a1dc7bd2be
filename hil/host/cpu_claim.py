"""CPUs of the real-time threads of all benches on this computer.

Each bench binds an abstract Unix socket whose name says CPU, bench and process (unix(7)). Linux lists the
names in ``/proc/net/unix`` (proc_pid_net(5)) for all users, and removes a name with its process, also of one
that is killed.
Benches in other network namespaces, such as containers, are not seen.
"""

import os
import re
import socket
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from itertools import count
from pathlib import Path

from hil.vocab.late_dataclass import dataclass

_UNIX_SOCKETS = Path("/proc/net/unix")
_PREFIX = "hil-cpu/"
_HELD = re.compile(r"@(\S+/)(\d+)/([a-z][a-z0-9_-]*)/(\d+\.\d+)$")
_NUMBERS = count()
CHOOSING_S = 0.5
"""Time to wait for others that choose: one that is stopped meanwhile holds up nobody longer."""
_NAMED = 3
"""Names in a text; of more, the number."""


@dataclass(frozen=True)
class Holder:
    """Bench that holds a CPU. ``process``: its process, and its number in there."""

    cpu: int
    bench: str
    process: str


class CpuClaim:
    """CPU that a bench holds until ``release``.

    ``cpu``: its number; ``pin``: the same, or -1 where the thread is not pinned, as there is only one CPU;
    ``is_configured``: it is the one of ``cpu:``.
    """

    def __init__(self, cpu: int, pin: int, is_configured: bool, bench: str) -> None:
        self.cpu, self.pin, self.is_configured = cpu, pin, is_configured
        self._process = f"{os.getpid()}.{next(_NUMBERS)}"
        self._socket = _bound(f"\0{_PREFIX}{cpu}/{bench}/{self._process}")

    def others(self) -> list[str]:
        """Names of the other benches that hold this CPU now, sorted."""
        return sorted(
            each.bench for each in holders() if each.cpu == self.cpu and each.process != self._process
        )

    def shares(self) -> str:
        """Say with whom the CPU is shared now; empty if with nobody."""
        if not (names := self.others()):
            return ""
        more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
        which = "bench" if len(names) == 1 else "benches"
        return f"shares CPU {self.cpu} with {which} {', '.join(names[:_NAMED])}{more}"

    def release(self) -> None:
        if self._socket:
            self._socket.close()
            self._socket = None


def claim_cpu(configured: int | None, bench: str) -> CpuClaim:
    """Hold the configured CPU, or the one of those allowed that the fewest benches hold."""
    allowed = os.sched_getaffinity(0)
    with _turn():
        cpu = configured if configured is not None else least_held(allowed, holders())
        pinned = configured is not None or len(allowed) > 1
        return CpuClaim(cpu, cpu if pinned else -1, configured is not None, bench)


def least_held(allowed: Iterable[int], held: Iterable[Holder]) -> int:
    """CPU that the fewest hold; of several the last: the first has most of the kernel's own work."""
    held = list(held)
    return max(allowed, key=lambda cpu: (-sum(each.cpu == cpu for each in held), cpu))


def holders() -> list[Holder]:
    """Benches that hold a CPU now."""
    try:
        return list(holders_in(_UNIX_SOCKETS.read_text(errors="replace")))
    except OSError:  # no /proc: nothing is known of others
        return []


def holders_in(listed: str) -> Iterator[Holder]:
    """Benches that hold a CPU, of the text of ``/proc/net/unix``."""
    for line in listed.splitlines():
        if (found := _HELD.search(line)) and found[1] == _PREFIX:
            yield Holder(int(found[2]), found[3], found[4])


def by_cpu(held: Iterable[Holder]) -> Mapping[int, list[str]]:
    """Names of the benches of each CPU."""
    found: dict[int, list[str]] = {}
    for each in sorted(held, key=lambda each: (each.cpu, each.bench)):
        found.setdefault(each.cpu, []).append(each.bench)
    return found


@contextmanager
def _turn() -> Iterator[None]:
    """Let one bench choose at a time: two that start together would both find the same CPU free."""
    give_up_s = time.monotonic() + CHOOSING_S
    while not (turn := _bound(f"\0{_PREFIX}choosing")) and time.monotonic() < give_up_s:
        time.sleep(0.002)
    try:
        yield
    finally:
        if turn:
            turn.close()


def _bound(name: str) -> socket.socket | None:
    """Socket of this name; None if another has it, or this process may have none."""
    try:
        made = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    except OSError:
        return None
    try:
        made.bind(name)
    except OSError:
        made.close()
        return None
    return made
