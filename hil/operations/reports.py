"""Reports on a bench: its devices, segments and bridges, and their state."""

import os
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from hil import __version__
from hil.config import DeviceConfig
from hil.config.port_kinds import port_kinds
from hil.core.core import octaves
from hil.host.real_time import Grant
from hil.live.board_end import BoardEnd
from hil.live.configured import Configured
from hil.live.drives.real_drive import RealDrive
from hil.live.fault_registry import FaultRegistry
from hil.live.memory_commits import Commits
from hil.live.places import Places
from hil.live.port_joint import Joint
from hil.live.runs.queue import RunQueue
from hil.operations.bus_reports import listed_buses, listed_nodes
from hil.operations.echoes import echoes
from hil.operations.health import Health
from hil.operations.table import Asked
from hil.sim.bench import BenchRuntime
from hil.sim.device import Device
from hil.sim.load_limit import load_notes
from hil.sim.segment_tap import Tap
from hil.vocab.address import Address, address_of
from hil.vocab.bridge_protocol import Bridge
from hil.vocab.desk_protocol import DeviceInfo
from hil.vocab.firmware import NETWORK
from hil.vocab.ports import PortStats
from hil.vocab.segment import speed_notes
from hil.vocab.verbs import described

NO_PORT = PortStats(clients=0, connects=0, rx_bytes=0, tx_bytes=0, dropped_bytes=0, unheard_bytes=0)
NAMED = 5
"""Maximum number of failed devices named in a line."""


