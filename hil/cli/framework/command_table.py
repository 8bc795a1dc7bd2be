"""The one table of commands: each by its group in `hil --help`, and where it is. A command's module is
imported when the command is used, or all are listed: each starts quickly."""

from typing import NamedTuple

BENCH, BOARD, MOTION = "Bench", "Board", "Motion"
RECORDINGS, WIRE, FAULTS, SERVICE = "Recordings", "Wire", "Faults", "Service"
PANELS = (BENCH, BOARD, MOTION, RECORDINGS, WIRE, FAULTS, SERVICE)
"""Groups of commands in the order of `hil --help`."""


class CommandRow(NamedTuple):
    """Command, or a group that has ``about``: then ``where`` is what it does without a command; empty: it
    shows its help. A command without ``about`` may have commands below it, too: it takes all words of which
    the first names none of them."""

    name: str
    """As it is typed: one of a group has the group's name before its own."""
    panel: str
    where: str = ""
    """Its module in hil.cli, and its function there."""
    about: str = ""
    """Help of a group; that of a command is its function's docstring."""
    hint: str = ""
    """Words for what is no command of this group; {} is what was typed."""
    takes_negative: bool = False
    """True if a value that begins with - is no option."""
    is_hidden: bool = False
    takes_command: bool = False
    """True if all that stands behind the first argument is another program's."""
    has_place: bool = False
    """True if an argument stands before that program, which options may follow."""
    now: str = ""
    """New words of a command whose name is an old one."""


class OldName(NamedTuple):
    """New words of a command that was renamed, without ``hil``; where they carry out something else too,
    ``where`` is what the old name did, and ``about`` the help of a group that is no more."""

    now: str
    where: str = ""
    about: str = ""


OLD = {
    "halt": OldName("stop"),
    "benches": OldName("list --joined", "lab.benches_command:benches"),
    "state": OldName("status", "boards.board_access:state"),
    "runs": OldName(
        "run list",
        "runs.runs_commands:runs",
        "List runs, show one, slow one down, cancel one.\n\n"
        "Without a command: those that wait, move or have ended.",
    ),
    "runs show": OldName("run show"),
    "runs cancel": OldName("run cancel"),
    "runs pace": OldName("run pace"),
    "mother": OldName("line", about="Be the master of a line: command its nodes, watch them, find them."),
    "mother send": OldName("line send"),
    "mother text": OldName("line text"),
    "mother release": OldName("line release"),
    "mother stop": OldName("line stop"),
    "mother scan": OldName("line scan"),
    "mother nodes": OldName("line nodes"),
    "mother watch": OldName("line watch"),
    "mother queue": OldName("line queue"),
    "mother gcode": OldName("gcode"),
    "play": OldName("line play"),
    "drive": OldName("pulses"),
    "sketch reset": OldName("reset", "sketch.chip_commands:reset"),
}
"""Old names of commands. They work for one more release, hidden, with a word about the new ones."""


