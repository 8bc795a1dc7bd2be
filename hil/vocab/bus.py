"""Kind of bus, as its folder gives it: parts, each for those buses that have such a thing."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple, Protocol

from hil.vocab.late_dataclass import dataclass
from hil.vocab.wire import WireInfo

if TYPE_CHECKING:
    from hil.vocab.desk_protocol import DeviceInfo
    from hil.vocab.framing import Framing
    from hil.vocab.line_format import LineFormat
    from hil.vocab.packet_field import Fields
    from hil.vocab.segment import Segment
    from hil.vocab.time import Clock

Raw = Mapping[str, Any]
"""Part of a configuration as it is written: a mapping whose values may be wrong."""


ReadFiles = Callable[[Raw, Any, Callable[[Any], bytes] | None], tuple[Raw, Iterable[Any], Iterable[Any]]]
"""Reader of the files that wires name. Arguments: the wires, the ``Document``, what reads a file by its
``Path``. Answers the wires with what is in the files, each ``Finding``, and each ``Problem`` of a file."""


@dataclass(frozen=True, eq=False)
class FaceKind:
    """Faces of wires for the test kit, ``hil.testing``."""

    what: str
    """Words for a wire in the kit's errors, as in "CAN bus"."""
    face: Callable[[Any, Any, Any], Any]
    """Makes the face of a wire. Arguments: the ``hil.testing.Bench``, its ``BenchRuntime``, the wire."""
    tap_face: Callable[[Any, Any], Any] | None = None
    """Makes the face of a tap, a ``TapFace``; None if that does as it is. Arguments: the ``BenchRuntime``,
    the tap."""
    served_face: Callable[[Any, str], Any] | None = None
    """Makes the face of a wire of a bench that is served; None: there is none. Arguments: the
    ``hil.testing.ServedBench``, the wire's name."""


@dataclass(frozen=True, eq=False)
class WireKind:
    """Wires of a bus. They stand in a configuration under ``key``, each under a name of its own."""

    key: str
    about: str
    """Description of the key in schema and reference."""
    model: Callable[[], type[Any]]
    """Answers the pydantic model of a wire. It has ``taps``, a mapping of names to models with ``port``, and
    ``members()``, the names of the devices that are on it."""
    findings: Callable[[Raw, Mapping[str, Any], Collection[str]], Iterable[Any]]
    """Finds what is wrong with the wires of a whole configuration, each a ``hil.config.document.Finding``.
    Arguments: the configuration, the ``ProfileInfo`` of each device, the names of the real boards."""
    fault_places: Callable[[str, Raw, Mapping[str, Any]], Mapping[str, Collection[str]]]
    """Finds where faults may be: targets of a wire, itself and its stations, with their kinds (keys of
    ``TARGETS``). Arguments: the wire's name, the wire, the ``ProfileInfo`` of each device."""
    info: WireInfo
    """Reports on them: tables, metrics, kinds of problems."""
    add: Callable[[Any, Any, Any], None]
    """Puts the wires, with what is on them, into a bench whose devices are there. Arguments: the
    ``BenchRuntime``, the ``BenchConfig``, the ``Catalogue``."""
    kit: FaceKind | None = None
    read: ReadFiles | None = None
    """Reads the files that wires name, before they are checked; None: they name none."""


@dataclass(frozen=True, eq=False)
class SegmentKind:
    """Segments: wires that nodes of several kinds are on. Their keys in a configuration are hil's own."""

    info: WireInfo
    make: "Callable[[Clock, Framing, LineFormat, str], Segment]"
    """Makes a segment without stations, on which things happen at times of the clock. Last argument: its
    name."""


@dataclass(frozen=True, eq=False)
class NodeLine:
    """Segment that nodes are put on. ``group``: the ``Group`` of the bench whose time it has; ``baud``: its
    speed; ``boards``: the ``Profile`` of each board; ``version``: hil's, which nodes may tell."""

    segment: "Segment"
    group: Any
    baud: int
    boards: Mapping[str, Any]
    version: str


