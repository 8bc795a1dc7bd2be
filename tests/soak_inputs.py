"""Random inputs for the mixed soak: what clients type, ask, break and run. All chance is the caller's."""

import json
from collections.abc import Mapping
from random import Random
from typing import Any

from device_profiles.sac.packet import encode, frame
from hil.compose.find import find_boards
from hil.vocab.faults import TIMING, FaultKind
from hil.vocab.parameters import Parameter
from hil.vocab.verbs import COMMON, Verb

SERVO_LINES = (
    *("x", "v", "t", "h", "y", "y", "n", "s", "d", "p", "p", "e", "m", "r{}\n", "r{}\n", "r\n", "w", "q"),
    *("kpp14.5\nq", "kvi0.002\nq", "kop1.7\n", "kq", "xyr{}\n", "vyr{}\n", "a", "j", "c", "g"),
)
STEPPER_LINES = (
    *("m{}v150", "m-{}v80a500d500", "mv60", "xm{}", "x1", "v{}", "a900", "d900", "vd", "ls1lf3ln2la", "l"),
    *(
        "S",
        "s",
        "N",
        "n",
        "y",
        "q",
        "qs",
        "qr",
        "qc",
        "q2",
        "z",
        "g",
        "cf",
        "cc",
        "b",
        "qp",
        "u6",
        "!",
        "$H0",
    ),
    *("$R", "$CM{}", "$U", "$V", "$O1", "86m{}", "85q", "0m{}", "86 hello", "\\ and back", "t500000", "p"),
)
ARM_LINES = (
    *("POWER on", "ENABLE", "ENABLE", "DISABLE", "HELP", "nonsense", "STATUS", "VERSION", "?"),
    *("MOVETO {} 1000", "MOVETO 0 10 {} 0 0 0 0 500", "LED on", "CALIB", "STOP"),
)
PINS = ("D0", "D1", "D2", "D3", "sync", "Estop", "RST", "EnA", "EnB", "nothing")
SET_FIELDS = ("load_torque_Nm", "diaagc", "errfl", "position_deg")
ODD: tuple[Any, ...] = (None, "", -1, 1e308, "nonsense", [], {}, True)
"""Values that no parameter should have."""
MS = 1_000_000
LONGEST_S = 5.0


def typed(random: Random, profile: str) -> bytes:
    """Input for a board's terminal: commands, now and then nonsense or much too much."""
    chance = random.random()
    if chance < 0.08:
        return random.randbytes(random.randint(1, 80))
    line = random.choice({"mechaduino": SERVO_LINES, "walter": ARM_LINES}.get(profile, STEPPER_LINES))
    text = line.format(random.choice((0, 1, 7, 90, 200, 3000))).encode()
    if profile != "mechaduino":
        text += random.choice((b"\r", b"\r", b"\r\n", b"\n", b""))
    return text * random.choice((1, 1, 1, 1, 1, 2, 10)) if chance < 0.99 else text * random.randint(10, 300)


def on_wire(random: Random) -> bytes:
    """Input for a tap: packets, damaged ones, answers, nonsense."""
    chance = random.random()
    if chance < 0.1:
        return random.randbytes(random.randint(1, 60))
    destination = random.choice((85, 85, 85, 86, 87, 0, 1, 200))
    data = random.choice((typed(random, "sac")[:40], b"\x06", b"\x15", b" text", b"m10", b"vd"))
    data = bytes(byte for byte in data if byte not in (0, 2, 3, 10, 13))
    raw = encode(destination, random.choice((1, 4, 85, 86)), data, crc=random.random() < 0.8)
    if chance < 0.2:
        raw = raw[: random.randint(1, len(raw))]
    if chance > 0.9:
        raw = frame(destination, 1, b"m1\x02" + data, True)
    return raw * random.choice((1, 1, 1, 2, 8))


def bursts(random: Random) -> list[list[Any]]:
    """Rows for the verb ``play``."""
    at_ns, rows = 0, []
    for _ in range(random.randint(0, 8)):
        at_ns += random.choice((0, 1, 100_000, 5 * MS, 300 * MS))
        rows.append([at_ns, on_wire(random).hex()])
    return rows


def train(random: Random) -> list[list[Any]]:
    """Rows for the verb ``drive``."""
    at_ns, rows = 0, []
    for _ in range(random.randint(0, 4)):
        steps = random.choice((0, 1, 100, 3000))
        long_ns = steps * random.choice((2, 10_000, 50_000, 1_000_000))
        level = random.randint(0, 1)
        rows.append([at_ns, "step" if steps else random.choice(("dir", "enable")), level, steps, long_ns])
        at_ns += long_ns + random.choice((0, 1, 3 * MS))
    return rows


