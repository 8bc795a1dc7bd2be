"""Inputs from outside to a device, and their form in the input log.

Everything that a bench's run depends on, beside its configuration, is one of these with its effective time. A
log line is a JSON object: ``at_ns``, ``device``, ``input`` (the name below), and its fields;
``input_reading`` reads it back.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

from hil.vocab.path import PathPiece
from hil.vocab.time import SimTimeNs
from hil.wire.step_dir import MAX_NS, Train

LOG_FORMAT = "hil-inputs"
LOG_VERSION = 3
OLD_VERSIONS = (1, 2)
"""Versions that are read too. Neither has checks; version 1 has no end line, so nothing says whether a log
of it is whole."""


@dataclass(frozen=True)
class Bytes:
    """Bytes from a client: ``data`` (hexadecimal digits in the log) at its baud, None where it chose none, to
    one of the device's UARTs (``port`` in the log; empty, and left out there: the first), in its format, as
    ``7E1`` (empty, and left out: the UART's own)."""

    data: bytes
    client_baud: int | None = None
    port: str = ""
    client_format: str = ""


@dataclass(frozen=True)
class Pin:
    """New level of an input pin: D0 direction, D1 step, D2 enable (active low), D3."""

    pin: str
    level: int


@dataclass(frozen=True)
class SetField:
    """Value for a writable field of the axis: a load, a register of the encoder."""

    field: str
    value: float


@dataclass(frozen=True)
class ScriptEncoder:
    """Encoder counts from points of (simulated ns, count); no points: from the shaft again."""

    points: tuple[tuple[int, int], ...]
    linear: bool


@dataclass(frozen=True)
class PulseTrain:
    """A pulse train on the step/dir inputs, from now on, instead of the one before; empty: none."""

    train: Train


@dataclass(frozen=True)
class Reset:
    """Power cycle; the shaft stays where it is."""


@dataclass(frozen=True)
class LineOpened:
    """Opening of the port at one of the device's UARTs, or the edge of DTR there: it resets the processor of
    a board that is made so. ``port``: as ``Bytes``."""

    port: str = ""


@dataclass(frozen=True)
class LoadProgram:
    """Program for the device's processor, in the place of the one that it has: what ``packed`` of
    ``hil.sketch.chip_program`` has made, as hexadecimal digits. The board keeps it, and is switched off and
    on."""

    program: str


@dataclass(frozen=True)
class WriteMemory:
    """Bytes that a debugger writes into a processor: ``data`` as hexadecimal digits, into its data space or
    its EEPROM from ``at`` on; ``pc``: it goes on at that byte address."""

    memory: str
    at: int
    data: str = ""


MEMORIES = {"data": 0x900, "eeprom": 0x400, "pc": 0x8000}
"""Memories that a debugger writes, with their sizes in bytes."""


@dataclass(frozen=True)
class CommitDone:
    """Answer of the store to the device's commit. ``at_once``: within the turn that committed, as a store in
    memory does; only in logs."""

    durable: bool
    at_once: bool = False


@dataclass(frozen=True)
class Play:
    """Bursts that a tap sends: rows of (nanoseconds from now, bytes as hexadecimal digits), ascending."""

    bursts: tuple[tuple[int, str], ...]


MAX_BURSTS = 50_000
"""Maximum number of bursts of one ``Play``: they take some 0.2 s of a processor at once."""


def bursts_problem(bursts: Sequence[tuple[int, str]]) -> str | None:
    """Reason why rows from outside cannot be played, or None."""
    before_ns = 0
    for at_ns, _ in bursts:
        if at_ns < before_ns:
            return "bursts have to stand in the order of their times"
        before_ns = at_ns
    return f"a burst after {before_ns} ns; write at most {MAX_NS}" if before_ns > MAX_NS else None


@dataclass(frozen=True)
class Attach:
    """Beginning of a channel of a CAN bus: a node without a device, ``node`` behind the bus's name, goes on
    it."""

    node: str


@dataclass(frozen=True)
class Detach:
    """End of a channel: its node leaves the bus."""


@dataclass(frozen=True)
class Frames:
    """Frames of CAN that a channel's node sends, in this order, each as ``123#0011``."""

    frames: tuple[str, ...]


@dataclass(frozen=True)
class Inject:
    """Beginning of a fault, under a number; its kind and parameters as ``hil.vocab.faults`` has them."""

    number: int
    kind: str
    parameters: tuple[tuple[str, float | str], ...]


@dataclass(frozen=True)
class Clear:
    """End of a fault."""

    number: int


Words = tuple[tuple[str, int | None, str], ...]
"""Written bytes: the serial interface, its baud, and the bytes as hexadecimal digits."""


@dataclass(frozen=True)
class Stopped:
    """Stop of the device in one of its turns, counted from its start, for a reason that is no matter of
    simulated time. ``words``: what it had sent in this turn."""

    turn: int
    reason: str
    words: Words = ()


@dataclass(frozen=True)
class Do:
    """Verb of the device's table (``hil.vocab.verbs``) with all its parameters."""

    verb: str
    parameters: tuple[tuple[str, float | str], ...] = ()
    at_ns: int | None = None
    """Time at which to carry it out, instead of on arrival."""


@dataclass(frozen=True)
class Follow:
    """Path for the set-point to follow from ``start_ns`` on (``hil.vocab.path``). ``is_joined``: where that
    is past, the set-point goes on from where the path is now."""

    start_ns: int
    path: tuple[PathPiece, ...]
    is_joined: bool = False


Input = (
    Do
    | Follow
    | Inject
    | Clear
    | Play
    | Attach
    | Detach
    | Frames
    | Bytes
    | Pin
    | SetField
    | ScriptEncoder
    | PulseTrain
    | Reset
    | LineOpened
    | LoadProgram
    | WriteMemory
    | CommitDone
    | Stopped
)
KINDS: dict[str, type[Any]] = {
    "bytes": Bytes,
    "play": Play,
    "attach": Attach,
    "detach": Detach,
    "frames": Frames,
    "inject": Inject,
    "clear": Clear,
    "do": Do,
    "follow": Follow,
    "pin": Pin,
    "set_field": SetField,
    "script_encoder": ScriptEncoder,
    "drive": PulseTrain,
    "reset": Reset,
    "line_opened": LineOpened,
    "load_program": LoadProgram,
    "write_memory": WriteMemory,
    "commit_done": CommitDone,
    "stopped": Stopped,
}
NAMES = {kind: name for name, kind in KINDS.items()}
"""Names of inputs in the log."""


class Logged(NamedTuple):
    """Input with its effective time. ``device``: address of what it is for (``hil.vocab.address``)."""

    at_ns: SimTimeNs
    device: str
    input: Input


class InputLogError(Exception):
    """Error of an input log that cannot be read: ``str(error)`` says where and why."""


quoted = lru_cache(1024)(json.dumps)
"""Text of a name in a line of the log."""


def encode_line(logged: Logged) -> str:
    """Encode one line of the log, without its end."""
    if type(logged.input) is Bytes and not (logged.input.port or logged.input.client_format):
        # As below, for the most frequent of all lines: a fifth of the time.
        to = f'{{"at_ns":{logged.at_ns},"device":{quoted(logged.device)},"input":"bytes"'
        baud = "null" if logged.input.client_baud is None else logged.input.client_baud
        return f'{to},"data":"{logged.input.data.hex()}","client_baud":{baud}}}'
    values = dict(vars(logged.input))  # asdict copies every row: seconds for a long train
    if isinstance(logged.input, PulseTrain):
        values["train"] = [tuple(vars(edges).values()) for edges in logged.input.train]
    if isinstance(logged.input, Follow) and not logged.input.is_joined:
        del values["is_joined"]
    if isinstance(logged.input, Do):
        values["later_ns"] = values.pop("at_ns")
        if values["later_ns"] is None:
            del values["later_ns"]
    if isinstance(logged.input, CommitDone) and not logged.input.at_once:
        del values["at_once"]
    if isinstance(logged.input, LineOpened) and not logged.input.port:
        del values["port"]
    if isinstance(logged.input, Bytes):
        values["data"] = logged.input.data.hex()
        for name in ("port", "client_format"):
            if not values[name]:
                del values[name]
    head = {"at_ns": logged.at_ns, "device": logged.device, "input": NAMES[type(logged.input)]}
    return json.dumps(head | values, separators=(",", ":"))
