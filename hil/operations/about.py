"""Identity of a bench, and its state, in one answer: its row in the inventory of a lab."""

import socket
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from hil import __version__
from hil.config import BenchConfig
from hil.live.configured import Configured
from hil.live.run_recording import RunRecording
from hil.live.runs.queue import RunQueue
from hil.operations.event_log import EventLog
from hil.operations.health import Health, state_of
from hil.operations.seen_events import HERE
from hil.vocab.address import owner_of
from hil.vocab.bridge_protocol import PROTOCOL_VERSION, Bridge
from hil.vocab.desk_protocol import BenchClock, DeviceInfo
from hil.vocab.lease import Lease
from hil.vocab.text_digest import text_digest

MOST_PROBLEMS = 20
MOST_COMMANDERS = 8
"""Maximum number of those who commanded lately; one asker is one, with the latest command."""
_OF_LEASE = ("user", "why", "since_wall_ns", "until_wall_ns")
_OF_RUN = ("run", "state", "step", "steps", "why")
"""Fields of a lease and of a run that change with what happens, and not with time."""
_COMMANDS = {"verbs", "typed", "faults", "runs", "reloads"}
"""Kinds of events that are commands of somebody."""


def config_digest(config: BenchConfig) -> str:
    """Digest of a configuration with all its defaults: the same for two files that differ in form alone."""
    return text_digest(config.model_dump_json(by_alias=True))


@dataclass
class About:
    """Inventory row of one bench. ``lease``: answers the lease that is held; ``bridges``: its doors."""

    configured: Configured
    devices: Mapping[str, DeviceInfo]
    health: Health
    queue: RunQueue
    events: EventLog
    clock: BenchClock
    lease: Callable[[], Lease | None]
    bridges: Mapping[str, Bridge]
    recording: RunRecording
    host: str = field(default_factory=socket.gethostname)
    _of: BenchConfig | None = field(default=None, init=False)
    """Configuration that ``_fixed`` is of: a reload exchanges it."""
    _fixed: dict[str, Any] = field(default_factory=dict, init=False)

    def told(self) -> dict[str, Any]:
        """Answer of the operation."""
        problems = self.health.problems()
        health = {"state": state_of(problems), "problems": [vars(each) for each in problems[:MOST_PROBLEMS]]}
        lease, metrics = self.lease(), self.bridges.get("metrics")
        return self._of_config() | {
            "lease": lease and {name: getattr(lease, name) for name in _OF_LEASE},
            "health": health | {"problems_left_out": max(0, len(problems) - MOST_PROBLEMS)},
            "runs": [{name: run[name] for name in _OF_RUN} for run in self.queue.under_way()],
            "commanders": list(self._commanders()),
            "metrics": metrics.status()["root"] if metrics else "",
            "recording": self.recording.report()["path"],
        }

    def _of_config(self) -> dict[str, Any]:
        config = self.configured.config
        if self._of is not config:
            self._of = config
            self._fixed = {
                "bench": config.bench,
                "version": __version__,
                "protocol": PROTOCOL_VERSION,
                "host": self.host,
                "labels": dict(config.labels),
                "config_digest": config_digest(config),
                "devices": self._rows(config),
            }
        return self._fixed

    def _rows(self, config: BenchConfig) -> dict[str, dict[str, Any]]:
        axes: dict[str, list[str]] = {}
        for address, info in self.devices.items():
            if config.devices[owner_of(address)].at is not None or "position_deg" in info.fields:
                axes.setdefault(owner_of(address), []).append(address)
        return {
            name: {"profile": device.profile, "axes": axes.get(name, []), "is_real": device.at is not None}
            for name, device in config.devices.items()
        }

    def _commanders(self) -> Iterator[dict[str, Any]]:
        """Find the users who commanded lately, the latest first."""
        seen = set[str]()
        for event in self.events.latest_first():
            who = event["who"]
            if event["kind"] not in _COMMANDS or who == HERE or who in seen:
                continue
            seen.add(who)
            wall_ns = self.clock.wall_ns(event["to_ns"])
            yield {"who": who, "what": event["text"], "of": event["of"], "wall_ns": wall_ns}
            if len(seen) == MOST_COMMANDERS:
                return
