"""The one table of operations on a bench. ``desk.py`` answers it. Doors, permissions, the reference and the
control socket's verbs are written from it.

Verbs of a kind of board stand in the table of its profile and are asked for by ``do``.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

from hil.core.processor_debug import MOST_FUNCTIONS
from hil.net.answers import FORMS
from hil.sim.inputs import MAX_BURSTS
from hil.sketch.chip import FLASH
from hil.vocab.desk_protocol import Source
from hil.vocab.lease import DOORS, LONGEST_S, WHY_CHARACTERS
from hil.vocab.operation import Operation, Target
from hil.vocab.parameters import Form, Parameter
from hil.vocab.verbs import COMMON, HOW_TO_STOP, Role
from hil.wire.step_dir import MAX_ROWS

NAME_CHARACTERS = 256
LIST_NAMES = 1024
MOST_FRAMES, FRAME_CHARACTERS = 256, 25
"""Maximum of frames that are sent by one request, and of characters of one, extended with 8 bytes."""
WATCH_IDLE_S = 10
"""Time without a request for samples after which a watch has ended."""
LONGEST_WAIT_S = 3600.0
LONGEST_RUN_S = 1e9
EVERY_BOARDS = {verb.name: verb for verb in COMMON}
"""Verbs that all boards have, which are operations themselves."""
TYPED_BYTES = round(EVERY_BOARDS["type"].parameters[0].maximum)
"""Maximum that is typed at once, as text or as hexadecimal digits."""


class Asked(NamedTuple):
    """Asker and target of a request."""

    source: Source
    target: str


Answerer = Callable[..., Any]
"""Answerer of an operation: called with an ``Asked`` and the parameters; answers, or raises VerbRefused."""


def _is_hex(value: Any) -> bool:
    if not isinstance(value, str) or len(value) > 2 * TYPED_BYTES:
        return False
    try:
        bytes.fromhex(value)
    except ValueError:
        return False
    return True


def _is_whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _are_names(value: Any) -> bool:
    return (
        isinstance(value, list)
        and len(value) <= LIST_NAMES
        and all(isinstance(name, str) and len(name) <= NAME_CHARACTERS for name in value)
    )


def _are_addresses(value: Any) -> bool:
    return isinstance(value, list) and len(value) <= MOST_FUNCTIONS and all(map(_is_address, value))


def _is_address(value: Any) -> bool:
    return _is_whole(value) and 0 <= value < FLASH.size


def _is_number_or_all(value: Any) -> bool:
    return value == "all" or (isinstance(value, int | float) and not isinstance(value, bool))


def _rows(most: int, columns: str) -> Form:
    """Form of rows. It checks their number only; the part that takes them reads them, off the event loop."""
    return Form(
        f"at most {most:,} rows of {columns}", lambda value: isinstance(value, list) and len(value) <= most
    )


TEXT = Form("a text", lambda value: isinstance(value, str))  # its reader has a limit
WHOLE = Form("a whole number", _is_whole)
NAMES = Form("a list of texts", _are_names)
HEX = Form(f"hexadecimal digits of at most {TYPED_BYTES} bytes", _is_hex)
ADDRESSES = Form(f"a list of at most {MOST_FUNCTIONS} whole numbers", _are_addresses)
FLAG = Form("true or false", lambda value: isinstance(value, bool))
OBJECT = Form("an object", lambda value: isinstance(value, dict))
VALUE = Form("a number", lambda value: True)  # the field checks its limits and its type
WHICH = Form('a number of `faults`, or "all"', _is_number_or_all)
EDGES = _rows(MAX_ROWS, "at_ns, pin, level, steps, duration_ns; [] ends")
BURSTS = _rows(MAX_BURSTS, "nanoseconds from now, hexadecimal digits")


def _are_frames(value: Any) -> bool:
    return (
        isinstance(value, list)
        and len(value) <= MOST_FRAMES
        and all(isinstance(each, str) and len(each) <= FRAME_CHARACTERS for each in value)
    )


FRAMES = Form(f"a list of at most {MOST_FRAMES} frames", _are_frames)


def _name(name: str, about: str, **more: Any) -> Parameter:
    return Parameter(name, about, maximum=NAME_CHARACTERS, is_text=True, **more)


def _number(name: str, about: str) -> Parameter:
    return Parameter(name, about, form=WHOLE)


def _second(name: str, about: str) -> Parameter:
    return Parameter(name, about, "s", 0, LONGEST_RUN_S)


_LANE = Parameter(
    "lane", "asker's name for requests of which the newest alone counts; empty: each counts", "", 0,
    NAME_CHARACTERS, default="", is_text=True,
)  # fmt: skip


_LEASED_S = Parameter("for_s", "time from now to its end", "s", 1, LONGEST_S, is_optional=True)
_LEASED_UNTIL = Parameter(
    "until_wall_ns", "its end instead, wall time since 1970, at most a week from now", form=WHOLE,
    is_optional=True,
)  # fmt: skip


def _asked(
    name: str, target: Target, role: Role, about: str, *parameters: Parameter, takes_time: bool = False
) -> Operation:
    return Operation(name, target, about, parameters, role, takes_time, FORMS.get(name))


def _common(name: str, target: Target, *, takes_time: bool = False) -> Operation:
    """Operation of a verb that every board has: by ``do`` it is the same."""
    verb = EVERY_BOARDS[name]
    return _asked(name, target, verb.role, verb.about, *verb.parameters, takes_time=takes_time)


BENCH, DEVICE, TWIN, UART = Target.BENCH, Target.DEVICE, Target.TWIN, Target.UART
MEMBER = Target.MEMBER
PLACE, TAP, RUN = Target.PLACE, Target.TAP, Target.RUN
BUS, CHANNEL = Target.BUS, Target.CHANNEL
VIEWER, OPERATOR, ADMIN = Role.VIEWER, Role.OPERATOR, Role.ADMIN
_ROWS = (
    # What is there, and how it does.
    _asked("list", BENCH, VIEWER, "the bench's devices, with the addresses of their ports",
           takes_time=True),
    _asked("status", BENCH, VIEWER,
           "health, ticks, missed wakes, histograms, and for each device counters and a snapshot",
           takes_time=True),
    _asked("health", BENCH, VIEWER, "whether the bench is well, and what is wrong"),
    _asked("metrics", BENCH, VIEWER, "all metrics, each read when its turn comes"),
    _asked("segments", BENCH, VIEWER, "each segment's stations, taps and counters"),
    _asked("buses", BENCH, VIEWER, "each CAN bus's nodes, taps and counters"),
    _asked("about", BENCH, VIEWER,
           "what the bench is and how it does: versions, host, labels, devices, health, runs, who commands"),
    _asked("benches", BENCH, VIEWER, "the other benches that are joined, and their clocks", takes_time=True),
    _asked("verbs", MEMBER, VIEWER, "verbs of a device, with their parameters"),
    # A board.
    _asked("state", TWIN, VIEWER, "all fields of an axis, now"),
    _asked("packed", TWIN, VIEWER, "all fields of an axis in the binary layout, now"),
    _asked("look", MEMBER, VIEWER,
           "the same, with what it means as motion, and whether the board has stopped"),
    _asked("read_text", MEMBER, VIEWER,
           "read a text of a board as data: what its terminal says, or a file of its own; answers what is"
           " wrong, as a text, if it is none",
           _name("reader", "the name of the board's reader"), Parameter("text", "the text", form=TEXT),
           _name("file", "where it came from, for its problems", default=""),
           takes_time=True),
    _asked("registers", MEMBER, VIEWER, "the register map that doors of Modbus have of a device"),
    _asked("eds", MEMBER, VIEWER, "the electronic data sheet of an axis's CANopen node"),
    _common("reset", DEVICE, takes_time=True),
    _common("pin", TWIN),
    _asked("set", TWIN, OPERATOR,
           "set a load, an encoder register or a gain (see Fields of an axis)",
           _name("field", "its name"), Parameter("value", "in the field's unit", form=VALUE)),
    _common("zero", TWIN),
    _common("type", UART),
    _asked("send", UART, OPERATOR,
           "type bytes at a serial interface (s1.network: the second one), as a client does",
           Parameter("data", "what is typed", form=HEX)),
    _asked("do", MEMBER, VIEWER, "carry out a verb of the device (see Verbs); the verb's role counts",
           _name("name", "the verb's name"), Parameter("parameters", "the verb's own", form=OBJECT),
           takes_time=True),
    _asked("wait", TWIN, VIEWER,
           "wait until a verb's motion has ended; answers whether something else ended it",
           _number("effective_at_ns", "when the verb took effect"),
           Parameter("ends_after_ns", "how long it takes, as the verb said", "ns", 0, 1e18, is_optional=True),
           Parameter("set_point", "where it goes, as the verb said", "", -1e300, 1e300, is_optional=True),
           Parameter("at_most_s", "of simulated time", "s", 0, LONGEST_WAIT_S, LONGEST_WAIT_S),
           takes_time=True),
    _asked("drive", TWIN, OPERATOR, "play a pulse train on the step/dir inputs",
           Parameter("train", "what is played", form=EDGES), takes_time=True),
    _asked("play", TAP, OPERATOR, "send bursts on a segment, or to the adapter on a CAN bus",
           Parameter("bursts", "what is sent", form=BURSTS), takes_time=True),
    # The processor of a board, which runs a user's program.
    _asked("processor", DEVICE, VIEWER,
           "what is in a device's processor: its program, registers, SRAM, pins, and who is wired to those"),
    _asked("load_program", DEVICE, OPERATOR,
           "load a program into a device's processor and memory; it starts as after a power-up",
           Parameter("program", "an Intel HEX or ELF file, in base64", form=TEXT),
           _name("file", "where it came from", default="program.hex"),
           takes_time=True),
    _asked("count", DEVICE, OPERATOR,
           "count from now on where a processor's time goes; meanwhile it takes the computer more time",
           Parameter("starts", "byte addresses of functions, ascending; [] for none", form=ADDRESSES),
           Parameter("lap_at", "byte address whose times are kept; -1 for none", "", -1, 32767, -1.0,
                     is_whole=True)),
    _asked("counted", DEVICE, VIEWER,
           "cycles since `count`, those in each function with its calls, and cycles from one time at lap_at"
           " to the next, the latest 1,024"),
    _asked("debug", DEVICE, OPERATOR,
           "the connection carries GDB's remote protocol from now on; the processor stands until GDB lets it"
           " go"),
    # A CAN bus.
    _asked("attach", BUS, OPERATOR,
           "put a node without a device on a CAN bus; answers its address, and how many frames it takes",
           _name("node", "its name behind the bus's, as in udp: can0.udp")),
    _asked("detach", CHANNEL, OPERATOR, "take such a node off its bus"),
    _asked("transmit", CHANNEL, OPERATOR,
           "send frames from such a node; answers how many were refused, and how many it takes now",
           Parameter("frames", "each as 123#0011", form=FRAMES)),
    # Looking on.
    _asked("watch", TWIN, VIEWER,
           f"sample fields of an axis from now on; ends {WATCH_IDLE_S} s after the last `samples`",
           Parameter("signals", "names of fields; [] for the usual ones", form=NAMES),
           _number("interval_ns", "between two samples, 50 us to an hour"),
           replace(_number("points", "looks in an interval of which two samples have the extremes; 1: none"),
                   default=1)),
    _asked("samples", BENCH, VIEWER,
           "rows of at_ns and the signals since the last time, and how many were lost",
           _number("watch", "the watch's number")),
    _asked("unwatch", BENCH, VIEWER, "end a watch", _number("watch", "the watch's number")),
    _asked("capture", BENCH, VIEWER, "the connection carries a pcapng capture of ports from now on",
           Parameter("ports", "names of ports, taps and segments", form=NAMES)),
    # Looking back.
    _asked("past", BENCH, VIEWER,
           "the recording of this run: its length, and marks of what happened, unless `revision` is theirs",
           replace(_number("revision", "of the marks that the asker has"), default=-1),
           Parameter("most", "marks of a kind; more are summed", "", 1, 2000, 400.0, is_whole=True),
           takes_time=True),
    _asked("past_state", BENCH, VIEWER, "all axes, and the faults, at a time of this run",
           _second("at_s", "the time"), _LANE, takes_time=True),
    _asked("past_samples", BENCH, VIEWER,
           "fields over a window of this run: each step, or the smallest and the largest of each interval",
           Parameter("fields", "names, as m1.position_deg, m1.*", form=NAMES),
           _second("from_s", "beginning of the window"), _second("to_s", "its end"),
           Parameter("points", "of a field, at the most", "", 2, 20_000, 1200.0, is_whole=True), _LANE,
           takes_time=True),
    _asked("past_bytes", BENCH, VIEWER, "the last bytes at a port before a time of this run, both ways",
           _name("port", "its address, as s1, s1.network"), _second("at_s", "the time"), _LANE,
           takes_time=True),
    _asked("past_packets", BENCH, VIEWER, "the last packets or frames of a wire before a time of this run",
           _name("wire", "its name"), _second("at_s", "the time"), _LANE, takes_time=True),
    _asked("past_find", BENCH, VIEWER,
           "the time at which a condition begins to hold, within ten minutes of this run",
           Parameter("condition", "as of `hil find`", form=TEXT), _second("from_s", "where to begin"),
           Parameter("back", "look before it, not behind it", form=FLAG, default=False), _LANE,
           takes_time=True),
    # Faults.
    _asked("inject", PLACE, ADMIN, "inject a fault; answers its number",
           _name("fault", "its kind; `hil fault kinds` lists them"),
           Parameter("parameters", "the fault's own", form=OBJECT)),
    _asked("clear", BENCH, ADMIN, "clear a fault", Parameter("number", "which one", form=WHICH),
           _name("on", "only what is on this device, segment or bus; empty: anywhere", default="")),
    _asked("faults", BENCH, VIEWER, "the faults that are active"),
    _asked("fault_places", BENCH, VIEWER, "the places where faults can be, each with the kinds that fit it"),
    # Runs.
    _asked("run", BENCH, OPERATOR, "submit a multi-axis run, or only check it",
           Parameter("text", "the run, YAML or JSON", form=TEXT),
           Parameter("file", "where it came from, for its problems", form=TEXT, default="<run>"),
           Parameter("check", "do not carry it out", form=FLAG, default=False),
           Parameter("points", "of the plan, at most, in a check's answer; 0: none", "", 0, 20_000, 0.0,
                     is_whole=True),
           _name("name", "in the place of the document's own; empty: that one", default=""),
           Parameter("fresh", "carry it out under a name that no run has", form=FLAG, default=False),
           takes_time=True),
    _asked("drawing", BENCH, VIEWER,
           "read, check and plan a program in G-code; answers its problems, or its path and runs to submit,"
           " each with a digest that its progress has too",
           Parameter("text", "the program; without both texts: the last drawing of an operator", form=TEXT,
                     default=""),
           Parameter("machine", "the machine's document, YAML", form=TEXT, default=""),
           Parameter("file", "where the program came from, for its problems", form=TEXT, default="program"),
           Parameter("machine_file", "where the machine came from", form=TEXT, default="machine"),
           Parameter("feed_percent", "feed override", "%", 1, 200, 100.0),
           Parameter("check", "problems, remarks and figures alone: it is not shown to others", form=FLAG,
                     default=False),
           takes_time=True),
    _asked("runs", RUN, VIEWER, "the state of a run; with an empty name all runs that are remembered"),
    _asked("cancel_run", RUN, OPERATOR, "end a run",
           replace(HOW_TO_STOP, default=None)),
    _asked("pace_run", RUN, OPERATOR,
           "slow a run down along its paths: 1 is as planned, 0 pauses it; moves of SACs are not slowed",
           Parameter("pace", "share of the planned speed", "", 0, 1)),
    _asked("part", RUN, OPERATOR, "what the bench that leads a run asks of this one",
           Parameter("given", "see run/<id>/part", form=OBJECT), takes_time=True),
    # All of it.
    _asked("stop_site", BENCH, OPERATOR,
           "stop all that moves on this bench and on all that it is joined with; answers who has confirmed",
           replace(HOW_TO_STOP, default="grace"),
           Parameter("within_s", "time to confirm, of the wall", "s", 0.05, 60, 1.0), takes_time=True),
    _asked("halt", BENCH, OPERATOR,
           "stop all axes that move, and end all runs; answers what was stopped, and what was not, with why."
           " It overtakes what waits",
           HOW_TO_STOP,
           Parameter("axes", "only these, of a device all of its axes, and only runs that have one of them",
                     form=NAMES, is_optional=True),
           takes_time=True),
    _asked("events", BENCH, VIEWER,
           "what happened to the bench, and who asked for it, the oldest first",
           replace(_number("after", "the revision after which; 0: all that is kept"), default=0)),
    # Leases.
    _asked("lease", BENCH, VIEWER,
           "who has the bench, until when and why, and which doors are closed to commands meanwhile"),
    _asked("take_lease", BENCH, OPERATOR,
           "take a lease of the bench: until it ends, others may look and not command",
           Parameter("why", "what for, in a line", maximum=WHY_CHARACTERS, is_text=True),
           _LEASED_S, _LEASED_UNTIL,
           Parameter("doors", f"doors without users that stay open: {', '.join(DOORS)}; [] for none",
                     form=NAMES, is_optional=True)),
    _asked("renew_lease", BENCH, OPERATOR, "let the asker's lease end at another time",
           _LEASED_S, _LEASED_UNTIL),
    _asked("give_lease", BENCH, OPERATOR, "give the asker's lease back"),
    _asked("break_lease", BENCH, OPERATOR, "end a lease of somebody else; log and events say who did"),
    # The daemon.
    _asked("pause", BENCH, OPERATOR,
           "hold the bench's time: boards answer nothing, and what clients send waits until `resume`"),
    _asked("resume", BENCH, OPERATOR, "let the bench's time go on from where it stands"),
    _asked("reload", BENCH, ADMIN,
           "read the configuration again; answers devices kept, restarted, added and removed",
           takes_time=True),
    _asked("stop", BENCH, ADMIN, "end the daemon as SIGTERM does"),
)  # fmt: skip
OPERATIONS = {operation.name: operation for operation in _ROWS}
