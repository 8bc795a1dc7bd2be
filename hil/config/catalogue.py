"""Everything that a configuration may name: profiles with their parameters, kinds of ports and bridges."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BaseModel, Field, PrivateAttr, ValidationError

from hil.config.board_fields import field_findings, made_fields, with_fields_axis
from hil.config.board_interfaces import UartNumbers, UsbDeviceInfo
from hil.config.board_numbers import ANY_SUPPLY, AxisParameter, HardwareVersion
from hil.config.board_parameters import BuildParameter, own_value_findings
from hil.config.board_processor import (
    ProcessorKey,
    processor_findings,
    processor_warnings,
    with_processors_axis,
)
from hil.config.document import Document, Finding, KeyPath
from hil.config.explain import LazyModel, StrictModel, findings_of, no_such, shown, suggestion
from hil.config.motors import MOTORS, motor_parameters
from hil.config.yaml_text import document_from_yaml
from hil.core.axis_kind import AxisKind
from hil.core.kinds import KINDS, PROCESSOR_LAWS, kind_of
from hil.vocab.address import NAME_PATTERN
from hil.vocab.axis_plan import FULL_PARAMETERS, AxisPlan, ProcessorPlan
from hil.vocab.bus import BusKind, DriveKind, MapKind, NodeKind, WireKind
from hil.vocab.firmware import MAIN
from hil.vocab.framing import Framing
from hil.vocab.late_dataclass import dataclass
from hil.vocab.own_fields import OwnField
from hil.vocab.problem import ConfigError, Problem, Unusable
from hil.vocab.profile import Profile
from hil.vocab.wire import WireInfo

if TYPE_CHECKING:
    from hil.config.own_field_model import FieldInfo
else:

    def _field() -> type[BaseModel]:
        from hil.config.own_field_model import FieldInfo

        return FieldInfo

    FieldInfo = Annotated[Any, LazyModel(_field)]

ONLY_AXIS = "axis"
"""Name of the axis of a profile that does not name it."""
MOST_AXES = 16
PartName = Annotated[str, Field(pattern=NAME_PATTERN)]


class AxisInfo(StrictModel):
    """Axis of a kind of board."""

    law: str
    motor: str | None = None
    """Motor of the catalogue whose numbers ``axis`` begins with."""
    axis: dict[str, AxisParameter]
    """Parameters by names that end in the unit."""
    registers: dict[str, int] = Field(default={})


class ProfileInfo(StrictModel):
    """Kind of board, as its ``profile.yaml`` describes it."""

    name: str = Field(pattern=r"^[a-z][a-z0-9_]{0,31}$")
    title: str
    law: str | None = None
    """Law of the board's axis; None: it has no axis, or ``axes`` names them."""
    motor: str | None = None
    """Motor of the catalogue whose numbers ``axis`` begins with."""
    plant: Literal["simple", "full"] = "simple"
    usb: Literal["native"] | None = None
    """Kind of USB; ``native``: the board's own processor is on the USB, without a UART in between."""
    usb_device: UsbDeviceInfo | None = None
    """Device that the board is on the USB; None: a serial adapter stands for it."""
    processor: ProcessorKey = None
    """Processor that runs a user's program, on a board whose axis is its pins; None: none does."""
    uarts: dict[PartName, UartNumbers] = Field(default={MAIN: UartNumbers.model_construct()})
    """Serial interfaces by name, as ``Profile.uarts`` of its ``board.py`` has them; empty: it has none. The
    first one's port is at the device's own name."""
    greeting: str = ""
    """Text that a board answers at once: the line for trying a port sends it, `hil monitor` names it."""
    ready_after_s: float = 0.0
    """Time from power-up to the board's first answer."""
    hardware: dict[str, HardwareVersion] = Field(default={"1": ANY_SUPPLY}, min_length=1)
    default_hardware: str = "1"
    axis: dict[str, AxisParameter] = Field(default={})
    """Parameters of the board's axis by names that end in the unit."""
    registers: dict[str, int] = Field(default={})
    map: Any = None
    """Map of registers of the board's own, a drive's, unless a device has another; None: it has none."""
    drive: str | None = None
    """Protocol of the real drives that it stands for, ``profile_drive`` of a ``DriveKind``, as ``canopen``;
    None: they have a ``map``, or real ones have a terminal."""
    dialogue: Any = None
    """Table of commands and answers, ``DialogueInfo``, of a board that needs no Python; once it is read, the
    ``InstrumentTable``. None: its Python says what it does."""
    fields: dict[str, FieldInfo] = Field(default={})
    """Fields of the board's own, by name, beside those of its first axis, or of a board without a motor."""
    parameters: dict[str, BuildParameter] = Field(default={})
    """Constants in its firmware's sources that a device may change, by their names there."""
    named_axes: dict[PartName, AxisInfo] = Field(default={}, alias="axes", max_length=MOST_AXES)
    """Axes of a board with several, by name; instead of ``law``, ``axis`` and ``registers``."""

    _warnings: tuple[Problem, ...] = PrivateAttr(default=())

    @property
    def warnings(self) -> tuple[Problem, ...]:
        """Warnings about what the board can be on the bench, and might not be on the desk."""
        return self._warnings

    def with_warnings(self, warnings: tuple[Problem, ...]) -> "ProfileInfo":
        """Copy that has these warnings."""
        copied = self.model_copy()
        copied._warnings = warnings
        return copied

    def kind(self, axis: str) -> AxisKind:
        """Kind of an axis by its name. Raises KeyError: there is no such axis, or law."""
        info = self.axes[axis]
        return kind_of(info.law, self.plan_of(info), self.fields_of(axis))

    def fields_of(self, axis: str, starts: Mapping[str, float] | None = None) -> tuple[OwnField, ...]:
        """Fields of the board's own that an axis has: all, of the first. ``starts``: as ``made_fields``."""
        return made_fields(self.fields, starts) if axis == next(iter(self.axes), "") else ()

    def plan_of(self, axis: AxisInfo) -> ProcessorPlan | None:
        """Plan of the processor whose pins an axis is; None: it is none, or the board has none."""
        return self.processor.plan if self.processor and axis.law in PROCESSOR_LAWS else None

    @property
    def first_law(self) -> tuple[str, ProcessorPlan | None]:
        """Law of its first axis, and the processor whose pins it is; empty: it has no axis."""
        first = next(iter(self.axes.values()), None)
        return (first.law, self.plan_of(first)) if first else ("", None)

    @cached_property
    def axes(self) -> Mapping[str, AxisInfo]:
        """Axes by name, 0 to 16."""
        if self.law is None:
            return self.named_axes
        return {ONLY_AXIS: AxisInfo(law=self.law, motor=self.motor, axis=self.axis, registers=self.registers)}

    @property
    def send_buffers(self) -> dict[str, int]:
        """Bytes of the buffers to send, by the names of the UARTs that say them."""
        given = {name: uart.send_buffer_bytes for name, uart in self.uarts.items()}
        return {name: size for name, size in given.items() if size is not None}

    @property
    def receive_buffers(self) -> dict[str, int]:
        """The same of the buffers to receive."""
        given = {name: uart.receive_buffer_bytes for name, uart in self.uarts.items()}
        return {name: size for name, size in given.items() if size is not None}

    @property
    def first_uart(self) -> str:
        """Name of its first serial interface; empty: it has none."""
        return next(iter(self.uarts), "")

    def baud(self, uart: str = "") -> int | None:
        """Speed of a serial interface unless a device sets one, by default of the first; None: bytes take no
        time, or there is no such interface."""
        numbers = self.uarts.get(uart or self.first_uart)
        return numbers.baud if numbers else None