@dataclass(frozen=True)
class Reports:
    """Reports on one bench. ``notes``: for the operator, by device."""

    sim: BenchRuntime
    configured: Configured
    places: Places
    devices: Mapping[str, DeviceInfo]
    commits: Commits
    faults: FaultRegistry
    bridges: Mapping[str, Bridge]
    notes: Mapping[str, str]
    grant: Grant
    health: Health
    runs: RunQueue

    def listed(self) -> Iterator[dict[str, Any] | None]:
        """List the bench's devices, taps and CANopen nodes, and the addresses of their ports: None behind
        each device, then the list."""
        head = {"bench": self.configured.config.bench, "pid": os.getpid(), "version": __version__}
        kinds, devices = port_kinds(self.configured.config), []
        for name, config in list(self.configured.config.devices.items()):
            if self._is_there(name):
                devices.append(self._row(name, config, kinds))
                yield None
        taps = [
            {"tap": name, "kind": kinds[name]}
            | {"port": tap.port.address, "clients": tap.port.stats().clients}
            for name, tap in self.places.taps.items()
        ]
        yield head | {"devices": devices, "taps": taps, "nodes": listed_nodes(self.sim)}

    def _is_there(self, name: str) -> bool:
        """True unless a reload has removed the device meanwhile."""
        return name in self.sim.devices or name in self.places.boards or name in self.places.drives

    def _row(self, name: str, config: DeviceConfig, kinds: Mapping[str, str]) -> dict[str, Any]:
        place = self.places.uarts.get(name) or self.places.boards.get(name)
        row: dict[str, Any] = {
            "device": name,
            "profile": config.profile,
            "hardware": config.hardware,
            "port": config.port.kind if config.port else None,
            "greeting": self.configured.catalogue.profiles[config.profile].greeting,
            "address": place.port.address if place else None,
            "clients": place.port.stats().clients if place else 0,
            "network": None,
            "ports": {},
            "axes": [],
            "failed": None,
        }
        if name in self.places.boards or name in self.places.drives:
            return row | {"hardware": "real", "at": config.at}
        device = self.sim.devices[name]
        ports = {
            joint.label: {"kind": kinds[joint.label], "address": joint.port.address}
            | {"clients": joint.port.stats().clients}
            for joint in self.places.of_device(name)
            if address_of(joint.label).part
        }
        network = ports.get(str(Address(name, NETWORK)), {"address": None, "clients": 0})
        return row | {
            "network": network["address"],
            "network_clients": network["clients"],
            "ports": ports,
            "axes": [device.axes.label(name, axis) for axis in device.axes],
            "failed": device.failed,
        }

    def status(self) -> Iterator[dict[str, Any] | None]:
        """List the same with counters, health and all else that is known, in the same manner."""
        listed: dict[str, Any] = {}
        for each in self.listed():
            listed = each or listed
            yield None
        rows = listed["devices"]
        listed["devices"] = []
        for row in rows:
            name = row["device"]
            if self._is_there(name):
                board, drive = self.places.boards.get(name), self.places.drives.get(name)
                row |= _of_drive(drive.drive) if drive else _of_board(board) if board else self._of_twin(name)
                listed["devices"].append(row)
                yield None
        rt, config = self.sim.core.native.rt_stats(), self.configured.config
        yield listed | {
            "health": self.health.as_dict(),
            "bridges": {name: dict(bridge.status()) for name, bridge in self.bridges.items()},
            "echoes": dict(echoes(self.places, self.bridges)),
            "segments": listed_segments(self.sim, self.places),
            "buses": listed_buses(self.sim, self.places),
            "faults": self.faults.listed(),
            "runs": self.runs.under_way(),
            "rt": self.grant.state,
            "rt_line": self.grant.line(),
            "rate_hz": config.rate_hz,
            "speed": config.speed,
            "sim_ns": self.sim.now_ns,
            "period_ns": 1_000_000_000 // config.rate_hz,
            "elapsed_ns": rt["elapsed_ns"],
            "ticks": rt["ticks"],
            "missed": rt["missed"],
            "overruns": rt["overruns"],
            "wake_latency": octaves(rt["wake_latency"]),
            "lag": list(self.sim.drive.lag),
        }

    def _of_twin(self, name: str) -> dict[str, Any]:
        place, device = self.places.uarts.get(name), self.sim.devices[name]
        motors = {axis: each for axis, each in device.axes.items() if each.kind.has_motor}
        shots = {axis: each.published().as_dict() for axis, each in motors.items()}
        note = self.notes.get(name)
        return {
            **_counters(place.port.stats() if place else NO_PORT),
            "backlog_bytes": place.port.backlog() if place else 0,
            "overrun_bytes": sum(uart.overrun_bytes for uart in device.uarts.values()),
            "note": "; ".join([*([note] if note else []), *device.notes.values(), *_of_loads(device, shots)])
            or None,
            "flash": self.commits.failures.get(name, "ok"),
            "port_failure": place.failure if place else None,
            "snapshot": shots.get(device.axes.first),
            "snapshots": {
                device.axes.label(name, axis): shot
                for axis, shot in shots.items()
                if axis != device.axes.first
            },
        }

    def health_in_short(self) -> dict[str, Any]:
        rt, devices = self.sim.core.native.rt_stats(), self.sim.devices.values()
        return {
            "rt": self.grant.state,
            "ticks": rt["ticks"],
            "missed": rt["missed"],
            "overruns": rt["overruns"],
            "failed": {device.name: device.failed for device in devices if device.failed},
            "starved": {device.name: n for device in devices if (n := device.setpoints.starved)},
        } | self.health.as_dict()

    def verbs(self, asked: Asked) -> list[dict[str, Any]]:
        return described(self.devices[asked.target].verbs)

    def registers(self, asked: Asked) -> dict[str, Any]:
        from bridges.modbus.registers.map_rows import (
            map_rows,  # only here: two hundredths of the start's time
        )
        from bridges.modbus.registers.units import unit_of

        return map_rows(unit_of(self.devices[asked.target]).map)


def _of_loads(device: Device, shots: Mapping[str, Mapping[str, float]]) -> Iterator[str]:
    """Notes on the loads of a device's axes."""
    for part, shot in shots.items():
        axis = device.axes[part]
        for said in load_notes(shot, axis.holding_Nm, axis.speed_limit_rpm):
            yield said if part == device.axes.first else f"{part}: {said}"


_NO_COUNTERS = ("clients", "away", "echo")


def _counters(stats: PortStats) -> dict[str, int]:
    return {name: count for name, count in asdict(stats).items() if name not in _NO_COUNTERS}


