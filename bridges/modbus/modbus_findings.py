"""Checks of Modbus nodes on segments: whose they are, and their numbers."""

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from bridges.modbus.modbus_model import MODBUS
from hil.config.catalogue import ProfileInfo
from hil.config.document import Finding, KeyPath
from hil.config.node_findings import NodeRules, node_findings


def modbus_findings(
    segments: Mapping[str, Any], devices: Mapping[str, ProfileInfo], real: Collection[str]
) -> Iterator[Finding]:
    """Findings about nodes. ``devices``: those whose profile is known; ``real``: real boards."""
    return node_findings(segments, devices, real, NodeRules(MODBUS, "units", "node", _number_findings))


def _number_findings(
    path: KeyPath, unit: int, other: str | None, modbus: Mapping[str, Any]
) -> Iterator[Finding]:
    if other and modbus.get("duplicate_units") is not True:
        remedy = 'give each a number of its own, or add "duplicate_units: true" to modbus'
        yield Finding(path, f"unit {unit} is {other} already", remedy)
