"""The one table of commands: each by its group in `hil --help`, and where it is. A command's module is
imported when the command is used, or all are listed: each starts quickly."""

from typing import NamedTuple

BENCH, BOARD, MOTION = "Bench", "Board", "Motion"
WIRE, FAULTS, SERVICE = "Wire", "Faults", "Service"
PANELS = (BENCH, BOARD, MOTION, WIRE, FAULTS, SERVICE)
"""Groups of commands in the order of `hil --help`."""


class Row(NamedTuple):
    """Command or group of commands. ``where``: its module in hil.cli, and its name there."""

    name: str
    panel: str
    where: str
    takes_negative: bool = False
    """True if a value that begins with - is no option."""
    is_hidden: bool = False


_ROWS = (
    Row("init", BENCH, "config_commands:init"),
    Row("check", BENCH, "config_commands:check"),
    Row("serve", BENCH, "serve_command:serve"),
    Row("list", BENCH, "bench_commands:list_benches"),
    Row("status", BENCH, "bench_commands:status"),
    Row("reload", BENCH, "reload_command:reload"),
    Row("benches", BENCH, "run_command:benches"),
    Row("replay", BENCH, "bench_commands:replay"),
    Row("monitor", BOARD, "board_access:monitor"),
    Row("state", BOARD, "board_access:state"),
    Row("reset", BOARD, "board_access:reset"),
    Row("pin", BOARD, "board_access:pin"),
    Row("set", BOARD, "board_access:set_field", takes_negative=True),
    Row("profile", BOARD, "profile_commands:profile_app"),
    Row("axis", MOTION, "axis_command:axis", takes_negative=True),
    Row("run", MOTION, "run_command:run"),
    Row("step", MOTION, "draw_commands:step", takes_negative=True),
    Row("drive", MOTION, "draw_commands:drive"),
    Row("plot", MOTION, "draw_commands:plot"),
    Row("capture", WIRE, "line_commands:capture"),
    Row("decode", WIRE, "line_commands:decode"),
    Row("play", WIRE, "line_commands:play"),
    Row("can", WIRE, "can_commands:can_app"),
    Row("fault", FAULTS, "line_commands:fault_app"),
    Row("doctor", SERVICE, "bench_commands:doctor"),
    Row("docs", SERVICE, "help_commands:docs"),
    Row("schema", SERVICE, "config_commands:schema"),
    Row("completion", SERVICE, "help_commands:completion"),
    Row("arduino", SERVICE, "arduino_commands:app"),
    Row("reference", SERVICE, "help_commands:reference", is_hidden=True),
    Row("arduino-discovery", SERVICE, "arduino_commands:discovery", is_hidden=True),
    Row("arduino-monitor", SERVICE, "arduino_commands:monitor", is_hidden=True),
)
COMMANDS = {row.name: row for row in _ROWS}
OF_BRIDGES = {"modbus": WIRE, "zenoh": SERVICE}
"""Groups of the commands of bridges; those of boards are below ``BOARD``."""