def _of_board(board: Joint[BoardEnd]) -> dict[str, Any]:
    client, line = board.port.stats(), board.end.line.stats()
    notes = [] if line.clients else [f"{board.end.line.address} is away, tried again each second"]
    if lost := line.unheard_bytes + line.dropped_bytes:
        notes.append(f"{lost} bytes for it were not sent")
    return {
        **_counters(client),
        "dropped_bytes": client.dropped_bytes + line.dropped_bytes,
        "unheard_bytes": client.unheard_bytes + line.unheard_bytes,
        "backlog_bytes": board.port.backlog(),
        "overrun_bytes": 0,
        "note": "; ".join(notes) or None,
        "flash": "ok",
        "port_failure": board.failure,
        "snapshot": None,
        "snapshots": {},
        "board": {"connects": line.connects, "rx_bytes": line.rx_bytes, "tx_bytes": line.tx_bytes},
    }


def _of_drive(drive: RealDrive) -> dict[str, Any]:
    told = {name: value if abs(value) < float("inf") else None for name, value in drive.values().items()}
    link, age_ms = drive.link, told["age_ms"]
    notes = [] if link.is_there else [f"{drive.address}: {link.why}; it is tried again"]
    if link.is_there:
        notes += [*([drive.fault] if drive.fault else []), *drive.notes]
    return {
        **_counters(NO_PORT),
        "backlog_bytes": 0,
        "overrun_bytes": 0,
        "note": "; ".join(notes) or None,
        "flash": "ok",
        "port_failure": None,
        "snapshot": told if drive.reading else None,
        "snapshots": {},
        "drive": {
            "state": link.state,
            "age_ms": age_ms,
            **{name: told[name] for name in ("polls", "writes", "time_outs", "garbled", "exceptions")},
            **{name: told[name] for name in ("reconnects", "round_trip_p50_ms", "round_trip_p99_ms")},
            "identity": dict(drive.identity),
        },
    }


def listed_segments(sim: BenchRuntime, places: Places) -> list[dict[str, Any]]:
    """List each segment with its stations, taps, nodes and counters."""
    now_ns = sim.now_ns
    rows = []
    for name, segment in sim.segments.items():
        own = {label: tap for label, tap in places.taps.items() if label.startswith(f"{name}.")}
        taps = [
            {"tap": label, "address": tap.port.address, "clients": tap.port.stats().clients}
            | {"baud": tap.end.tap.baud if isinstance(tap.end.tap, Tap) else None}
            for label, tap in own.items()
        ]
        clashes = [f"address {address}: {', '.join(who)}" for address, who in segment.clashes().items()]
        notes = [f"two stations have one {clash}" for clash in clashes]
        unheard = {
            label: tap.end.tap.baud
            for label, tap in own.items()
            if isinstance(tap.end.tap, Tap) and not tap.port.stats().clients
        }
        notes += speed_notes(dict(segment.speeds()) | unheard)
        for tap in own.values():
            notes += [tap.failure] if tap.failure else []
            notes += tap.end.tap.notes.values()
        nodes = {each: card.counters() for each, card in sim.cards_on(segment).items()}
        row = {"segment": name, "taps": taps, "nodes": nodes, "notes": notes}
        row["framing"] = segment.framing.name
        rows.append(row | segment.counters(now_ns))
    return rows


def status_line(sim: BenchRuntime, configured: Configured, places: Places, grant: Grant) -> str:
    """Format the bench in a line for systemd: devices, failures, clients, real time, missed ticks."""
    failed = [name for name, device in sim.devices.items() if device.failed]
    failed += [label for label, place in places.uarts.items() if place.failure]
    clients = sum(place.port.stats().clients for place in places.joints())
    missing = f" (no {' and no '.join(grant.missing)})" if grant.missing else ""
    return "; ".join(
        [
            f"bench {configured.config.bench}",
            _counted(len(configured.config.devices), "device")
            + (f", {len(failed)} failed ({_names(failed)})" if failed else ""),
            _counted(clients, "client"),
            f"real time {grant.state}{missing}",
            _counted(sim.core.native.rt_stats()["missed"], "missed tick"),
        ]
    )


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def _names(names: list[str]) -> str:
    return ", ".join(names[:NAMED]) + (", ..." if len(names) > NAMED else "")
