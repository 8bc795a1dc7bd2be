"""Start of a Python child of a program on simulated time: its ``serial`` opens the bench's ports by the names
that the program has for them. Written as ``sitecustomize`` into a folder on the child's path, without hil."""

import fcntl
import importlib.machinery
import importlib.util
import json
import os
import sys
from typing import Any


def _customize_as_before() -> None:
    """Run the ``sitecustomize`` that the child would have without this one."""
    here = os.path.dirname(__file__)
    path = [each for each in sys.path if each != here]
    spec = importlib.machinery.PathFinder.find_spec("sitecustomize", path)
    if spec and spec.loader:
        spec.loader.exec_module(importlib.util.module_from_spec(spec))


def _map_ports(ports: dict[str, str]) -> None:
    try:
        from serial import Serial, serialposix
    except ImportError:
        return
    open_real, close_real = Serial.open, Serial.close
    locks: dict[int, int] = {}

    def open_mapped(port: Any) -> None:
        said = port.portstr
        port.portstr = ports.get(said, said)
        try:
            open_real(port)
        finally:
            port.portstr = said

    def close_and_unlock(port: Any) -> None:
        fd = port.fd
        close_real(port)
        if fd in locks:
            os.close(locks.pop(fd))

    class Locking:
        """``fcntl`` of pyserial: locks are those of files, since the parent has no end of this pty."""

        def __getattr__(self, name: str) -> Any:
            return getattr(fcntl, name)

        def flock(self, fd: int, operation: int) -> None:
            files = [path for path in ports.values() if os.path.samefile(path, os.ttyname(fd))]
            if files and fd not in locks:
                locks[fd] = os.open(f"{files[0]}.lock", os.O_RDWR)
            fcntl.flock(locks.get(fd, fd), operation)

    Serial.open = open_mapped  # type: ignore[assignment,method-assign]
    Serial.close = close_and_unlock  # type: ignore[assignment,method-assign]
    serialposix.fcntl = Locking()  # type: ignore[attr-defined]


with open(os.path.join(os.path.dirname(__file__), "ports.json")) as _file:
    _map_ports(json.load(_file))
_customize_as_before()
