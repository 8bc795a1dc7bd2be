"""The one table of commands: each by its group in `hil --help`, and where it is. A command's module is
imported when the command is used, or all are listed: each starts quickly."""

from typing import NamedTuple

BENCH, BOARD, MOTION = "Bench", "Board", "Motion"
WIRE, FAULTS, SERVICE = "Wire", "Faults", "Service"
PANELS = (BENCH, BOARD, MOTION, WIRE, FAULTS, SERVICE)
"""Groups of commands in the order of `hil --help`."""


class CommandRow(NamedTuple):
    """Command or group of commands. ``where``: its module in hil.cli, and its name there."""

    name: str
    panel: str
    where: str
    takes_negative: bool = False
    """True if a value that begins with - is no option."""
    is_hidden: bool = False
    takes_command: bool = False
    """True if all that stands behind the first argument is another program's."""


_ROWS = (
    CommandRow("init", BENCH, "config_commands:init"),
    CommandRow("check", BENCH, "config_commands:check"),
    CommandRow("serve", BENCH, "serve_command:serve"),
    CommandRow("list", BENCH, "bench_commands:list_benches"),
    CommandRow("status", BENCH, "bench_commands:status"),
    CommandRow("reload", BENCH, "bench_commands:reload"),
    CommandRow("benches", BENCH, "run_command:benches"),
    CommandRow("replay", BENCH, "bench_commands:replay"),
    CommandRow("monitor", BOARD, "board_access:monitor"),
    CommandRow("with-lines", BOARD, "board_access:with_lines", takes_command=True),
    CommandRow("state", BOARD, "board_access:state"),
    CommandRow("reset", BOARD, "board_access:reset"),
    CommandRow("pin", BOARD, "board_access:pin"),
    CommandRow("set", BOARD, "board_access:set_field", takes_negative=True),
    CommandRow("zero", BOARD, "board_access:zero"),
    CommandRow("profile", BOARD, "profile_commands:profile_app"),
    CommandRow("axis", MOTION, "axis_command:axis", takes_negative=True),
    CommandRow("run", MOTION, "run_command:run"),
    CommandRow("runs", MOTION, "runs_commands:runs_app"),
    CommandRow("step", MOTION, "draw_commands:step", takes_negative=True),
    CommandRow("drive", MOTION, "draw_commands:drive"),
    CommandRow("plot", MOTION, "draw_commands:plot"),
    CommandRow("capture", WIRE, "capture_commands:capture"),
    CommandRow("decode", WIRE, "capture_commands:decode"),
    CommandRow("play", WIRE, "capture_commands:play"),
    CommandRow("mother", WIRE, "mother_commands:mother_app"),
    CommandRow("can", WIRE, "can_commands:can_app"),
    CommandRow("fault", FAULTS, "fault_commands:fault_app"),
    CommandRow("doctor", SERVICE, "bench_commands:doctor"),
    CommandRow("usb", SERVICE, "usb_commands:usb_app"),
    CommandRow("docs", SERVICE, "help_commands:docs"),
    CommandRow("schema", SERVICE, "config_commands:schema"),
    CommandRow("completion", SERVICE, "help_commands:completion"),
    CommandRow("arduino", SERVICE, "arduino_commands:app"),
    CommandRow("reference", SERVICE, "help_commands:reference", is_hidden=True),
    CommandRow("arduino-discovery", SERVICE, "arduino_commands:discovery", is_hidden=True),
    CommandRow("arduino-monitor", SERVICE, "arduino_commands:monitor", is_hidden=True),
)
COMMANDS = {row.name: row for row in _ROWS}


class ValueRow(NamedTuple):
    """Value of a parameter. ``takes``: a file, a folder, or one of ``completion_names.KINDS``; empty: it has
    no names that could be listed. ``placeholder``: its name in help texts; empty: the parameter's."""

    takes: str
    placeholder: str = ""


FILE, FOLDER = "file", "folder"
VALUES = {
    "runtime_dir": ValueRow(FOLDER, "FOLDER"),
    "state_dir": ValueRow(FOLDER, "FOLDER"),
    "sketchbook": ValueRow(FOLDER, "FOLDER"),
    "folders": ValueRow(FOLDER, "FOLDER"),
    "diff": ValueRow(FILE, "OLD"),
    "interval_ms": ValueRow("", "MS"),
    "rate_Hz": ValueRow("", "HZ"),
    "rotate_mb": ValueRow("", "MB"),
    "output": ValueRow(FILE, "FILE"),
    "write": ValueRow(FILE, "FILE"),
    "log": ValueRow(FILE, "FILE"),
    "port_group": ValueRow("", "GROUP"),
    "eds": ValueRow("", "NODE=FILE"),
    "files": ValueRow("", "COUNT"),
    "devices": ValueRow("", "COUNT"),
    "tap": ValueRow("taps", "BUS.TAP"),
    "sources": ValueRow("lines", "SOURCE"),
    "values": ValueRow("verb-values", "VALUE"),
    "parameters": ValueRow("fault-values", "NAME=VALUE"),
    "config": ValueRow(FILE, "FILE"),
    "host": ValueRow("", "HOST"),
    "file": ValueRow(FILE),
    "folder": ValueRow(FOLDER),
    "bench": ValueRow("benches"),
    "device": ValueRow("axes"),
    "reset device": ValueRow("devices"),
    "fault": ValueRow("faults"),
    "number": ValueRow("fault-numbers"),
    "target": ValueRow("targets"),
    "verb": ValueRow("verbs"),
    "monitor device": ValueRow("ports"),
    "mother send line": ValueRow("taps"),
    "mother text line": ValueRow("taps"),
    "mother queue line": ValueRow("taps"),
    "mother release lines": ValueRow("taps"),
    "mother stop lines": ValueRow("taps"),
    "mother scan lines": ValueRow("taps"),
    "mother nodes lines": ValueRow("taps"),
    "mother watch lines": ValueRow("taps"),
    "port": ValueRow(FILE),
    "program": ValueRow(FILE),
    "mother gcode machine": ValueRow(FILE),
    "shell": ValueRow("shells"),
    "topic": ValueRow("pages"),
}
"""Values by the parameter's name, or by the command's and its. A parameter with a completion of its own has
no names here."""
