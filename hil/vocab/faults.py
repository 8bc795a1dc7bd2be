"""Faults that can be injected, in one table that configuration, commands, kit and reference use.

A target is an address (``hil.vocab.address``): of a device (``s1``), one of its axes (``arm.elbow``) or ports
(``s1.network``), of a node (``m1.canopen``), a switch (``s1.home``), a tap (``bus0.master``), a segment
(``bus0``) or a CAN bus (``can0``). The table says what a kind can be on.
"""

from collections.abc import Mapping
from dataclasses import field

from hil.vocab.late_dataclass import dataclass
from hil.vocab.parameters import Parameter
from hil.vocab.verbs import VerbRefused

DEVICE, PORT, TWIN_PORT, STATION, SEGMENT = "device", "port", "twin_port", "station", "segment"
SERVO, SHAFT, SUPPLIED = "servo", "shaft", "supplied"
BUS_PART, PROCESSOR = "bus_part", "processor"
MODBUS_NODE, OWN_FIELD, SWITCH = "modbus_node", "own_field", "switch"
OF_AXES = frozenset({SERVO, SHAFT, BUS_PART, PROCESSOR, OWN_FIELD})
"""Targets that a kind of axis is or is not."""
LINE, ON_LINE, CAN_NODE = "line", "on_line", "can_node"
TARGETS = {
    DEVICE: "a twin",
    PORT: "a port of a twin, or a real board",
    TWIN_PORT: "a port of a twin",
    STATION: "a twin's port on a segment, a Modbus node, or a tap",
    SEGMENT: "a segment",
    MODBUS_NODE: "an axis's Modbus node",
    LINE: "a segment or a CAN bus",
    ON_LINE: "a twin's port on a segment, a Modbus or CANopen node, or a tap",
    CAN_NODE: "a CANopen node, or a tap of a CAN bus",
    SERVO: "a twin with an encoder",
    SHAFT: "a twin with a motor",
    SUPPLIED: "a twin with plant: full",
    PROCESSOR: "a twin whose processor can run a program of your own",
    OWN_FIELD: "a twin whose board has fields of its own",
    SWITCH: "a switch along an axis",
    BUS_PART: "a joint with an encoder or servo on a bus",
}
LACKS = {
    DEVICE: "is no twin",
    PORT: "has no serial port",
    TWIN_PORT: "is no port of a twin",
    STATION: "is on no segment",
    SEGMENT: "is no segment",
    MODBUS_NODE: "has no Modbus node",
    LINE: "is no segment and no CAN bus",
    ON_LINE: "is on no line",
    CAN_NODE: "is on no CAN bus",
    SERVO: "has no encoder",
    SHAFT: "has no motor",
    SUPPLIED: "has no plant: full",
    PROCESSOR: "has no processor for a program of your own",
    OWN_FIELD: "has no fields of its own",
    SWITCH: "is no switch along an axis",
    BUS_PART: "has no encoder or servo on a bus",
}
"""Words for what a place is or has not that a fault needs."""


PIN_STUCK = "chip_pin_stuck"
FIELD_STUCK, FIELD_OFFSET = "field_stuck", "field_offset"
MOST_NOISES = 16
"""Maximum number of ``wire_noise`` on one CAN bus: it draws for each bit and each of them."""
MOST_LOADS = 10
"""Maximum load, in holding torques of the motor. Two drag it along, ten leave room for knocks. More is a
wrong unit: Ncm are a hundred, mNm a thousand times too much."""
LOAD_LIMITS = f"-{MOST_LOADS} to {MOST_LOADS} times what the motor holds"


@dataclass(frozen=True)
class FaultKind:
    """Kind of fault: its layer (byte, host, packet, modbus, wire, node, chip, physics) and its target."""

    name: str
    layer: str
    target: str
    """A key of ``TARGETS``."""
    about: str
    parameters: tuple[Parameter, ...] = ()
    is_once: bool = False
    """True if the fault happens and is over at once: from then on it is not listed, unless it comes again."""

    @property
    def title(self) -> str:
        """Title for people, in a few words."""
        return _TITLES[self.name]