_ROWS = (
    CommandRow("init", BENCH, "bench.config_commands:init"),
    CommandRow("virtual", BENCH, "bench.virtual_command:virtual", takes_command=True, has_place=True),
    CommandRow("check", BENCH, "bench.config_commands:check"),
    CommandRow("serve", BENCH, "bench.serve_command:serve"),
    CommandRow("shutdown", BENCH, "bench.shutdown_command:shutdown"),
    CommandRow("list", BENCH, "bench.bench_commands:list_benches"),
    CommandRow("top", BENCH, "bench.top_command:top"),
    CommandRow("status", BENCH, "bench.bench_commands:status"),
    CommandRow("pause", BENCH, "bench.bench_commands:pause"),
    CommandRow("resume", BENCH, "bench.bench_commands:resume"),
    CommandRow("reload", BENCH, "bench.bench_commands:reload"),
    CommandRow(
        "lease",
        BENCH,
        "bench.lease_commands:lease",
        "Take a bench for a while: others may look and not command.\n\n"
        "Without a command: who has it now.\n\n"
        "Example: hil lease",
    ),
    CommandRow("lease take", BENCH, "bench.lease_commands:begin"),
    CommandRow("lease renew", BENCH, "bench.lease_commands:renew"),
    CommandRow("lease give", BENCH, "bench.lease_commands:give"),
    CommandRow("lease break", BENCH, "bench.lease_commands:end_anothers"),
    CommandRow("lease show", BENCH, "bench.lease_commands:show"),
    CommandRow("seeds", BENCH, about="Results of tests that ran at many seeds."),
    CommandRow("seeds merge", BENCH, "bench.seeds_command:merge"),
    CommandRow("monitor", BOARD, "monitor.monitor_command:monitor"),
    CommandRow("type", BOARD, "boards.type_command:type_text"),
    CommandRow("wait", BOARD, "boards.wait_command:wait"),
    CommandRow("parity", BOARD, "parity.parity_command:parity"),
    CommandRow("with-lines", BOARD, "boards.board_access:with_lines", takes_command=True),
    CommandRow("reset", BOARD, "boards.board_access:reset"),
    CommandRow("pin", BOARD, "boards.board_access:pin"),
    CommandRow("set", BOARD, "boards.board_access:set_field", takes_negative=True),
    CommandRow("zero", BOARD, "boards.board_access:zero"),
    CommandRow("profile", BOARD, about="List, make and check kinds of boards."),
    CommandRow("profile list", BOARD, "bench.profile_commands:list_profiles"),
    CommandRow("profile motors", BOARD, "bench.profile_commands:list_motors"),
    CommandRow("profile new", BOARD, "bench.profile_commands:new"),
    CommandRow("profile check", BOARD, "bench.profile_commands:check"),
    CommandRow(
        "sketch",
        BOARD,
        about="Build sketches, and look into processors that run them; `hil monitor` is a serial monitor.",
    ),
    CommandRow("sketch build", BOARD, "sketch.build_command:build"),
    CommandRow("sketch load", BOARD, "sketch.chip_commands:load"),
    CommandRow("sketch pins", BOARD, "sketch.chip_commands:pins"),
    CommandRow("sketch registers", BOARD, "sketch.chip_commands:registers"),
    CommandRow("sketch stack", BOARD, "sketch.chip_commands:stack"),
    CommandRow("sketch cycles", BOARD, "sketch.time_commands:cycles"),
    CommandRow("sketch profile", BOARD, "sketch.time_commands:profile"),
    CommandRow("sketch plot", BOARD, "sketch.plot_command:plot"),
    CommandRow("sketch gdb", BOARD, "sketch.gdb_command:gdb"),
    CommandRow("axis", MOTION, "boards.axis_command:axis", takes_negative=True),
    CommandRow("stop", MOTION, "bench.stop_command:stop"),
    CommandRow("run", MOTION, "runs.run_command:run"),
    CommandRow("run list", MOTION, "runs.runs_commands:list_runs"),
    CommandRow("run show", MOTION, "runs.runs_commands:show"),
    CommandRow("run cancel", MOTION, "runs.runs_commands:cancel"),
    CommandRow("run pace", MOTION, "runs.runs_commands:pace"),
    CommandRow("gcode", MOTION, "gcode.gcode_command:gcode"),
    CommandRow("step", MOTION, "boards.draw_commands:step", takes_negative=True),
    CommandRow("pulses", MOTION, "boards.draw_commands:pulses"),
    CommandRow("plot", MOTION, "boards.draw_commands:plot"),
    CommandRow("recordings", RECORDINGS, "recordings.recordings_command:recordings"),
    CommandRow("export", RECORDINGS, "recordings.export_command:export"),
    CommandRow("replay", RECORDINGS, "recordings.replay_command:replay"),
    CommandRow("find", RECORDINGS, "recordings.find_command:find"),
    CommandRow("diff", RECORDINGS, "recordings.diff_command:diff"),
    CommandRow("bundle", RECORDINGS, "recordings.bundle_command:bundle"),
    CommandRow("capture", WIRE, "captures.capture_commands:capture"),
    CommandRow("decode", WIRE, "captures.capture_commands:decode"),
    CommandRow(
        "line",
        WIRE,
        about="Be the master of a line: command its nodes, watch them, find them; play captures.",
    ),
    CommandRow("line send", WIRE, "lines.line_commands:send"),
    CommandRow("line text", WIRE, "lines.line_commands:text"),
    CommandRow("line release", WIRE, "lines.line_commands:release"),
    CommandRow("line stop", WIRE, "lines.line_commands:stop"),
    CommandRow("line scan", WIRE, "lines.line_commands:scan"),
    CommandRow("line nodes", WIRE, "lines.node_commands:nodes"),
    CommandRow("line watch", WIRE, "lines.node_commands:watch"),
    CommandRow("line queue", WIRE, "lines.queue_command:queue"),
    CommandRow("line play", WIRE, "captures.capture_commands:play"),
    CommandRow(
        "fault",
        FAULTS,
        about="Inject, list and clear faults.",
        hint="a fault of a kind begins by `hil fault inject KIND TARGET`",
    ),
    CommandRow("fault kinds", FAULTS, "boards.fault_commands:kinds"),
    CommandRow("fault inject", FAULTS, "boards.fault_commands:inject"),
    CommandRow("fault clear", FAULTS, "boards.fault_commands:clear"),
    CommandRow("fault list", FAULTS, "boards.fault_commands:list_faults"),
    CommandRow("log", BENCH, "recordings.said_log:log"),
    CommandRow("log commands", SERVICE, "bench.log_commands:commands"),
    CommandRow("doctor", SERVICE, "bench.bench_commands:doctor"),
    CommandRow("usb", SERVICE, about="Ports of kind usb."),
    CommandRow("usb doctor", SERVICE, "bench.doctor_usb:doctor"),
    CommandRow("docs", SERVICE, "documents.docs_command:docs"),
    CommandRow("schema", SERVICE, "bench.config_commands:schema"),
    CommandRow("completion", SERVICE, "documents.help_commands:completion"),
    CommandRow(
        "arduino", SERVICE, "bench.arduino_commands:about", "Show the devices to the Arduino IDE, 2 and 1.8."
    ),
    CommandRow("arduino install", SERVICE, "bench.arduino_commands:install"),
    CommandRow("arduino uninstall", SERVICE, "bench.arduino_commands:uninstall"),
    CommandRow("help", SERVICE, "documents.shown_help:help_of", is_hidden=True),
    CommandRow("version", SERVICE, "documents.shown_help:version", is_hidden=True),
    CommandRow("reference", SERVICE, "documents.help_commands:reference", is_hidden=True),
    CommandRow("arduino-discovery", SERVICE, "bench.arduino_commands:discovery", is_hidden=True),
    CommandRow("arduino-monitor", SERVICE, "bench.arduino_commands:monitor", is_hidden=True),
)
_BY_NAME = {row.name: row for row in _ROWS}