def usable(kinds: Mapping[str, type[BaseModel]]) -> dict[str, type[BaseModel]]:
    """Kinds that can be used: the others do not keep them from being listed."""
    found = {}
    for kind in kinds:
        with suppress(Unusable):
            found[kind] = kinds[kind]
    return found


@dataclass(frozen=True)
class Catalogue:
    """Catalogue of an installation. ``ports`` has the options model of each kind of port."""

    profiles: Mapping[str, ProfileInfo]
    ports: Mapping[str, type[BaseModel]]
    bridges: Mapping[str, type[BaseModel]] = field(default_factory=dict)
    """Options model of each kind of bridge."""
    boards: Mapping[str, Profile] = field(default_factory=dict)
    """Profile of each board, from its ``board.py``, imported when it is asked for; raises ConfigError for one
    that cannot be used."""
    refused: Mapping[str, Sequence[Problem]] = field(default_factory=dict)
    """Problems of boards whose ``profile.yaml`` cannot be used, or of which there are two; known once
    ``profiles`` was asked for them."""
    path: tuple[Path, ...] = ()
    """Further folders in which boards were looked for."""
    wrong_paths: Mapping[int, tuple[str, str]] = field(default_factory=dict)
    """Message and remedy for each of ``path`` that does not do, by its index."""
    at: "Callable[[tuple[Path, ...]], Catalogue] | None" = None
    """Finds the catalogue with these folders instead."""
    refused_motors: Callable[[Mapping[str, AxisPlan]], Mapping[str, str]] = lambda plans: {}
    """Motors, by device, that the core would not open, each with the reason: a message, a colon, a remedy."""
    read_text: Callable[[Path], str] | None = None
    """Reads the text of a file that a configuration names. Raises OSError or UnicodeDecodeError."""
    read_bytes: Callable[[Path], bytes] | None = None
    """Reads such a file as it is. Raises OSError."""
    framings: Mapping[str, Framing] = field(default_factory=dict)
    """Framings of lines by name."""
    buses: tuple[BusKind, ...] = ()
    """Kinds of buses."""
    bus_problems: tuple[Problem, ...] = ()
    """Problems of kinds of buses that cannot be used."""
    wire_infos: Mapping[str, WireInfo] = field(default_factory=dict)
    """Reports on wires, by the key of a configuration under which they stand."""

    @property
    def wire_kinds(self) -> list[WireKind]:
        """Kinds of wires, of the buses that have wires of their own."""
        return [bus.wires for bus in self.buses if bus.wires]

    @property
    def node_kinds(self) -> list[NodeKind]:
        """Kinds of nodes on segments."""
        return [bus.nodes for bus in self.buses if bus.nodes]

    @property
    def drive_kinds(self) -> list[DriveKind]:
        """Kinds of real drives."""
        return [bus.drives for bus in self.buses if bus.drives]

    @property
    def maps(self) -> MapKind | None:
        """Kind of maps of registers; None: no bus has any."""
        return next((bus.maps for bus in self.buses if bus.maps), None)

    def drive_kind(self, profile: ProfileInfo) -> DriveKind | None:
        """Kind of the real drives that a profile stands for; None: real ones have a terminal."""
        for bus in self.buses:
            has_such = profile.map is not None if bus.maps else False
            if bus.drives and (has_such or profile.drive == (bus.drives.profile_drive or "")):
                return bus.drives
        return None

    def own_map(self, device: Any, profile: ProfileInfo) -> Any:
        """Map of a device's own registers, ``DeviceInfo.own_map``; None: it has none."""
        text = getattr(device, "map", None) or profile.map
        return self.maps.own_map(text) if text and self.maps else None

    def problems(self, profile: str) -> Sequence[Problem]:
        """Problems of a board, which this imports; none for a board that can be used, or that is unknown."""
        if profile not in self.profiles:
            return self.refused.get(profile, ())
        try:
            self.boards.get(profile)
        except ConfigError as error:
            return error.problems
        return ()