def verbs_of(profile: str) -> tuple[Verb, ...]:
    """Verbs that can be asked of a twin."""
    return (*find_boards()[profile].verbs, *COMMON)


def verb_parameters(random: Random, verb: Verb, profile: str) -> dict[str, Any]:
    """Random parameters of a verb, mostly as the table asks for them."""
    given: dict[str, Any] = {}
    for parameter in verb.parameters:
        if random.random() < 0.5 and (parameter.is_optional or parameter.default is not None):
            continue
        if parameter.name == "text":
            given["text"] = typed(random, profile).decode("latin-1")[:4096]
        elif parameter.name == "pin":
            given["pin"] = random.choice(PINS)
        else:
            given[parameter.name] = _value(random, parameter)
    return given


def fault_parameters(random: Random, kind: FaultKind) -> dict[str, Any]:
    """Random parameters of a fault, with times that fit a soak: some begin later, most end by themselves."""
    given: dict[str, Any] = {}
    for parameter in kind.parameters:
        if parameter.default is None or random.random() < 0.7:
            given[parameter.name] = _value(random, parameter)
    if "rate" in given and random.random() < 0.7:
        given["rate"] = random.choice((0.0001, 0.003, 0.1))
    if kind.name == "shaft_load" and random.random() < 0.9:
        given["torque_Nm"] = random.choice((-0.3, -0.05, 0.01, 0.3))  # several of them each motor takes
    if kind.name == "node_babble":
        given["bytes"] = float(random.choice((1, 5, 20, 100, 300)))
        given["every_ms"] = random.choice((2.0, 5.0, 7.0, 33.3, 100.0))
    for time in TIMING:
        if random.random() < 0.6:
            given[time.name] = round(random.uniform(0, LONGEST_S), random.choice((1, 3, 9)))
    return given


def _value(random: Random, parameter: Parameter) -> Any:
    if random.random() < 0.02:
        return random.choice(ODD)
    if parameter.choices:
        return random.choice(parameter.choices)
    if parameter.is_text:
        return "text"
    low, high = parameter.minimum, parameter.maximum
    near = random.choice((0.01, 1.0, 30.0, 400.0))
    value = random.choice(
        (random.uniform(low, high), random.gauss(max(low, min(high, 0.0)), near), low, high)
    )
    value = max(low, min(high, value))
    return round(value) if parameter.is_whole else value


def run_document(random: Random, name: str, axes: list[str]) -> str:
    """A run of a few seconds over some of the axes; not each can be carried out."""
    chosen = random.sample(axes, random.randint(1, min(3, len(axes))))

    def angles() -> dict[str, float]:
        some = random.sample(chosen, random.randint(1, len(chosen)))
        return {axis: round(random.gauss(0, 90), 2) for axis in some}

    def step() -> Mapping[str, Any]:
        match random.choice(
            ("move", "move", "move_by", "line", "line_by", "spline", "dwell", "pins", "wait")
        ):
            case "dwell":
                return {"dwell_s": round(random.uniform(0, 0.5), 3)}
            case "pins":
                return {"pins": {f"{random.choice(chosen)}.{random.choice(PINS)}": random.randint(0, 1)}}
            case "wait":
                until = {"axis": chosen[0], "field": "position_deg", "above": 0.0, "timeout_s": 0.5}
                return {"wait_until": until}
            case "spline":
                return {"spline": [{chosen[0]: float(random.randint(-90, 90))} for _ in range(3)]}
            case kind:
                in_s = {"in_s": round(random.uniform(0.2, 2), 3)} if random.random() < 0.3 else {}
                return {kind: angles()} | in_s

    rules = {"velocity_rpm": random.choice((60.0, 240.0)), "acceleration_rpm_per_s": 3000.0}
    if random.random() < 0.3:
        rules["following_error_deg"] = 20.0
    return json.dumps(
        {
            "run": name,
            "axes": dict.fromkeys(chosen, rules),
            "profile": random.choice(("trapezoid", "s_curve")),
            "on_fault": random.choice(("grace", "prejudice")),
            "start_in_s": random.choice((0.0, 0.0, 0.3)),
            "steps": [step() for _ in range(random.randint(1, 5))],
        }
    )