def _old_row(name: str, old: OldName) -> CommandRow:
    new = _BY_NAME[old.now.partition(" --")[0]]
    return new._replace(
        name=name, where=old.where or new.where, about=old.about, hint="", is_hidden=True, now=old.now
    )


_EVERY = (*_ROWS, *(_old_row(name, old) for name, old in OLD.items()))
COMMANDS = {row.name: row for row in _EVERY if " " not in row.name}


def rows_below(name: str) -> list[CommandRow]:
    """Find the commands of a group."""
    return [row for row in _EVERY if row.name.startswith(f"{name} ")]


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
    "libraries": ValueRow(FOLDER, "FOLDER"),
    "sketch build output": ValueRow(FOLDER, "FOLDER"),
    "diff": ValueRow(FILE, "OLD"),
    "interval_ms": ValueRow("", "MS"),
    **dict.fromkeys(("latency_ms", "pause_ms", "response_ms", "turnaround_ms"), ValueRow("", "MS")),
    "steps_per_rev": ValueRow("", "STEPS"),
    "usb_baud": ValueRow("", "BAUD"),
    **dict.fromkeys(("ready_file", "own_log", "ca", "certificate"), ValueRow(FILE, "FILE")),
    "mapped": ValueRow("", "NAME=PORT"),
    "rate_Hz": ValueRow("", "HZ"),
    "rotate_mb": ValueRow("", "MB"),
    "output": ValueRow(FILE, "FILE"),
    "write": ValueRow(FILE, "FILE"),
    "log": ValueRow(FILE, "FILE"),
    "junit": ValueRow(FILE, "FILE"),
    "results": ValueRow(FILE, "FILE"),
    "port_group": ValueRow("", "GROUP"),
    "eds": ValueRow("", "NODE=FILE"),
    "files": ValueRow("", "COUNT"),
    "log commands files": ValueRow(FILE, "FILE"),
    "log commands user": ValueRow("", "NAME"),
    "macros": ValueRow(FILE, "FILE"),
    "passwords": ValueRow(FILE, "FILE"),
    "authority": ValueRow(FILE, "FILE"),
    "prometheus": ValueRow(FILE, "FILE"),
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
    "axes": ValueRow("axes", "AXIS"),
    "reset device": ValueRow("devices"),
    "sketch load device": ValueRow("devices"),
    "sketch pins device": ValueRow("devices"),
    "sketch registers device": ValueRow("devices"),
    "sketch registers names": ValueRow("", "NAME"),
    "sketch stack device": ValueRow("devices"),
    "sketch cycles device": ValueRow("devices"),
    "sketch profile device": ValueRow("devices"),
    "sketch gdb device": ValueRow("devices"),
    "sketch plot device": ValueRow("ports"),
    "elf": ValueRow(FILE, "FILE"),
    "length": ValueRow("", "TIME"),
    "sketch gdb port": ValueRow("", "PORT"),
    "fault": ValueRow("faults"),
    "fault kinds kind": ValueRow("fault-words"),
    "number": ValueRow("fault-numbers"),
    "target": ValueRow("targets"),
    "verb": ValueRow("verbs"),
    "monitor device": ValueRow("ports"),
    "type device": ValueRow("ports"),
    "line send line": ValueRow("taps"),
    "line text line": ValueRow("taps"),
    "line queue line": ValueRow("taps"),
    "line release lines": ValueRow("taps"),
    "line stop lines": ValueRow("taps"),
    "line scan lines": ValueRow("taps"),
    "line nodes lines": ValueRow("taps"),
    "line watch lines": ValueRow("taps"),
    "can send bus": ValueRow("buses"),
    "port": ValueRow(FILE),
    "at": ValueRow(FILE, "PORT"),
    "record": ValueRow(FILE, "FILE"),
    "profile": ValueRow("boards", "BOARD"),
    "parity sessions": ValueRow("sessions", "SESSION"),
    "program": ValueRow(FILE),
    "gcode machine": ValueRow(FILE),
    "shell": ValueRow("shells"),
    "topic": ValueRow("pages"),
    "top fields": ValueRow("fields", "AXIS.FIELD"),
    "run show name": ValueRow("runs"),
    "run cancel name": ValueRow("runs"),
    "run pace name": ValueRow("runs"),
}
"""Values by the parameter's name, or by the command's and its. A parameter with a completion of its own has
no names here."""
