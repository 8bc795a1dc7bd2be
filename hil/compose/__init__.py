"""Builds a bench from a configuration, for the daemon and the test kit alike, replays a log, and puts
captures into words.

Finds profiles, ports and bridges by the name that a configuration gives, and imports them by that name
alone.

May import: hil.config, hil.core, hil.discovery, hil.firmware, hil.host, hil.instruments, hil.sim, hil.sketch,
hil.vocab, hil.wire, the standard library, pydantic.

Tests may import too: bridges.modbus.protocol, hil.runs, hil.testing.
"""

from typing import TYPE_CHECKING, Any

from hil.compose.find import find_catalogue
from hil.host.regular_file import read_text

if TYPE_CHECKING:
    from hil.compose.build import bench_runtime, start_memories

__all__ = ["bench_runtime", "find_catalogue", "read_text", "start_memories"]


def __getattr__(name: str) -> Any:
    """Import what builds benches when it is asked for: `hil check` builds none."""
    if name in ("bench_runtime", "start_memories"):
        from hil.compose import build

        return getattr(build, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
