"""Rows of what the door tells pages, by name and type: the page's own types are written from them."""

from typing import Literal, NotRequired, TypedDict

RoleName = Literal["viewer", "operator", "admin"]


class ParameterRow(TypedDict):
    """Parameter of a verb, a fault or an operation. ``text``: values, unit and default, in one line."""

    name: str
    summary: str
    unit: str
    type: Literal["number", "whole", "text", "choice", "other"]
    form: NotRequired[str]
    choices: NotRequired[list[str]]
    minimum: NotRequired[float]
    maximum: NotRequired[float]
    limits: NotRequired[str]
    default: float | str | None
    is_optional: bool
    text: str


class VerbRow(TypedDict):
    """Verb of a device."""

    summary: str
    role: RoleName
    parameters: list[ParameterRow]


class FieldRow(TypedDict):
    """Field of an axis."""

    name: str
    type: str
    unit: str
    meaning: str
    is_settable: bool
    is_state: bool


class DeviceRow(TypedDict):
    """Device, with its first axis, or a further axis of one. ``inputs``: pins that may be driven, and the
    field that tells each one's level, or a bit of one (``pin_levels.13``); empty: none does."""

    name: str
    profile: str
    is_real: bool
    is_seen: bool
    verbs: dict[str, VerbRow]
    fields: list[FieldRow]
    inputs: dict[str, str]


class FaultKindRow(TypedDict):
    """Kind of fault. ``title``: what happens, in a few words; ``on``: its target in words."""

    name: str
    title: str
    layer: str
    target: str
    on: str
    summary: str
    is_once: bool
    parameters: list[ParameterRow]


class LineRow(TypedDict):
    """Segment. ``framing``: sac, modbus_rtu, or another that a profile brings."""

    name: str
    framing: str
    baud: int
    format: str


class OperationRow(TypedDict):
    """Operation of the table."""

    target: str
    target_summary: str
    summary: str
    role: RoleName
    takes_time: bool
    parameters: list[ParameterRow]


class BenchRow(TypedDict):
    """Description of a bench without its devices."""

    protocol: int
    version: str
    bench: str
    segments: list[LineRow]
    buses: list[str]
    ports: list[str]
    operations: dict[str, OperationRow]
    fault_kinds: list[FaultKindRow]


class Greeting(BenchRow):
    """First message to a page. ``instance``: another one for each start of the bench; ``message_bytes``:
    limit of a page's messages."""

    instance: str
    message_bytes: int
    user: str
    role: RoleName
    devices: list[DeviceRow]


class WatchAnswer(TypedDict):
    """Answer of ``watch``: its number."""

    watch: int


class TerminalAnswer(TypedDict):
    """Answer of ``open``: number of the terminal, and of other programs that have the port open."""

    terminal: int
    clients: int


class ExportAnswer(TypedDict):
    """Answer of ``export``: a capture, and the number of its records."""

    pcapng_base64: str
    events: int


class PacketFieldRow(TypedDict):
    """Field of a packet: its value in words, and the bytes from ``begin`` to before ``end``; equal: none. One
    of a higher ``level`` is a part of the field before it."""

    name: str
    text: str
    begin: int
    end: int
    level: int


class FieldsAnswer(TypedDict):
    """Answer of ``fields``."""

    fields: list[PacketFieldRow]
