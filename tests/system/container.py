"""A booted container: systemd-nspawn, without a machine manager on the host."""

import os
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import TypeVar

from debian import CannotError

T = TypeVar("T")
BOOT_S = 60.0


def until(condition: Callable[[], T], what: str, timeout_s: float = 20.0, every_s: float = 0.01) -> T:
    """The first true value of ``condition``."""
    deadline = time.monotonic() + timeout_s
    while not (value := condition()):
        assert time.monotonic() < deadline, f"waited {timeout_s:g} s for {what}"
        time.sleep(every_s)
    return value


class Container:
    """Container with Debian, up and running; it has no network but its own loopback."""

    def __init__(self, tree: Path) -> None:
        command = ["systemd-nspawn", "--quiet", "--boot", "--register=no", "--keep-unit", "--private-network"]
        # So that what limits refuse is refused by them alone, and what they allow is allowed.
        command += [
            "--capability=CAP_IPC_LOCK,CAP_SYS_NICE,CAP_SYS_RESOURCE",
            "--system-call-filter=@memlock",
        ]
        self._log = (tree.parent / "console").open("w+b")
        self._nspawn = subprocess.Popen(
            [*command, "--console=pipe", f"--directory={tree}"],
            stdin=subprocess.DEVNULL,
            stdout=self._log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        self.leader = 0
        try:
            until(self._is_up, "the boot", BOOT_S, 0.2)
        except (AssertionError, CannotError) as error:
            self.close()
            raise CannotError(f"no boot under systemd-nspawn: {error}: {self._said()}") from None

    def _said(self) -> str:
        self._log.seek(0)
        return self._log.read().decode(errors="replace")[-400:]

    def _is_up(self) -> bool:
        if self._nspawn.poll() is not None:
            raise CannotError("it ended")
        task = Path(f"/proc/{self._nspawn.pid}/task/{self._nspawn.pid}/children")
        if not (children := task.read_text().split()):
            return False
        self.leader = int(children[0])
        return self.run("systemctl", "is-system-running", check=False).strip() in ("running", "degraded")

    def path(self, path: str) -> Path:
        """A path of the container, for the host."""
        return Path(f"/proc/{self.leader}/root{path}")

    def command(self, *words: str, user: str = "root") -> list[str]:
        """The command line that runs it in the container."""
        enter = ["nsenter", "-t", str(self.leader), "-m", "-u", "-i", "-n", "-p", "-C"]
        other = [] if user == "root" else ["setpriv", "--reuid", user, "--regid", user, "--init-groups"]
        return [
            *enter,
            "env",
            "-i",
            "PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin",
            "LC_ALL=C.UTF-8",
            *other,
            *words,
        ]

    def run(self, *words: str, user: str = "root", check: bool = True, timeout_s: float = 60) -> str:
        """Run a command in the container, and return its output."""
        done = subprocess.run(
            self.command(*words, user=user),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=timeout_s,
        )
        said = done.stdout.decode(errors="replace")
        assert not check or done.returncode == 0, f"{words}: {done.returncode}: {said}"
        return said

    def close(self) -> None:
        """Shut down."""
        for number in (signal.SIGTERM, signal.SIGTERM, signal.SIGKILL):
            if self._nspawn.poll() is None:
                os.kill(self._nspawn.pid, number)
                try:
                    self._nspawn.wait(20)
                except subprocess.TimeoutExpired:
                    continue
        self._log.close()

    def __enter__(self) -> "Container":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