@dataclass(frozen=True, eq=False)
class NodeKind:
    """Nodes of a protocol on segments: cards of axes, stations of their own. They stand in a segment of a
    configuration under ``key``, and are called after their axes, ``axis.key``."""

    key: str
    about: str
    """Description of the key in schema and reference."""
    model: Callable[[], type[Any]]
    """Answers the pydantic model of what stands under the key."""
    axes_key: str
    """Key of the model with a mapping of axes, each of which has a node."""
    findings: Callable[[Raw, Mapping[str, Any], Collection[str]], Iterable[Any]]
    """Finds what is wrong with the nodes of all segments, as ``WireKind.findings``. The first argument are
    the segments."""
    framing: "Callable[[LineFormat], Framing]"
    """Answers the framing of its packets on a line of this format, always the same object."""
    add: Callable[[Any, Any, NodeLine], None]
    """Puts the nodes of a segment on it, in the order of the configuration. Arguments: the ``BenchRuntime``,
    what stands under the key, the segment."""
    has_other_formats: bool = False
    """True if a line whose format is not 8N1, on which no board can be, has packets of this protocol."""
    fault_target: str | None = None
    """Kind of target of its own faults, a key of ``TARGETS``."""


class DriveAddress(Protocol):
    """Address of a real drive, as its kind reads it. ``str(address)`` says it in words."""

    @property
    def place(self) -> Any:
        """Line or bus that it is on, shared with other drives: equal for all of them. ``place.where`` is the
        key that no two places share."""

    @property
    def number(self) -> int:
        """Number of the drive at its place."""


@dataclass(frozen=True, eq=False)
class DriveOption:
    """Key of a device's mapping that only one kind of real drive has."""

    about: str
    """Description of the key in schema and reference."""
    model: Callable[[], type[Any]]
    """Answers the pydantic model of what stands under the key."""
    of_others: str
    """Reason why other real boards have no such key, and why twins have none."""
    of_twins: str


@dataclass(frozen=True, eq=False)
class DriveKind:
    """Real drives on a bus, each at an address ``scheme+way://...`` under a device's ``at``."""

    protocol: str
    """Protocol in words, as in ``CANopen``."""
    scheme: str
    """Beginning of the scheme of an address."""
    over: str
    """Bus that one is reached over, in words."""
    about: str
    """Text about its addresses, for the description of ``at``."""
    example: str
    line: str
    """Word for a place, as ``line`` or ``bus``, and for a drive's number there, as ``unit`` or ``node``."""
    number: str
    examples: Callable[[], Iterable[str]]
    """Answers an address of each form."""
    address: Callable[[str], DriveAddress]
    """Reads an address. Raises AddressRefused: it cannot be used."""
    place_differs: Callable[[Any, DriveAddress, DriveAddress], tuple[str, str] | None]
    """Says what two drives at one place must have alike, and have not: the rest of a sentence that begins
    with the first one's name, and the remedy; None: nothing. Arguments: the name, the two addresses."""
    make: Callable[[str, DriveAddress, Any, Any, Any, Callable[[], int]], Any]
    """Makes the control of a drive (``hil.drives.drive_control.DriveControl``). Arguments: its name, its
    address, the ``DeviceConfig``, its map of registers or None, the ``DrivePace``, the simulated time."""
    profile_drive: str | None = None
    """Word of profiles whose real boards are such drives, ``drive`` of a ``profile.yaml``; None: those with a
    ``map``."""
    keys: Mapping[str, DriveOption] = field(default_factory=dict)
    no_keys: Mapping[str, str] = field(default_factory=dict)
    """Reasons why it has none of other kinds' keys, by the key."""
    alike: Mapping[str, str] = field(default_factory=dict)
    """Keys that all drives at one place have alike, each with the remedy."""


