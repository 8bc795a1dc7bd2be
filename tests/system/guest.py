"""A virtual machine: QEMU without KVM, a kernel of Debian's, a root file system that forgets."""

import re
import socket
import subprocess
import threading
from pathlib import Path
from types import TracebackType

from container import until
from debian import CannotError, run

BOOT_S = 300.0
COMMAND_S = 120.0
STOCK, REAL_TIME = "[0-9]-amd64", "rt-amd64"
"""Ends of the names of Debian's kernels."""


def root_image(tree: Path, image: Path, size: str = "2G") -> Path:
    """An ext4 file system with the tree in it, with the agent started at boot."""
    here = Path(__file__).parent
    for script in ("agent.py", "eeprom_writer.py"):
        (tree / "usr/local/lib" / script).write_text((here / script).read_text())
    (tree / "etc/systemd/system/agent.service").write_text(
        "[Service]\nExecStart=/usr/bin/python3 /usr/local/lib/agent.py\n"
        "[Install]\nWantedBy=multi-user.target\n"
    )
    run("chroot", tree, "systemctl", "enable", "--quiet", "agent.service")
    run("mke2fs", "-q", "-t", "ext4", "-d", tree, image, size)
    return image


class Guest:
    """Virtual machine that is switched on; ``acked`` and ``base`` are what ``eeprom_writer.py`` has told so
    far."""

    def __init__(self, tree: Path, root: Path, kernel: str, *devices: str, memory_MB: int = 1024) -> None:
        """Switch it on, and wait for the agent. ``devices``: more of QEMU's options.

        Raises:
            CannotError: it does not boot here.
        """
        (image,), (initrd,) = (
            sorted(tree.glob(f"boot/{name}-*{kernel}")) for name in ("vmlinuz", "initrd.img")
        )
        folder = root.parent
        agent = folder / "agent.sock"
        agent.unlink(missing_ok=True)
        self.console = folder / "console.log"
        self.acked = 0
        self.base: int | None = None
        command = [
            *("qemu-system-x86_64", "-nodefaults", "-no-user-config", "-display", "none", "-no-reboot"),
            *("-machine", "pc,accel=tcg", "-cpu", "max", "-smp", "2", "-m", str(memory_MB)),
            *("-kernel", str(image), "-initrd", str(initrd)),
            *("-append", "root=/dev/vda rw console=ttyS0 quiet systemd.show_status=0 net.ifnames=0"),
            *("-drive", f"file={root},format=raw,if=virtio,snapshot=on"),
            *devices,
            *("-serial", f"file:{self.console}", "-serial", f"unix:{agent},server=on,wait=off"),
        ]
        with (folder / "qemu.log").open("wb") as said:
            self._qemu = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=said, stderr=subprocess.STDOUT
            )
        self._lines: list[str] = []
        self._finished = threading.Condition()
        self._statuses: list[int] = []
        self._socket = socket.socket(socket.AF_UNIX)
        self._reader: threading.Thread | None = None
        try:
            until(lambda: self._is_connected(agent), "QEMU")
            self._reader = threading.Thread(target=self._read, name="agent", daemon=True)
            self._reader.start()
            self._wait(BOOT_S)
        except (OSError, AssertionError) as error:
            self.kill()
            said = (folder / "qemu.log").read_text()[-300:] + self.console.read_text(errors="replace")[-300:]
            raise CannotError(f"QEMU does not boot here: {error}: {said}") from None

    def _is_connected(self, agent: Path) -> bool:
        if self._qemu.poll() is not None:
            raise AssertionError("it ended")
        try:
            self._socket.connect(str(agent))
        except (FileNotFoundError, ConnectionRefusedError):  # not yet made, or not yet listened at
            return False
        return True

    def _read(self) -> None:
        for raw in self._socket.makefile("rb"):
            line = raw.decode(errors="replace").strip()
            if found := re.fullmatch(r"(ack|base) (-?\d+)", line):
                if found[1] == "ack":
                    self.acked = int(found[2])
                else:
                    self.base = int(found[2])
                continue
            with self._finished:
                if line.startswith("\x04"):
                    self._statuses.append(int(line[1:]))
                    self._finished.notify_all()
                else:
                    self._lines.append(line)

    def _wait(self, timeout_s: float) -> int:
        with self._finished:
            if not self._finished.wait_for(lambda: self._statuses, timeout_s):
                raise AssertionError(f"nothing within {timeout_s:g} s, after {self._lines[-5:]}")
            return self._statuses.pop()

    def begin(self, command: str) -> None:
        """Begin a command of the shell, as root. What it prints is looked at as it comes."""
        self._lines.clear()
        self._socket.sendall(command.encode() + b"\n")

    def run(self, command: str, check: bool = True, timeout_s: float = COMMAND_S) -> str:
        """Run a command in the guest, and return its output."""
        self.begin(command)
        status = self._wait(timeout_s)
        said = "\n".join(self._lines)
        assert not check or status == 0, f"{command}: {status}: {said}"
        return said

    def kill(self) -> None:
        """Pull the plug."""
        self._qemu.kill()
        self._qemu.wait(20)
        if self._reader:
            self._reader.join(20)  # what was told before the end counts
        self._socket.close()

    def __enter__(self) -> "Guest":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.kill()
