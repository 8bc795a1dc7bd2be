"""The control socket's verbs: what each needs, does and answers. Those about runs are in ``run_verbs.py``."""

import os
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from hil import __version__
from hil.config import ConfigError
from hil.core.core import octaves
from hil.core.fields import OF_KIND
from hil.live import real_boards
from hil.live.captures import Capture
from hil.live.off_loop import off_loop
from hil.live.refusals import ConfigUnreadable
from hil.net.control_client import ControlError
from hil.operations import run_verbs, segments
from hil.operations.health import health
from hil.operations.requests import (
    BURSTS,
    EDGES,
    FLAG,
    HEX,
    NAME,
    NAMES,
    NUMBER,
    OBJECT,
    TEXT,
    WHOLE,
    Kind,
)
from hil.sim.device import Device
from hil.sim.inputs import MAX_BURSTS, Bytes, Drive, Input, Pin, Play, Reset, SetField, bursts_problem
from hil.sim.settable import SURROUNDINGS, setting_problem
from hil.telemetry import DEFAULT_SIGNALS, check_signals
from hil.telemetry.sampler import MIN_INTERVAL_NS
from hil.vocab.bridges import LOCAL
from hil.vocab.firmware import MAIN, NETWORK
from hil.vocab.ports import port_label
from hil.vocab.verbs import described
from hil.wire.step_dir import MAX_ROWS, Edges, Train, train_length_ns, train_problem

if TYPE_CHECKING:
    from hil.daemon import Daemon

T = TypeVar("T")
CONTROL_VERSION = 1
WATCH_IDLE_S = 10
"""A watch that nobody asks for samples so long has ended."""
SAMPLES_AT_A_TIME = 5000


def _list(daemon: "Daemon") -> dict[str, Any]:
    devices = []
    for name, config in daemon.config.devices.items():
        if name in daemon.places.boards():
            devices.append(real_boards.listed(daemon.places.boards()[name], config))
            continue
        session = daemon.places.uarts().get(name)
        network = daemon.places.uarts().get(port_label(name, NETWORK))
        devices.append(
            {
                "device": name,
                "profile": config.profile,
                "hardware": config.hardware,
                "port": config.port.kind,
                "address": session.port.address if session else "",
                "clients": session.port.stats().clients if session else 0,
                "network": network.port.address if network else None,
                "network_clients": network.port.stats().clients if network else 0,
                "failed": daemon.bench.devices[name].failed,
            }
        )
    taps = [
        {"tap": name, "port": session.port.address, "clients": session.port.stats().clients}
        for name, session in daemon.places.taps().items()
    ]
    head = {"bench": daemon.config.bench, "pid": os.getpid(), "version": __version__}
    return head | {"devices": devices, "taps": taps}


def _status(daemon: "Daemon") -> dict[str, Any]:
    bench, grant = daemon.bench, daemon.grant
    rt = bench.core.native.rt_stats()
    listed = _list(daemon)
    for row in listed["devices"]:
        name = row["device"]
        if name in daemon.places.boards():
            row |= real_boards.status(daemon.places.boards()[name])
            continue
        session, device = daemon.places.uarts()[name], bench.devices[name]
        stats = session.port.stats()
        row |= {
            "connects": stats.connects,
            "rx_bytes": stats.rx_bytes,
            "tx_bytes": stats.tx_bytes,
            "dropped_bytes": stats.dropped_bytes,
            "unheard_bytes": stats.unheard_bytes,
            "turned_away": stats.turned_away,
            "backlog_bytes": session.port.backlog(),
            "overrun_bytes": sum(uart.overrun_bytes for uart in device.uarts.values()),
            "note": "; ".join([*filter(None, [daemon.notes.get(name)]), *device.notes.values()]) or None,
            "flash": daemon.commits.failures.get(name, "ok"),
            "port_failure": session.failure,
            "snapshot": device.axis.published().as_dict(),
        }
    return listed | {
        "health": health(daemon),
        "bridges": {name: dict(bridge.status()) for name, bridge in daemon.bridges.items()},
        "segments": segments.listed(daemon),
        "faults": daemon.faults.listed(),
        "rt": grant.state if grant else "starting",
        "rt_line": grant.line() if grant else "",
        "rate_hz": daemon.config.rate_hz,
        "speed": daemon.config.speed,
        "sim_ns": bench.now_ns,
        "period_ns": 1_000_000_000 // daemon.config.rate_hz,
        "elapsed_ns": rt["elapsed_ns"],
        "ticks": rt["ticks"],
        "missed": rt["missed"],
        "overruns": rt["overruns"],
        "wake_latency": octaves(rt["wake_latency"]),
        "lag": list(bench.drive.lag),
    }


def _device(daemon: "Daemon", name: str) -> Device:
    if name in daemon.places.boards():
        raise ControlError(f"{name} is a real board: {real_boards.CANNOT}")
    if name not in daemon.bench.devices:
        raise ControlError(f"no device {name!r}; there are {', '.join(daemon.bench.devices)}")
    return daemon.bench.devices[name]


