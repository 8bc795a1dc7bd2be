"""Makers' data sheets that nodes of a configuration name: the files are read here, and nowhere else."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from bridges.can.canopen.node.eds_reader import read_device
from hil.config.document import Document, Finding, KeyPath
from hil.config.explain import shown
from hil.config.port_model import is_path
from hil.vocab.problem import ConfigError, Problem
from hil.wire.outside_text import text_of

Raw = Mapping[str, Any]


class _Reading:
    def __init__(self, document: Document, read_bytes: Callable[[Path], bytes] | None) -> None:
        self._folder, self._read_bytes = Path(document.file).parent, read_bytes
        self.findings: list[Finding] = []
        self.problems: list[Problem] = []

    def bus(self, path: KeyPath, bus: Any) -> Any:
        nodes = bus.get("nodes") if isinstance(bus, dict) else None
        if not isinstance(nodes, dict):
            return bus
        return {**bus, "nodes": {axis: self._node((*path, axis), node) for axis, node in nodes.items()}}

    def _node(self, path: KeyPath, node: Any) -> Any:
        given = node.get("eds") if isinstance(node, dict) else None
        if given is None:
            return node
        here = (*path, "eds")
        if isinstance(given, dict):
            text, name = given.get("text"), given.get("name")
            if not isinstance(text, str) or not isinstance(name, str):
                return node
            self._check(here, text, name, name)
            return node
        if not is_path(given):
            remedy = "write the path, as in maker.eds"
            self.findings.append(Finding(here, f"a file's path is wanted here, not {shown(given)}", remedy))
            return {**node, "eds": None}
        return {**node, "eds": {"name": given, "text": self._file(here, given)}}

    def _file(self, path: KeyPath, given: str) -> str:
        assert self._read_bytes is not None, "this catalogue reads no files"
        file = self._folder / given
        try:
            # Without what no log can have: files of some tools end in it.
            text = text_of(self._read_bytes(file)).replace("\0", "")
        except OSError as error:
            remedy = "write where it is, from this file on"
            self.findings.append(Finding(path, f"{file} cannot be read: {error.strerror}", remedy))
            return ""
        self._check(path, text, str(file), given)
        return text

    def _check(self, path: KeyPath, text: str, file: str, given: str) -> None:
        try:
            read_device(text, file)
        except ConfigError as error:
            self.problems += error.problems
            message = f"the data sheet {given} cannot be used"
            self.findings.append(Finding(path, message, "mend what is said of it below"))


def read_files(
    wires: Raw, document: Document, read_bytes: Callable[[Path], bytes] | None
) -> tuple[Raw, list[Finding], list[Problem]]:
    """Read the files of all buses: the buses with their texts, findings, and problems of the files."""
    reading = _Reading(document, read_bytes)
    done = {name: reading.bus(("can", name, "nodes"), bus) for name, bus in wires.items()}
    return done, reading.findings, reading.problems
