"""Words for people about faults: groups of kinds, how each shows, and an example that can be typed."""

from collections.abc import Mapping

from hil.vocab.faults import (
    BUS_PART,
    CAN_NODE,
    DEVICE,
    FIELD_OFFSET,
    FIELD_STUCK,
    LINE,
    MODBUS_NODE,
    ON_LINE,
    OWN_FIELD,
    PIN_STUCK,
    PORT,
    PROCESSOR,
    SEGMENT,
    SERVO,
    SHAFT,
    STATION,
    SUPPLIED,
    SWITCH,
    TWIN_PORT,
    FaultKind,
)

GROUPS: Mapping[str, str] = {
    "byte": "bytes of a port",
    "host": "the program at a port",
    "packet": "packets of a line",
    "modbus": "Modbus",
    "wire": "wires and drivers of a line or CAN bus",
    "node": "stations, nodes and whole boards",
    "chip": "the processor of a board",
    "motor": "motor, driver and shaft",
    "encoder": "encoder and joint",
    "switch": "switches along an axis",
    "field": "fields of a board's own",
}
"""Groups of kinds in their order, each with what is in it."""
_BY_TARGET = {SERVO: "encoder", BUS_PART: "encoder", SWITCH: "switch", OWN_FIELD: "field"}
"""Groups of the layer of physics, by target; of all others the motor's."""


def group_of(kind: FaultKind) -> str:
    """Name of a kind's group: its layer, or a part of the layer of physics."""
    return _BY_TARGET.get(kind.target, "motor") if kind.layer == "physics" else kind.layer


SIGNS: Mapping[str, str] = {
    "byte_flip": "characters of commands and answers are wrong; packets fail their CRC",
    "byte_drop": "answers have gaps, commands are not understood or wait for their end",
    "byte_duplicate": "characters come double; packets are too long",
    "byte_delay": "answers are late and in bursts; time-outs of the program at the port fire",
    "host_stop_reading": "dropped bytes of the port grow in `hil status`; answers are missing afterwards",
    "host_close": "the board gets nothing, and nothing comes from it",
    "packet_bad_crc": "`hil decode` marks packets as damaged; receivers leave them without an answer",
    "packet_no_ack": "the sender repeats its packet, then gives up",
    "packet_nak": "the sender repeats, or reports that the station refused",
    "modbus_no_answer": "the master times out, and the command was carried out all the same",
    "modbus_exception": "the master gets an exception with this code, and the register keeps its value",
    "modbus_late": "the master times out, and takes a late answer for that of its next request, if it can",
    "modbus_wrong_unit": "the master drops the answer and times out",
    "wire_noise": "damaged packets, error frames and repetitions; counters of the line in `hil status` grow",
    "wire_cut": "the station hears nothing and is not heard; its master times out",
    "wire_swapped": "all that the station sends and hears is inverted: framing errors",
    "driver_stuck": "nobody else can be heard on the line: collisions, damaged packets",
    "driver_late": "the first bytes of an answer collide with the end of the request",
    "bit_rate_wrong": "error frames as soon as the node takes part; it or the others go bus-off",
    "bus_off": "the node sends no frames; its heartbeat is missing, an emergency may follow",
    "node_babble": "collisions on a segment, a full bus and late frames on CAN",
    "node_clash": "two acknowledgements collide; packets to the address seem to be lost",
    "node_reset": "the board greets again; positions and what was not in its memory are lost",
    "node_brown_out": "no answer, no torque; at the end the board starts as after a power-up",
    "node_hang": "no answer, while the motor keeps its last command",
    "chip_clock_off": "its times and its baud are off; from some 4 % on characters are wrong",
    PIN_STUCK: "the sketch reads one level, and what is wired to an output sees no change",
    "chip_bit_flip": "a variable, an instruction or a kept value is another one",
    "chip_brown_out": "the sketch starts again, with part of its old variables",
    "chip_eeprom_worn": "values that the sketch keeps are the old ones after a reset",
    "shaft_load": "a servo's error and current grow, a stepper lags and loses steps beyond what it holds",
    "shaft_jam": "a servo pushes at its limit and stands, a stepper loses steps: a warning in `hil log`",
    "steps_lost": "the board counts another angle than the shaft has: `hil status` shows both",
    "phase_open": "half the torque; a stepper swings and loses steps, a servo is rough",
    "phase_swapped": "a stepper turns the other way; a servo runs away from its set-point",
    "motor_unplugged": "the shaft turns freely; a servo's error grows, a stepper counts and stands",
    "motor_power_off": "commands are answered as always, and the shaft does not move",
    "thermal_trip": "no torque until the fault ends; a driver that tells it says that it is too hot",
    "supply_sag": "less torque at speed: fast moves lag or lose steps",
    "encoder_slip": "the board's angle is off by so much; a servo moves to correct it",
    "encoder_noise": "a servo is loud and hot, its angle scatters",
    "encoder_freeze": "a servo runs away or pushes at its limit: its angle does not change",
    "encoder_disconnect": "the angle jumps to the last count, or an error of the encoder is told",
    "bus_no_answer": "the firmware takes an old angle, or tells that a joint does not answer",
    "switch_stuck": "homing never ends, or ends where it begins",
    "switch_wire_broken": "the switch is never seen; homing runs to the end of the axis",
    "switch_moved": "homing ends at another place: all positions are off by so much",
    FIELD_STUCK: "the value does not follow what is set or written",
    FIELD_OFFSET: "the firmware decides by a wrong value: `hil status` has the true one",
}
"""Signs of each kind at the bench, for people."""


def shown_by(kind: FaultKind) -> str:
    """Signs of a kind at the bench, in a sentence; empty: nobody has written them."""
    return SIGNS.get(kind.name, "")


_PLACES = {
    DEVICE: "m1",
    PORT: "m1",
    TWIN_PORT: "m1",
    STATION: "s1.network",
    SEGMENT: "bus0",
    MODBUS_NODE: "m1.modbus",
    LINE: "bus0",
    ON_LINE: "s1.network",
    CAN_NODE: "m1.canopen",
    SERVO: "m1",
    SHAFT: "m1",
    SUPPLIED: "m1",
    PROCESSOR: "uno",
    OWN_FIELD: "feeder",
    SWITCH: "s1.home",
    BUS_PART: "arm.elbow",
}
_VALUES = {
    "byte_flip": "rate=0.001",
    "byte_drop": "rate=0.01",
    "byte_duplicate": "rate=0.01",
    "byte_delay": "rate=0.01 delay_ms=50",
    "wire_noise": "rate=0.0001",
    "bit_rate_wrong": "bit_rate=250000",
    "node_clash": "address=5",
    PIN_STUCK: "pin=13 level=0",
    "chip_bit_flip": "memory=sram address=256",
    "shaft_load": "torque_Nm=0.05",
    "supply_sag": "supply_V=9",
    "encoder_slip": "counts=200",
    "encoder_noise": "counts=5",
    "switch_moved": "by_deg=10",
    FIELD_STUCK: "field=temperature_C",
    FIELD_OFFSET: "field=temperature_C offset=5",
}


def example(kind: FaultKind, place: str = "") -> str:
    """Command that injects a fault of a kind; for a second, if it lasts. ``place``: where; empty: a usual
    place of such a fault."""
    values = [_VALUES[kind.name]] if kind.name in _VALUES else []
    timing = [] if kind.is_once else ["for_s=1"]
    return " ".join(["hil fault inject", kind.name, place or _PLACES[kind.target], *values, *timing])