_BIT_RATE = Parameter("rate", "probability for each bit")
_BYTE_RATE = Parameter("rate", "probability for each byte")
_PACKET_RATE = Parameter("rate", "probability for each packet", default=1.0)
_REQUEST_RATE = Parameter("rate", "probability for each request", default=1.0)
_TOWARDS = Parameter("towards", "which way the bytes go", default="client", choices=("board", "client"))
_FIELD = Parameter("field", "which, by its name", maximum=32, is_text=True)
_SEED = Parameter("seed", "seed of its random numbers", maximum=2**53, default=0)
_DAY_S = 86_400.0
TIMING = (
    Parameter("start_s", "how long after the injection it begins", "s", 0.0, _DAY_S, 0.0),
    Parameter("for_s", "how long it lasts; 0: until it is cleared", "s", 0.0, _DAY_S, 0.0),
    Parameter(
        "every_s",
        "from one beginning to the next, until it is cleared; 0: it comes once",
        "s",
        0.0,
        _DAY_S,
        0.0,
    ),
)
"""Timing parameters of every kind, in simulated seconds."""

_KINDS = (
    FaultKind("byte_flip", "byte", PORT, "bits of bytes are inverted", (_BIT_RATE, _TOWARDS, _SEED)),
    FaultKind("byte_drop", "byte", PORT, "bytes are lost", (_BYTE_RATE, _TOWARDS, _SEED)),
    FaultKind("byte_duplicate", "byte", PORT, "bytes come twice", (_BYTE_RATE, _TOWARDS, _SEED)),
    FaultKind("byte_delay", "byte", PORT, "bytes come late, and those behind them too",
              (_BYTE_RATE, Parameter("delay_ms", "how late", "ms", 0.0, 60_000.0, 10.0), _TOWARDS, _SEED)),
    FaultKind("host_stop_reading", "host", TWIN_PORT, "no client reads: what the board sends is lost"),
    FaultKind("host_close", "host", TWIN_PORT, "the cable is out: nothing passes either way"),
    FaultKind("packet_bad_crc", "packet", STATION, "packets are sent with a wrong CRC",
              (_PACKET_RATE, _SEED)),
    FaultKind("packet_no_ack", "packet", ON_LINE, "acknowledgements are not sent", (_PACKET_RATE, _SEED)),
    FaultKind("packet_nak", "packet", STATION, "NAK is sent for ACK", (_PACKET_RATE, _SEED)),
    FaultKind("modbus_no_answer", "modbus", MODBUS_NODE, "requests are carried out and not answered",
              (_REQUEST_RATE, _SEED)),
    FaultKind("modbus_exception", "modbus", MODBUS_NODE,
              "requests are not carried out, but answered with an exception",
              (Parameter("code", "which", "", 1.0, 255.0, 6, is_whole=True), _REQUEST_RATE, _SEED)),
    FaultKind("modbus_late", "modbus", MODBUS_NODE, "answers come late; of several the latest counts",
              (Parameter("late_ms", "how late", "ms", 0.0, 60_000.0, 1000.0), _REQUEST_RATE, _SEED)),
    FaultKind("modbus_wrong_unit", "modbus", MODBUS_NODE,
              "answers have another unit's number; of several the latest counts",
              (Parameter("unit", "which; 0: the one after its own", "", 0.0, 247.0, 0, is_whole=True),
               _REQUEST_RATE, _SEED)),
    FaultKind("wire_noise", "wire", LINE, "bits on the wire are inverted, for all alike",
              (_BIT_RATE, _SEED)),
    FaultKind("wire_cut", "wire", ON_LINE, "the wire to a station or node is cut"),
    FaultKind("wire_swapped", "wire", STATION, "a station's two wires are swapped"),
    FaultKind("driver_stuck", "wire", ON_LINE,
              "a station's driver is always on; a node's holds the bus dominant"),
    FaultKind("driver_late", "wire", STATION,
              "a station's driver goes off late; of several the latest counts",
              (Parameter("late_us", "how late", "us", 0.0, 1e6, 1000.0),)),
    FaultKind("bit_rate_wrong", "wire", CAN_NODE,
              "a node has another bit rate; of several the latest counts",
              (Parameter("bit_rate", "which", "bit/s", 10_000.0, 1_000_000.0, is_whole=True),)),
    FaultKind("bus_off", "node", CAN_NODE, "a node is bus-off, once; it comes back when the bus lets it",
              is_once=True),
    FaultKind("node_babble", "node", ON_LINE,
              "a station sends nonsense, also while others send; a node the most urgent frames",
              (Parameter("bytes", "how many at a time; a node's frames have 8", "bytes", 1.0, 10_000.0, 20.0),
               Parameter("every_ms",
                         "from one time to the next, or when the last is out if that takes longer",
                         "ms", 0.1, 1e6, 100.0),
               _SEED)),
    FaultKind("node_clash", "node", SEGMENT, "another node acknowledges packets to an address",
              (Parameter("address", "its address", "", 4.0, 255.0),)),
    FaultKind("node_reset", "node", DEVICE, "the power goes and comes back, once", is_once=True),
    FaultKind("node_brown_out", "node", DEVICE,
              "board and motor have no power, also after a reset; afterwards the board starts again"),
    FaultKind("node_hang", "node", DEVICE,
              "the main program stands still, also after a reset; motor and interrupts go on"),
    FaultKind("chip_clock_off", "chip", PROCESSOR,
              "the processor's clock is fast by so much; of several the latest counts",
              (Parameter("percent", "by how much; negative: slow", "%", -20.0, 20.0, 2.0),)),
    FaultKind(PIN_STUCK, "chip", PROCESSOR, "a pin is stuck, for what is wired to it and as an input",
              (Parameter("pin", "which; 14 to 19 are A0 to A5", "", 0.0, 19.0, is_whole=True),
               Parameter("level", "at what", "", 0.0, 1.0, 0, is_whole=True))),
    FaultKind("chip_bit_flip", "chip", PROCESSOR, "a bit of a memory is inverted, once",
              (Parameter("memory", "which", default="sram", choices=("sram", "flash", "eeprom")),
               Parameter("address", "of the byte, in the memory's own addresses; SRAM begins at 256", "",
                         0.0, 32767.0, is_whole=True),
               Parameter("bit", "which", "", 0.0, 7.0, 0, is_whole=True)),
              is_once=True),
    FaultKind("chip_brown_out", "chip", PROCESSOR,
              "the supply of the processor sags, once: it resets, and SRAM keeps a part of its bytes",
              (Parameter("kept_pct", "part of the bytes that stay; others have chance content", "%",
                         0.0, 100.0, 100.0), _SEED),
              is_once=True),
    FaultKind("chip_eeprom_worn", "chip", PROCESSOR,
              "bytes of the EEPROM that a program writes keep what they had"),
    FaultKind("shaft_load", "physics", SHAFT,
              "a torque on the shaft beside the load that was set; several add up, those that push the same"
              " way to the limit at most",
              (Parameter("torque_Nm", "positive towards larger counts", "Nm", -1e3, 1e3,
                         limits=LOAD_LIMITS),)),
    FaultKind("shaft_jam", "physics", SHAFT, "the shaft is clamped where it is"),
    FaultKind("steps_lost", "physics", SHAFT,
              "the shaft is turned once, as by hand; 7.2 deg are four full steps of a motor with 200",
              (Parameter("turn_deg", "how far, positive towards larger counts", "deg", -36e4, 36e4, -7.2),),
              is_once=True),
    FaultKind("phase_open", "physics", SHAFT, "a coil's wire is broken",
              (Parameter("coil", "which", default="A", choices=("A", "B")),)),
    FaultKind("phase_swapped", "physics", SHAFT,
              "a coil's two wires are swapped: the motor turns the other way",
              (Parameter("coil", "which", default="A", choices=("A", "B")),)),
    FaultKind("motor_unplugged", "physics", SHAFT, "the motor is not connected: no current in either coil"),
    FaultKind("motor_power_off", "physics", SHAFT,
              "the motor's supply is off, while the logic lives, as from a USB"),
    FaultKind("thermal_trip", "physics", SHAFT, "the driver is too hot: no current in either coil"),
    FaultKind("supply_sag", "physics", SUPPLIED,
              "the supply has another voltage; of several the latest counts",
              (Parameter("supply_V", "what is left", "V", 0.0, 100.0),)),
    FaultKind("encoder_slip", "physics", SERVO, "the magnet has slipped on the shaft; several add up",
              (Parameter("counts", "by how much, of 16384 in a turn", "counts", -8192.0, 8191.0),)),
    FaultKind("encoder_noise", "physics", SERVO, "readings scatter; of several the latest counts",
              (Parameter("counts", "standard deviation", "counts", 0.0, 1000.0), _SEED)),
    FaultKind("encoder_freeze", "physics", SERVO, "the encoder stays at its count"),
    FaultKind("encoder_disconnect", "physics", SERVO,
              "the encoder's line is open: all ones; one on a bus, or a servo, does not answer"),
    FaultKind("bus_no_answer", "physics", BUS_PART,
              "a joint's encoder or servo does not answer on its bus; of several the latest counts",
              (Parameter("rate", "probability for each reading", default=1.0), _SEED)),
    FaultKind("switch_stuck", "physics", SWITCH,
              "its contact stays open or closed; of several the latest counts",
              (Parameter("contact", "how it stays", default="open", choices=("open", "closed")),)),
    FaultKind("switch_wire_broken", "physics", SWITCH,
              "its wire is broken: the pin has the level of an open contact, even if it is stuck closed"),
    FaultKind("switch_moved", "physics", SWITCH,
              "it has another place on the axis, as after a crash; several add up",
              (Parameter("by_deg", "how far, positive towards larger angles", "deg", -36e4, 36e4),)),
    FaultKind(FIELD_STUCK, "physics", OWN_FIELD,
              "a field of the board's own stays as it is for the firmware: an input as it reads it, an output"
              " whatever it writes", (_FIELD,)),
    FaultKind(FIELD_OFFSET, "physics", OWN_FIELD,
              "the firmware reads a field of its board with an offset, within its range; several add up",
              (_FIELD, Parameter("offset", "by how much, in the field's unit", "", -1e9, 1e9))),
)  # fmt: skip
_TITLES = {
    "byte_flip": "Bits of bytes flip",
    "byte_drop": "Bytes are lost",
    "byte_duplicate": "Bytes come twice",
    "byte_delay": "Bytes come late",
    "host_stop_reading": "The program stops reading",
    "host_close": "The cable is out",
    "packet_bad_crc": "Wrong CRC",
    "packet_no_ack": "No acknowledgement",
    "packet_nak": "NAK for ACK",
    "modbus_no_answer": "No answer",
    "modbus_exception": "An exception for an answer",
    "modbus_late": "Late answers",
    "modbus_wrong_unit": "Answers of another unit",
    "wire_noise": "Noise on the wire",
    "wire_cut": "Wire cut",
    "wire_swapped": "Wires swapped",
    "driver_stuck": "Driver always on",
    "driver_late": "Driver goes off late",
    "bit_rate_wrong": "Wrong bit rate",
    "bus_off": "Bus-off",
    "node_babble": "Babbling station",
    "node_clash": "Two nodes, one address",
    "node_reset": "Power off and on",
    "node_brown_out": "No power",
    "node_hang": "The program hangs",
    "chip_clock_off": "Clock fast or slow",
    PIN_STUCK: "Pin stuck",
    "chip_bit_flip": "A bit of memory flips",
    "chip_brown_out": "The chip's supply sags",
    "chip_eeprom_worn": "EEPROM worn out",
    "shaft_load": "Load on the shaft",
    "shaft_jam": "Shaft jammed",
    "steps_lost": "Steps lost",
    "phase_open": "Coil open",
    "phase_swapped": "Coil's wires swapped",
    "motor_unplugged": "Motor not connected",
    "motor_power_off": "No motor supply",
    "thermal_trip": "Driver too hot",
    "supply_sag": "Supply sags",
    "encoder_slip": "Magnet slipped",
    "encoder_noise": "Noisy encoder",
    "encoder_freeze": "Encoder frozen",
    "encoder_disconnect": "Encoder unplugged",
    "bus_no_answer": "Joint does not answer",
    "switch_stuck": "Switch stuck",
    "switch_wire_broken": "Switch's wire broken",
    "switch_moved": "Switch moved",
    FIELD_STUCK: "Field stuck",
    FIELD_OFFSET: "Field reads wrong",
}
FAULT_KINDS: Mapping[str, FaultKind] = {kind.name: kind for kind in _KINDS}
OF_FRAMINGS = frozenset(kind.name for kind in _KINDS if kind.layer == "packet") | {"node_clash"}
"""Kinds that need packets: those that the framing of a segment can make (``hil.vocab.framing``)."""


@dataclass(frozen=True)
class Fault:
    """A fault of a kind, with all its parameters."""

    kind: str
    target: str
    parameters: Mapping[str, float | str] = field(default_factory=dict)

    @property
    def layer(self) -> str:
        return FAULT_KINDS[self.kind].layer

    def number(self, name: str) -> float:
        """Value of a parameter that is a number."""
        return float(self.parameters[name])


class FaultRefused(VerbRefused):
    """Refusal of a fault that cannot be injected or cleared: ``str(error)`` says why."""

    def __init__(self, why: str) -> None:
        super().__init__("bad_parameter", why)