@dataclass(frozen=True, eq=False)
class MapKind:
    """Maps of a board's own registers, ``map`` of a ``profile.yaml`` and of a device."""

    about: str
    """Description of the key in schema and reference."""
    model: Callable[[], type[Any]]
    """Answers the pydantic model of a map."""
    findings: Callable[[Any, Any, Collection[str] | None], Iterable[Any]]
    """Finds what is wrong with a map in a document. Arguments: the ``Document``, the path of keys to the map,
    the names that its parameters may have or None for any."""
    read: Callable[[str, str, Collection[str] | None], Any]
    """Reads the text of a file, which it answers as the model. Arguments: the text, the file's name, the
    names. Raises ConfigError: with all problems."""
    registers: Callable[[Any], Mapping[str, Any]]
    """Answers the registers of an axis, of its own map or of the one that all axes have, for people and
    programs. Argument: its ``DeviceInfo``."""
    own_map: Callable[[Any], Any]
    """Makes ``DeviceInfo.own_map`` of a model. Its ``values`` are by name."""


class FrameDescription(NamedTuple):
    """Frame of a capture in words. ``say`` makes them, in the frames' order, where they are wanted at all."""

    say: Callable[[], str]
    error: str = ""
    """Error on the wire, which stands in place of a frame; empty: it is a frame."""
    data: bytes = b""
    number: int | None = None
    """Its identifier."""
    fields: "Callable[[], Fields]" = tuple
    """Makes its fields, behind ``say``; bytes are those of ``data``."""


LoggedFrame = tuple[int, str, Any]
"""Frame of a log: nanoseconds since 1970 or by the writer's clock, the wire, the frame as its bus has it."""


@dataclass(frozen=True, eq=False)
class LogKind:
    """Frames in captures, and logs of them as other programs have them. ``Record``, ``Interface`` and
    ``CaptureError`` are those of ``hil.wire.pcapng``."""

    wire: str
    """Words for a wire in errors, as in "CAN bus"."""
    about: str
    """Words for a log, with the formats that there are."""
    endings: Collection[str]
    """Ends of the names of such files, as in ``.log``: one for each format."""
    looks: Callable[[bytes], str]
    """Answers the ending of the logs that a file is like by its first bytes; empty: none."""
    read: Callable[[str, bytes, Any], Iterator[LoggedFrame]]
    """Reads a log. Arguments: the ending, the content, the ``LeftOut``. Raises CaptureError: after all that
    can be read."""
    read_lines: Callable[[str, Iterable[str], Any], Iterator[LoggedFrame] | None]
    """Reads the lines of a log as they come, as ``read``; None: such a log can be read as a whole only."""
    writer: Callable[[str, BinaryIO], Any]
    """Begins a log. Arguments: the ending, the file, which is open. What it answers has ``write(records)``,
    which raises CaptureError, and ``close()``, which closes the file too."""
    has: Callable[[Any], bool]
    """Says of an ``Interface`` if its records are frames of this bus."""
    unpack: Callable[[bytes], Any]
    """Answers the frame of a record. Raises ValueError: it is none."""
    names: Callable[[Iterable[str], Callable[[str], None]], Any]
    """Reads dictionaries of names: the values of ``hil decode --eds``. The second argument says what is left
    out of them. Raises ValueError: ``str(error)`` says which cannot be read, and why."""
    words: Callable[[Any], Callable[[Any], FrameDescription]]
    """Makes what puts the frames of one wire into words. Argument: what ``names`` answers, or None."""
    dissectors: Sequence[str] = ()
    """Options of Wireshark, by which it dissects what is in the frames."""


@dataclass(frozen=True, eq=False)
class BusKind:
    """Kind of bus: ``BUS`` of ``bus_kind.py`` in its folder.

    Most benches have no such bus, so the functions of the parts import what they need when they are called.
    """

    wires: WireKind | None = None
    """Its own wires; None: its stations are on wires of another bus."""
    segments: SegmentKind | None = None
    nodes: NodeKind | None = None
    drives: DriveKind | None = None
    maps: MapKind | None = None
    logs: Callable[[], LogKind] | None = None
    """Answers its frames in captures; None: they are packets on lines, which their framing describes."""
    sections: tuple[tuple[str, str], ...] = ()
    """Sections of the reference: a heading or a sentence, and the model whose keys follow."""
    reference: "Callable[[Iterable[DeviceInfo]], str] | None" = None
    """Writes more of the reference, which stands at its end, Markdown. Argument: a twin of each kind of board
    that has one axis."""
