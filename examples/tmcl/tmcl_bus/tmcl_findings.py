"""Checks of TMCL modules on segments: whose they are, and their addresses."""

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from hil.config.catalogue import ProfileInfo
from hil.config.document import Finding, KeyPath
from hil.config.node_findings import NodeRules, node_findings
from tmcl_bus.frames import HOST
from tmcl_bus.tmcl_model import TMCL


def tmcl_findings(
    segments: Mapping[str, Any], devices: Mapping[str, ProfileInfo], real: Collection[str]
) -> Iterator[Finding]:
    """Findings about modules. ``devices``: those whose profile is known; ``real``: real boards."""
    return node_findings(segments, devices, real, NodeRules(TMCL, "modules", "module", _number_findings))


def _number_findings(
    path: KeyPath, number: int, other: str | None, tmcl: Mapping[str, Any]
) -> Iterator[Finding]:
    if other:
        yield Finding(path, f"module {number} is {other} already", "give each an address of its own")
    if number == tmcl.get("host", HOST):
        message = f"{number} is the host's address: the module would take replies of others for requests"
        yield Finding(path, message, 'give it another one, or tmcl another "host"')
