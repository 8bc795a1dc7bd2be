"""Start of a Python child of a program on simulated time: its ``serial`` opens the bench's ports by the names
that the program has for them. Written as ``sitecustomize`` into a folder on the child's path, without hil."""

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
        from serial import Serial
    except ImportError:
        return
    open_real = Serial.open

    def open_mapped(port: Any) -> None:
        said = port.portstr
        port.portstr = ports.get(said, said)
        try:
            open_real(port)
        finally:
            port.portstr = said

    Serial.open = open_mapped  # type: ignore[assignment,method-assign]


with open(os.path.join(os.path.dirname(__file__), "ports.json")) as _file:
    _map_ports(json.load(_file))
_customize_as_before()
