"""Profiles and kinds of ports that exist, found by scanning the folders of their packages."""

from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import BaseModel

from hil.config import Catalogue, DeviceConfig, PortConfig, profile_from_yaml
from hil.core import Core
from hil.vocab.axis_plan import AxisPlan
from hil.vocab.bridge_protocol import Bridge
from hil.vocab.desk_protocol import Desk
from hil.vocab.dialogue import Dialogue
from hil.vocab.ports import Port, PortContext
from hil.vocab.segment import Segment
from hil.vocab.terminal_axis import TerminalAxis
from hil.vocab.time import Clock
from hil.vocab.verbs import Verb, table_of

PROFILES = "device_profiles"
_profile = lru_cache(profile_from_yaml)  # of text: a bench of the test kit is made in 1 ms, not in 25
PORTS = "virtual_ports"
BRIDGES = "bridges"


def _folders(package: str, marker: str) -> Iterator[Path]:
    """Folders of a package that have the marker file, in the order of their names."""
    spec = find_spec(package)
    for root in (spec.submodule_search_locations or []) if spec else []:
        yield from (path.parent for path in sorted(Path(root).glob(f"*/{marker}")))


class _Kinds(Mapping[str, type[BaseModel]]):
    """Options models by kind; a kind's module is imported only when it is asked for."""

    def __init__(self, package: str, module: str, extra: Mapping[str, type[BaseModel]]) -> None:
        self._package, self._module = package, module
        self._extra = extra
        self._names = [*extra, *(folder.name for folder in _folders(package, f"{module}.py"))]

    def __getitem__(self, kind: str) -> type[BaseModel]:
        if kind in self._extra:
            return self._extra[kind]
        if kind not in self._names:
            raise KeyError(kind)
        options: type[BaseModel] = import_module(f"{self._package}.{kind}.{self._module}").Options
        return options

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


def find_catalogue(extra_ports: Mapping[str, type[BaseModel]] | None = None) -> Catalogue:
    """Find all profiles and kinds of ports of this installation; ``extra_ports`` are the caller's own.

    Raises:
        ConfigError: a ``profile.yaml`` is wrong.
    """
    profiles = {
        folder.name: _profile((folder / "profile.yaml").read_text(), folder)
        for folder in _folders(PROFILES, "profile.yaml")
    }
    ports, bridges = _Kinds(PORTS, "port", extra_ports or {}), _Kinds(BRIDGES, "bridge", {})
    return Catalogue(profiles, ports, bridges, _refused_motors)


def _refused_motors(plans: Mapping[str, AxisPlan]) -> dict[str, str]:
    """Try motors in a core of their own: how stiff one may be is the integrator's to say."""
    core, refused = Core(len(plans) or 1), {}
    for name, plan in plans.items():
        try:
            core.open_axis(core.native.group_open(0), plan)
        except ValueError as error:
            refused[name] = str(error)
    return refused


def make_bridge(kind: str, options: BaseModel, desk: Desk) -> Bridge:
    """Make the bridge that a configuration describes, not yet open."""
    bridge: Bridge = import_module(f"{BRIDGES}.{kind}.bridge").make(options, desk)
    return bridge


def make_port(config: PortConfig, context: PortContext) -> Port:
    """Make the port that a configuration describes, not yet open."""
    port: Port = import_module(f"{PORTS}.{config.kind}.port").make(config.options, context)
    return port


def serial_port_config(device: DeviceConfig) -> PortConfig:
    """Configuration of the port that a real board is at."""
    options = import_module(f"{PORTS}.serial.port").Options
    return PortConfig(kind="serial", options=options(url=device.at, baud=device.baud))


def bridge_reference(kind: str) -> str:
    """Part of the reference that a bridge writes, Markdown."""
    text: str = import_module(f"{BRIDGES}.{kind}.bridge").reference()
    return text


def _module_of(profile: str, name: str) -> Any:
    """Load a module that a profile may have, or None."""
    path = f"{PROFILES}.{profile}.{name}"
    return import_module(path) if find_spec(path) else None


def load_dialogues(profile: str) -> Mapping[str, Callable[[], Dialogue[Any]]]:
    """Load the dialogues with a real board of this kind over its terminal, by the names of control verbs."""
    module = _module_of(profile, "dialogues")
    return dict(module.DIALOGUES) if module else {}


def load_terminal_axis(profile: str) -> Callable[[], TerminalAxis] | None:
    """Load what makes a real board of this kind an axis of runs; None: nothing does."""
    made: Callable[[], TerminalAxis] | None = getattr(_module_of(profile, "dialogues"), "AXIS", None)
    return made


class BoardVerbs(NamedTuple):
    """Verbs of a twin, by name; and its functions for missing set-points and for a path of set-points
    (``starve`` and ``follow`` of its ``verbs.py``), None: it has none."""

    table: Mapping[str, Verb]
    starve: Callable[..., None] | None = None
    follow: Callable[..., None] | None = None


def load_verbs(profile: str) -> BoardVerbs:
    """Load the verbs of a kind of board."""
    module = _module_of(profile, "verbs")
    table = table_of(module.VERBS if module else ())
    return BoardVerbs(table, getattr(module, "starve", None), getattr(module, "follow", None))


def make_segment(clock: Clock) -> Segment:
    """Make a wire without stations, on which things happen at times of ``clock``."""
    segment: Segment = import_module(f"{PORTS}.rs485.segment").Segment(clock)
    return segment
