"""Builds a bench from a configuration, for the daemon and for the test kit alike.

Finds profiles and ports by their folder's name. May import every room of the core but ``hil.testing``
and ``hil.daemon``; imports the sibling packages only by a name that a configuration gives.
"""

from hil.compose.build import (
    LOOKUP_SECTION,
    TableFileError,
    axis_seed,
    bench_runtime,
    empty_bench,
    join_devices,
    joined_devices,
    load_firmware,
    make_device,
    start_sections,
)
from hil.compose.find import (
    bridge_reference,
    find_catalogue,
    load_dialogues,
    load_terminal_axis,
    load_verbs,
    make_bridge,
    make_port,
    serial_port_config,
)
from hil.host.regular_file import NotRegularError, read_regular, read_text

__all__ = [
    "LOOKUP_SECTION",
    "NotRegularError",
    "TableFileError",
    "axis_seed",
    "bench_runtime",
    "bridge_reference",
    "empty_bench",
    "find_catalogue",
    "join_devices",
    "joined_devices",
    "load_dialogues",
    "load_firmware",
    "load_terminal_axis",
    "load_verbs",
    "make_bridge",
    "make_device",
    "make_port",
    "read_regular",
    "read_text",
    "serial_port_config",
    "start_sections",
]
