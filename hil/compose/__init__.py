"""Builds a bench from a configuration, for the daemon and for the test kit alike.

Finds profiles, ports and bridges by their folder's name, which a configuration gives, and imports them by
that name alone.

May import: hil.config, hil.core, hil.firmware, hil.host, hil.sim, hil.vocab, hil.wire, the standard library,
pydantic.
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