def _give(daemon: "Daemon", name: str, given: Input) -> dict[str, int]:
    return {"effective_at_ns": daemon.bench.give(_device(daemon, name), given)}


def _reset(daemon: "Daemon", device: str) -> Any:
    if device in daemon.places.boards():
        return real_boards.carry_out(daemon.configured, daemon.places, daemon.runs.real, device, "reset")
    return _give(daemon, device, Reset())


def _pin(daemon: "Daemon", device: str, pin: str, level: int) -> dict[str, int]:
    pins = _device(daemon, device).axis.pins
    if pin not in pins or level not in (0, 1):
        raise ControlError(f"pins of {device} are {', '.join(pins)}; levels are 0 and 1")
    return _give(daemon, device, Pin(pin, level))


def _set(daemon: "Daemon", device: str, field: str, value: float) -> dict[str, int]:
    twin = _device(daemon, device)
    fields = [name for name in SURROUNDINGS if name in OF_KIND[twin.axis.kind]]
    if field not in fields:
        raise ControlError(f"fields of {device} that can be set are {', '.join(fields)}")
    if problem := setting_problem(daemon.bench.faults, twin, field, value):
        raise ControlError(f"{value} is not allowed; {problem}")
    return _give(daemon, device, SetField(field, float(value)))


def _send(daemon: "Daemon", device: str, data: str) -> dict[str, int]:
    if device in daemon.places.boards():
        daemon.places.boards()[device].end.send(bytes.fromhex(data))
        return {}
    name, dot, uart = device.partition(".")
    uart = uart if dot else MAIN
    if uart not in _device(daemon, name).uarts:
        raise ControlError(f"{name} has no serial interface {uart!r}")
    if session := daemon.places.uarts().get(port_label(name, uart)):
        return {"effective_at_ns": session.end.type(bytes.fromhex(data))}
    return _give(daemon, name, Bytes(bytes.fromhex(data), port=uart))


async def _read(daemon: "Daemon", rows: list[list[Any]], read: Callable[[list[list[Any]]], T]) -> T:
    """What ``read`` makes of rows; while it has many of them the bench goes on, and what is known of it is
    known no more.

    Raises:
        ControlError: they are wrong, or the bench ends.
    """
    result = await off_loop(rows, read, rows)
    if not daemon.reloader.is_open:
        raise ControlError("the bench is ending")
    return result


def _train(rows: list[list[Any]]) -> Train:
    train = tuple(Edges(*row) for row in rows)
    if problem := train_problem(train):
        raise ControlError(problem)
    return train


def _bursts(rows: list[list[Any]]) -> tuple[tuple[int, str], ...]:
    bursts = tuple((at_ns, data) for at_ns, data in rows)
    if problem := bursts_problem(bursts):
        raise ControlError(problem)
    return bursts


async def _drive(daemon: "Daemon", device: str, train: list[list[Any]]) -> dict[str, int]:
    rows = await _read(daemon, train, _train)
    if "step" not in _device(daemon, device).axis.pins:
        raise ControlError(f"{device} has no step input")
    return _give(daemon, device, Drive(rows)) | {"length_ns": train_length_ns(rows)}


def _watch(daemon: "Daemon", device: str, signals: list[str], interval_ns: int) -> dict[str, Any]:
    axis = _device(daemon, device).axis
    try:
        names = check_signals(signals or DEFAULT_SIGNALS[axis.kind], axis.kind)
        return {"watch": daemon.watches.open(device, names, interval_ns), "signals": names}
    except ValueError as error:
        raise ControlError(str(error)) from None


def _samples(daemon: "Daemon", watch: int) -> dict[str, Any]:
    try:
        rows, lost = daemon.watches.take(watch, SAMPLES_AT_A_TIME)
    except KeyError:
        raise ControlError(f"watch {watch} has ended; ask for samples every {WATCH_IDLE_S} s") from None
    return {"rows": rows, "lost": lost, "sim_ns": daemon.bench.now_ns}


def _unwatch(daemon: "Daemon", watch: int) -> dict[str, Any]:
    daemon.watches.close(watch)
    return {}


def _inject(daemon: "Daemon", fault: str, target: str, parameters: dict[str, Any]) -> dict[str, int]:
    return {"number": daemon.faults.inject(fault, target, parameters)}


def _clear(daemon: "Daemon", number: int) -> dict[str, Any]:
    daemon.faults.clear(number)
    return {}


def _faults(daemon: "Daemon") -> list[dict[str, Any]]:
    return daemon.faults.listed()


def _capture(daemon: "Daemon", ports: list[str]) -> tuple[Capture, Callable[[], None]]:
    try:
        return daemon.captures.open(ports)
    except KeyError as error:
        raise ControlError(
            f"there is no port {error}; there are {', '.join(daemon.captures.names)}"
        ) from None


