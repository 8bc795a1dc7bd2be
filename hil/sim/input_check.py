"""Check of an input against a bench, by one rule for what is logged and for what a replay reads.

A log that another program wrote, or that was damaged, may have names that are not here and values that cannot
be. What hil makes itself has to be such that a replay takes it.
"""

import re
from math import isfinite

from hil.core import CoreAxis
from hil.firmware.set_point_paths import length_ns
from hil.sim import inputs
from hil.sim.bench import BenchRuntime
from hil.sim.client_tap import ClientChannel, ClientTap, HasChannels
from hil.sim.given_fault import fault_of, fault_problems
from hil.sim.input_reading import decode, read_line
from hil.sim.twin import Twin
from hil.sim.verb_calls import verb_problem
from hil.sketch.chip_program import unpacked
from hil.vocab.address import NAME_PATTERN, Address, address_of, no_part
from hil.vocab.faults import Fault, FaultRefused
from hil.vocab.line_format import format_named
from hil.vocab.parameters import plain
from hil.vocab.path import Path
from hil.vocab.verbs import VerbRefused
from hil.wire.step_dir import train_problem

BAUDS = range(1, 1 << 32)
"""Bauds that a client can have chosen."""
MAX_VALUE = 1e9
"""Maximum value of a field."""
SCRIPT_LIMIT = 1 << 61
LONGEST_PATH_NS = 1 << 61
_SHOWN = 40
_SHOWN_LINE = 1000
ADD_CAN = "add `can:` to its configuration, `hil docs can`"
"""Remedy where a bench has no CAN bus."""
OF_AXES = (
    *(inputs.Pin, inputs.SetField, inputs.ScriptEncoder, inputs.PulseTrain),
    *(inputs.Do, inputs.Follow),
)
"""Kinds of inputs that are for an axis, or may be."""


def assert_taken_back(bench: BenchRuntime, logged: inputs.Logged) -> None:
    """Assert that a replay of the log of a bench would take an input, as ``BenchRuntime.check_input``."""
    line = inputs.encode_line(logged)
    try:
        back = decode(read_line(line))
    except inputs.InputLogError as error:
        raise AssertionError(f"no replay would read this: {error}: {line[:_SHOWN_LINE]}") from None
    assert back == logged, f"a replay would read this as {back}: {line[:_SHOWN_LINE]}"
    problem = input_problem(bench, back.device, back.input)
    assert problem is None, f"no replay would take this: {problem}: {line[:_SHOWN_LINE]}"


def input_problem(bench: BenchRuntime, target: str, given: inputs.Input) -> str | None:
    """Reason why the bench cannot take an input now, or None."""
    if isinstance(given, inputs.Inject | inputs.Clear):
        return _fault_problem(bench, target, given)
    if isinstance(given, inputs.Attach):
        return channel_problem(bench, target, given.node)
    if target in bench.taps:
        return _tap_problem(bench.taps[target], given)
    name, part = address_of(target)
    if name not in bench.devices:
        return f"there is no device {target[:_SHOWN]!r}; there are {', '.join([*bench.devices, *bench.taps])}"
    device = bench.devices[name]
    if part and part not in device.axes:
        return no_part(name, "axis", part[:_SHOWN], device.axes)
    if isinstance(given, OF_AXES):
        problem = _axis_problem(device, part, given)
    else:
        problem = "this is for a device, not for an axis" if part else _device_problem(device, given)
    return problem and f"{target}: {problem}"


ADDED_SINCE = {"every_s"}
"""Parameters of faults that logs of versions before do not have: their defaults are what was meant."""


def _fault_problem(bench: BenchRuntime, target: str, given: inputs.Inject | inputs.Clear) -> str | None:
    active = bench.faults.active
    if isinstance(given, inputs.Clear):
        known = active.get(given.number)
        if bench.parts.place(target) is None or (known and known.target != target):
            return f"fault {given.number} is not on {target[:_SHOWN]!r}"
        return None
    if given.number in active:
        return f"there is a fault {given.number} already"
    parameters = dict(given.parameters)
    fault, problems = fault_of(given.kind, target, parameters)
    if problems or fault is None:
        return fault_problems(problems)
    if fault.parameters.keys() - parameters.keys() - ADDED_SINCE:
        return f"parameters of {given.kind} are {', '.join(fault.parameters)}, all of them"
    try:
        bench.faults.check(Fault(given.kind, target[:_SHOWN], parameters), with_others=False)
    except FaultRefused as refusal:
        return str(refusal)
    return None


def _baud_problem(name: str, baud: int | None) -> str | None:
    known = baud is None or baud in BAUDS
    return None if known else f"{name}: write null, or {BAUDS.start} to {BAUDS.stop - 1}"


def channel_problem(bench: BenchRuntime, bus: str, node: str) -> str | None:
    """Reason why a bus cannot have a channel's node of this name, or None."""
    wires = {name: wire for name, wire in bench.wires.items() if isinstance(wire, HasChannels)}
    if bus not in wires:
        there = f"there are {', '.join(wires)}" if wires else f"this bench has none; {ADD_CAN}"
        return f"there is no CAN bus {bus[:_SHOWN]!r}; {there}"
    if not re.fullmatch(NAME_PATTERN, node):
        return f"{node[:_SHOWN]!r} is no name; write small letters, digits, _ and -, at most 32"
    return wires[bus].channel_problem(str(Address(bus, node)), bench.taps.values())