def _fit_motors(document: Document) -> Iterator[Finding]:
    """Complete the axes of a document with the numbers of their motors. Findings: no such motor."""
    value: Any = document.value
    if not isinstance(value, dict):
        return
    value, findings = _fitted(value, ())
    if isinstance(axes := value.get("axes"), dict):
        done = {name: _fitted(axis, ("axes", name)) for name, axis in axes.items()}
        value |= {"axes": {name: axis for name, (axis, _) in done.items()}}
        findings += [finding for _, found in done.values() for finding in found]
    document.value = value
    yield from findings


def _fitted(value: Any, path: KeyPath) -> tuple[Any, list[Finding]]:
    motor = value.get("motor") if isinstance(value, dict) else None
    if not isinstance(motor, str):
        return value, []
    if motor not in MOTORS:
        return value, [no_such((*path, "motor"), "motor", motor, MOTORS)]
    own = value.get("axis", {})
    return (value | {"axis": motor_parameters(motor, own)} if isinstance(own, dict) else value), []


def _parameter_findings(path: KeyPath, parameter: AxisParameter, law: str) -> Iterator[Finding]:
    kind, name = KINDS.get(law), str(path[-1])
    known = (*kind.parameters, *kind.optional_parameters, *FULL_PARAMETERS) if kind else ()
    if known and name not in known:
        message = f"neither the law {law} nor a plant has this parameter"
        yield Finding(path, message, suggestion(name, known), at_key=True)
    elif not _ends_in(name, parameter.unit):
        message = f"{shown(parameter.unit)} is not the unit that the name {name} ends in"
        yield Finding((*path, "unit"), message, "write the value in that unit, as in kg m2 or Nm/A")
    for key, value in (("value", parameter.value), ("full", parameter.full)):
        if value is not None and (refusal := parameter.refusal(value)):
            yield Finding((*path, key), *refusal)