async def _play(daemon: "Daemon", tap: str, bursts: list[list[Any]]) -> dict[str, int]:
    rows = await _read(daemon, bursts, _bursts)
    if tap not in daemon.bench.taps:
        raise ControlError(f"there is no tap {tap!r}; there are {', '.join(daemon.bench.taps) or 'none'}")
    return {"effective_at_ns": daemon.bench.give(daemon.bench.taps[tap], Play(rows))}


async def _do(daemon: "Daemon", device: str, name: str, parameters: dict[str, Any]) -> dict[str, Any]:
    done = await daemon.host.do(LOCAL, device, name, parameters)
    return {"effective_at_ns": done.effective_at_ns, **done.answer}


def _verbs(daemon: "Daemon", device: str) -> list[dict[str, Any]]:
    if device not in daemon.host.devices:
        raise ControlError(f"no device {device!r}; there are {', '.join(daemon.host.devices)}")
    return described(daemon.host.devices[device].verbs)


async def _reload(daemon: "Daemon") -> dict[str, Any]:
    try:
        return await daemon.reloader.reload()
    except (ConfigError, ConfigUnreadable) as error:
        return {"problems": str(error)}


def _stop(daemon: "Daemon") -> dict[str, int]:
    daemon.stop()
    return {"pid": os.getpid()}


class Verb(NamedTuple):
    """A request. ``meaning`` is its line in the reference."""

    run: Callable[..., Any]
    arguments: Mapping[str, Kind]
    meaning: str


VERBS = {
    "list": Verb(_list, {}, "the bench's devices, with the addresses of their ports"),
    "status": Verb(
        _status, {}, "health, ticks, missed wakes, histograms, and for each device counters and a snapshot"
    ),
    "reset": Verb(
        _reset, {"device": NAME}, "switch a device's power off and on; a failed device starts again"
    ),
    "pin": Verb(
        _pin,
        {"device": NAME, "pin": NAME, "level": WHOLE},
        "drive an input, of a Mechaduino D0 dir, D1 step, D2 enable, D3; level 0 or 1",
    ),
    "set": Verb(
        _set,
        {"device": NAME, "field": NAME, "value": NUMBER},
        f"set what surrounds the board: {', '.join(SURROUNDINGS)}",
    ),
    "send": Verb(
        _send,
        {"device": NAME, "data": HEX},
        "bytes to a device (s1.network: to its second UART), as from a client; hexadecimal digits",
    ),
    "drive": Verb(
        _drive,
        {"device": NAME, "train": EDGES},
        f"play a pulse train on the step/dir inputs: up to {MAX_ROWS:,} rows of at_ns, pin, level, steps,"
        " duration_ns; [] ends",
    ),
    "watch": Verb(
        _watch,
        {"device": NAME, "signals": NAMES, "interval_ns": WHOLE},
        f"sample fields of an axis from now on, every {MIN_INTERVAL_NS} ns to an hour;"
        f" ends {WATCH_IDLE_S} s after the last `samples`",
    ),
    "samples": Verb(
        _samples,
        {"watch": WHOLE},
        "rows of at_ns and the signals since the last time, and how many were lost",
    ),
    "unwatch": Verb(_unwatch, {"watch": WHOLE}, "end a watch"),
    "inject": Verb(
        _inject,
        {"fault": NAME, "target": NAME, "parameters": OBJECT},
        "make something go wrong; answers its number",
    ),
    "clear": Verb(_clear, {"number": WHOLE}, "take a fault away"),
    "faults": Verb(_faults, {}, "the faults that are active"),
    "capture": Verb(
        _capture, {"ports": NAMES}, "the connection carries a pcapng capture of ports from now on"
    ),
    "play": Verb(
        _play,
        {"tap": NAME, "bursts": BURSTS},
        f"send up to {MAX_BURSTS:,} bursts on a segment: rows of nanoseconds from now, hexadecimal digits",
    ),
    "do": Verb(
        _do,
        {"device": NAME, "name": NAME, "parameters": OBJECT},
        "carry out a verb of the device (see Verbs)",
    ),
    "verbs": Verb(_verbs, {"device": NAME}, "what can be asked of a device, with the parameters"),
    "run": Verb(
        run_verbs.submit,
        {"text": TEXT, "file": TEXT, "check": FLAG},
        "submit a multi-axis run, or only check it",
    ),
    "runs": Verb(run_verbs.states, {"name": NAME}, "how a run does; empty name: all that are remembered"),
    "cancel_run": Verb(run_verbs.cancel, {"name": NAME, "how": NAME}, "end a run with grace or prejudice"),
    "benches": Verb(run_verbs.benches, {}, "other benches that are joined, and their clocks"),
    "segments": Verb(segments.listed, {}, "each segment's stations, taps and counters"),
    "reload": Verb(
        _reload, {}, "read the configuration again; answers devices kept, restarted, added and removed"
    ),
    "stop": Verb(_stop, {}, "end the daemon as SIGTERM does"),
}
