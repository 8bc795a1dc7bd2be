"""Random benches for the mixed soak: all that a configuration can say, and each of them valid."""

from random import Random
from typing import Any

from soak_inputs import fault_parameters

from hil.compose import find_catalogue
from hil.config import ConfigError, from_dict
from hil.core.axis_kind import CLOCK_IN, CLOCK_OUT
from hil.core.kinds import KINDS
from hil.vocab.faults import FAULT_KINDS

Config = dict[str, Any]
CATALOGUE = find_catalogue()
LINE = "line"
"""Name of the tap at which a real line is, with an adapter that echoes."""
PORTS = ("pty", "pty", "tcp", "rfc2217")
BAUDS = (9600, 19200, 38400, 57600, 115200)
LOADS: tuple[dict[str, Any], ...] = (
    {"kind": "constant", "torque_Nm": 0.02},
    {"kind": "spring", "stiffness_Nm_per_rad": 0.01, "centre_deg": 30.0},
    {"kind": "pendulum", "mass_kg": 0.1, "length_m": 0.05},
    {"kind": "lead_screw", "lead_mm": 2.0, "mass_kg": 1.0, "gravity": "negative"},
    {"kind": "end_stops", "min_deg": -400.0, "max_deg": 400.0},
)


def random_bench(random: Random, name: str, first_port: int, adapter: str = "/dev/null") -> Config:
    """A configuration as plain values. The three TCP ports are the machine's choice, as the device of an
    adapter is; the rest is chance."""
    devices = {f"m{n}": _servo(random) for n in range(1, random.randint(1, 3) + 1)}
    steppers = [f"s{n}" for n in range(1, random.randint(0, 5) + 1)]
    devices |= {stepper: _stepper(random) for stepper in steppers}
    config: Config = {
        "bench": name,
        "speed": 1,
        "seed": random.randrange(1000),
        "rate_hz": random.choice((1000, 1000, 250, 2000)),
        "devices": devices,
        "segments": _segments(random, steppers, adapter),
        "wires": [],
        "faults": [],
        "bridges": {
            "metrics": {"listen": f"127.0.0.1:{first_port}"},
            "zenoh": {
                "listen": [f"tcp/127.0.0.1:{first_port + 1}"],
                "state_hz": random.choice((0.7, 7.0, 10.0, 30.0)),
                "packed_hz": random.choice((10.0, 77.7, 100.0, 300.0)),
            },
            "web": {"listen": first_port + 2},
        },
    }
    for _ in range(random.choice((0, 0, 1, 2, 4))):
        _keep_if_valid(config, "wires", _wire(random, dict(devices)))
    if random.random() < 0.5:
        devices["arm"] = {"profile": "walter"}
    if random.random() < 0.6:
        devices["c1"] = {"profile": "canopen_drive"}
        taps = {"slcan0": {"port": random.choice(PORTS[:3])}}
        config["can"] = {"can0": {"bit_rate": 500_000, "nodes": {"c1": 5}, "taps": taps}}
    for _ in range(random.choice((0, 0, 1, 3))):
        _keep_if_valid(config, "faults", _fault(random, config))
    return config


def targets(config: Config) -> list[str]:
    """Names that a fault can be on, whether the kind fits or not."""
    taps = [f"{wire}.{tap}" for wire, segment in config["segments"].items() for tap in segment["taps"]]
    networks = [f"{name}.network" for name, each in config["devices"].items() if each["profile"] == "sac"]
    return [*config["devices"], *networks, *taps, *config["segments"]]


def changed(random: Random, config: Config) -> Config:
    """Another configuration, as somebody might write it before a reload."""
    devices = dict(config["devices"])
    name = random.choice(list(devices))
    what = random.randrange(3)
    if what == 0 and len(devices) > 1:
        del devices[name]
    elif what == 1:
        devices["extra"] = _servo(random)
    else:
        devices[name] = devices[name] | {"baud": random.choice(BAUDS)}
    return config | {"devices": devices}


def _servo(random: Random) -> Config:
    table = random.choice(("identity", "identity", "identity", "stored", "empty"))
    device: Config = {"profile": "mechaduino", "flash": {"table": table}}
    if random.random() < 0.3:
        device["baud"] = random.choice(BAUDS)
    if random.random() < 0.3:
        device["hardware"] = "0.2"
    return device | _of_any(random)


def _stepper(random: Random) -> Config:
    device: Config = {"profile": "sac"}
    if random.random() < 0.2:
        device["network"] = random.choice(PORTS)
    return device | _of_any(random)


def _of_any(random: Random) -> Config:
    device: Config = {"port": random.choice(PORTS), "axis": {"start_deg": random.choice((0.0, 6.3, 40.0))}}
    if random.random() < 0.4:
        device["plant"] = "full"
        if random.random() < 0.5:
            device["load"] = random.choice(LOADS)
    if random.random() < 0.4:
        device["setpoints"] = {
            "timeout_ms": random.choice((20.0, 150.0, 1000.0)),
            "policy": random.choice(("hold", "decelerate", "torque_off")),
        }
    return device


def axes(config: Config) -> list[str]:
    """Addresses of axes for runs."""
    joints = ["arm.forearm", "arm.wrist"]
    return [axis for name in config["devices"] for axis in (joints if name == "arm" else [name])]


def _segments(random: Random, steppers: list[str], adapter: str) -> Config:
    """Random wires, at most two; each stepper is on one of them or on none."""
    segments: Config = {}
    rest = list(steppers)
    for number in range(random.choice((0, 1, 1, 1, 2))):
        stations = rest[: random.randint(0, len(rest))]
        rest = rest[len(stations) :]
        taps = {
            tap: {
                "port": random.choice(PORTS),
                "listen": random.random() < 0.2,
                "echo": random.random() < 0.3,
            }
            for tap in ("a", "b", "c")[: random.randint(1, 3)]
        }
        baud = random.choice((38400, 38400, 38400, 9600))
        if number == 0 and random.random() < 0.5:
            taps[LINE] = {"port": {"kind": "serial", "url": adapter, "baud": baud}}
        segments[f"bus{number}"] = {"stations": stations, "taps": taps, "baud": baud}
    return segments


def _wire(random: Random, devices: Config) -> Config:
    ends = []
    for which in ("from", "to"):
        name = random.choice(list(devices))
        pins = KINDS[devices[name]["profile"]]
        choice = [*pins.outputs, CLOCK_OUT] if which == "from" else [*pins.inputs, CLOCK_IN]
        ends.append(f"{name}.{random.choice(choice)}")
    return dict(zip(("from", "to"), ends, strict=True))


def _fault(random: Random, config: Config) -> Config:
    kind = random.choice(list(FAULT_KINDS.values()))
    return {"fault": kind.name, "target": random.choice(targets(config))} | fault_parameters(random, kind)


def _keep_if_valid(config: Config, key: str, entry: Config) -> None:
    """Add to a list what the check of configurations has nothing against."""
    config[key].append(entry)
    try:
        from_dict(config, CATALOGUE)
    except ConfigError:
        config[key].pop()