def _tap_problem(tap: ClientTap, given: inputs.Input) -> str | None:
    if isinstance(given, inputs.Frames | inputs.Detach):
        if not isinstance(tap, ClientChannel):
            return "this is for a channel of a CAN bus"
        return tap.frames_problem(given.frames) if isinstance(given, inputs.Frames) else None
    if isinstance(given, inputs.Bytes):
        return _baud_problem("client_baud", given.client_baud)
    if isinstance(given, inputs.Play):
        return inputs.bursts_problem(given.bursts)
    return "a tap takes bytes and bursts"


def _device_problem(device: Twin, given: inputs.Input) -> str | None:
    match given:
        case inputs.Bytes(_, baud, port, client_format):
            if client_format and format_named(client_format) is None:
                return "client_format: write one as in 7E1"
            return _port_problem(device, port) or _baud_problem("client_baud", baud)
        case inputs.LineOpened(port):
            return _port_problem(device, port)
        case inputs.LoadProgram(program):
            return _program_problem(device, program)
        case inputs.WriteMemory():
            return _memory_problem(device, given)
        case inputs.Play():
            return "a device takes no bursts"
        case inputs.Stopped(_, _, words):
            return _words_problem(device, words)
    return None


def _program_problem(device: Twin, program: str) -> str | None:
    if not device.processors:
        return "it has no processor that runs a program"
    try:
        unpacked(bytes.fromhex(program))
    except ValueError as error:
        return f"program: {error}"
    return None


def _memory_problem(device: Twin, given: inputs.WriteMemory) -> str | None:
    if not device.processors:
        return "it has no processor that runs a program"
    try:
        count = len(bytes.fromhex(given.data))
    except ValueError:
        return "data: write hexadecimal digits"
    room = inputs.MEMORIES.get(given.memory)
    if room is None:
        return f"memory: write one of {', '.join(inputs.MEMORIES)}"
    return None if 0 <= given.at <= room - max(1, count) else f"at: the memory has {room} bytes"


def _axis_problem(device: Twin, part: str, given: inputs.Input) -> str | None:
    """Reason why this axis of a device cannot have an input of ``OF_AXES``, or None."""
    if isinstance(given, inputs.Do):
        return _verb_problem(device, part, given)
    if (axis := device.axes.get(part)) is None:
        return "it has no axis"
    match given:
        case inputs.Pin(pin, level):
            return _pin_problem(axis, pin, level)
        case inputs.SetField(field, value):
            return _field_problem(axis, field, value)
        case inputs.ScriptEncoder(points, _):
            return _script_problem(points)
        case inputs.PulseTrain(train):
            return train_problem(train, axis.pins)
        case inputs.Follow(start_ns, path):
            return _path_problem(start_ns, path)
    return None


def _pin_problem(axis: CoreAxis, pin: object, level: object) -> str | None:
    if pin in axis.pins and level in (0, 1):
        return None
    return f"its inputs are {', '.join(axis.pins)}; levels are 0 and 1"


def _field_problem(axis: CoreAxis, field: str, value: float) -> str | None:
    if field not in axis.kind.fields or not axis.kind.described(field).writable:
        return f"{field[:_SHOWN]!r} is no field that can be set"
    if own := axis.kind.board_fields.get(field):
        problem = own.refusal(value)
        return problem and f"{field}: {problem}"
    return None if abs(value) <= MAX_VALUE else f"{field}: write at most {plain(MAX_VALUE)}"


def _script_problem(points: tuple[tuple[int, int], ...]) -> str | None:
    before_ns = -SCRIPT_LIMIT
    for at_ns, raw in points:
        if not before_ns <= at_ns <= SCRIPT_LIMIT or abs(raw) > SCRIPT_LIMIT:
            return "points of an encoder's script stand in the order of their times, all within 2^61"
        before_ns = at_ns
    return None


def _verb_problem(device: Twin, part: str, given: inputs.Do) -> str | None:
    if given.verb not in device.verbs:
        return f"a {device.profile} has no verb {given.verb[:_SHOWN]!r}; it has {', '.join(device.verbs)}"
    verb, parameters = device.verbs[given.verb], dict(given.parameters)
    try:
        filled = verb.filled(parameters)
    except VerbRefused as refusal:
        return f"{given.verb}: {refusal}"
    if filled.keys() != parameters.keys():
        return f"parameters of {given.verb} are {', '.join(filled)}, all of them"
    if problem := verb_problem(device.name, device.axes, verb, part):
        return problem
    if given.verb == "pin":
        return _pin_problem(device.axes[part], parameters["pin"], parameters["level"])
    return None


def _words_problem(device: Twin, words: tuple[tuple[str, int | None, str], ...]) -> str | None:
    found = (_port_problem(device, port) or _baud_problem("baud", baud) for port, baud, _ in words)
    return next(filter(None, found), None)


def _port_problem(device: Twin, port: str) -> str | None:
    return None if port in device.uarts else f"it has no serial interface {port[:_SHOWN]!r}"


def _path_problem(start_ns: int, path: Path) -> str | None:
    if not 0 <= start_ns <= LONGEST_PATH_NS or length_ns(path) > LONGEST_PATH_NS:
        return "a path begins and ends within 73 years"
    if any(piece.duration_ns < 0 for piece in path):
        return "no piece of a path takes less than no time"
    if not all(isfinite(value) for piece in path for value in piece):
        return "all numbers of a path are finite"
    return None