def _ends_in(name: str, unit: str) -> bool:
    """True if a parameter's name ends in its unit, or in the first words of it; one that counts kinds (0:
    A4988) has no unit."""
    if ":" in unit or not unit:
        return ":" in unit
    words = unit.replace("%", "pct").replace("/", " per ").split()
    endings = ("_" + "_".join(words[:count]) for count in range(1, len(words) + 1))
    return any(name.endswith(ending) for ending in endings)


def profile_from_yaml(
    text: str, folder: Path, name: str | None = None, maps: MapKind | None = None
) -> ProfileInfo:
    """Read a ``profile.yaml``; ``folder`` is where it stands. ``name``: the profile's, unless the folder's;
    ``maps``: the kind of maps of registers.

    Raises:
        ConfigError: with every problem of the text.
    """
    document = document_from_yaml(text, str(folder / "profile.yaml"))
    findings = document.findings
    if wrong := list(_fit_motors(document)):
        raise document.error([*findings, *wrong])
    if isinstance(document.value, dict) and document.value.get("map") is not None:
        findings += _map_findings(document, maps)
    table = None
    if isinstance(document.value, dict) and document.value.get("dialogue") is not None:
        from hil.config.dialogue_key import read_dialogue

        table, more = read_dialogue(document)
        findings += more
    try:
        info = ProfileInfo.model_validate(with_fields_axis(with_processors_axis(document.value)))
    except ValidationError as error:
        raise document.error(findings + findings_of(error, ProfileInfo, (), document)) from None
    if table:
        info = info.model_copy(update={"dialogue": table})
    if info.map is not None and maps and not findings:
        info = info.model_copy(update={"map": maps.model().model_validate(info.map)})
    if info.name != (name or folder.name):
        whose = "the name of its entry point" if name and name != folder.name else "its folder's name"
        findings.append(Finding(("name",), f"this is not {whose}", f'write "{name or folder.name}"'))
    if info.default_hardware not in info.hardware:
        remedy = suggestion(info.default_hardware, info.hardware)
        findings.append(Finding(("default_hardware",), "there is no such version", remedy))
    findings += [*_axes_findings(info), *own_value_findings(info.parameters)]
    if info.fields:
        findings += field_findings(info.fields, *info.first_law)
    for key in ("usb", "greeting") if not info.uarts else ():
        if getattr(info, key):
            findings.append(Finding((key,), "this board has no UART", "leave this key out", at_key=True))
    if info.processor is not None:
        bauds = {name: uart.baud for name, uart in info.uarts.items()}
        findings += processor_findings(info.processor, info.law, bauds)
    if findings:
        raise document.error(findings)
    return info.with_warnings(processor_warnings(info.processor, document)) if info.processor else info


def _map_findings(document: Document, maps: MapKind | None) -> list[Finding]:
    if maps:
        return [*maps.findings(document, ("map",), None)]
    return [Finding(("map",), "no bus here has maps of registers", "leave this key out", at_key=True)]


def _axes_findings(info: ProfileInfo) -> Iterator[Finding]:
    """Findings about the axes of a kind of board."""
    if info.law is not None and info.named_axes:
        yield Finding(("law",), "axes: names them, and each has its own", "leave this key out", at_key=True)
    if info.law is None and info.axis:
        yield Finding(("axis",), "there is no law for it", 'add the line "law: ..."', at_key=True)
    for name in info.named_axes.keys() & info.uarts.keys():
        yield Finding(("axes", name), "a UART has this name already", "give the axis another", at_key=True)
    for name, axis in info.axes.items():
        path = () if info.law is not None else ("axes", name)
        kind = KINDS.get(axis.law)
        if kind is None:
            yield Finding((*path, "law"), "there is no such control law", suggestion(axis.law, KINDS))
        for parameter in (kind.parameters if kind else ()) + FULL_PARAMETERS * (info.plant == "full"):
            if parameter not in axis.axis:
                remedy = "write it with its value, unit, about and source"
                yield Finding((*path, "axis"), f"{parameter} is missing", remedy)
        for parameter, described in axis.axis.items():
            yield from _parameter_findings((*path, "axis", parameter), described, axis.law)
