"""What a reload is to do: the file read, checked and compared, in a thread beside the event loop."""

import gc
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from hil.compose import TableFileError, load_firmware, load_verbs, read_text, start_sections
from hil.config import BenchConfig, Catalogue, Change, ConfigError, diff, parse

SWITCH_S = 0.0005
"""How long this thread's Python may keep the event loop waiting, at each system call; otherwise 5 ms."""


class ReloadRefused(Exception):
    """Nothing has changed: ``str(error)`` says why, a line for each reason."""


class ConfigUnreadable(ReloadRefused):
    """The configuration is not there, or no text: as wrong as one with problems."""


@dataclass(frozen=True)
class Plan:
    """A configuration that can be had, and what has to happen for it. ``tables``: what the configuration puts
    into the memories of twins that begin."""

    config: BenchConfig
    changes: tuple[Change, ...]
    tables: Mapping[str, Mapping[str, bytes]]

    def has_twin(self, name: str) -> bool:
        """Whether the configuration has an emulated board of this name."""
        device = self.config.devices.get(name)
        return device is not None and device.at is None

    def named(self, *actions: str) -> list[str]:
        """Devices that have one of these actions, in order."""
        return [change.device for change in self.changes if change.device and change.action in actions]


def make_plan(path: Path, folder: Path, catalogue: Catalogue, old: BenchConfig) -> Plan:
    """Read the configuration again.

    Raises:
        ConfigError: it has problems, all of them with file:line:column.
        ConfigUnreadable: it cannot be read.
        ReloadRefused: it cannot be had without a restart.
    """
    with _giving_way():
        try:
            new = parse(read_text(path), str(path), catalogue)
        except UnicodeDecodeError as error:
            raise ConfigUnreadable(f"{path}:1:1: this is not UTF-8 text ({error})") from None
        except OSError as error:
            raise ConfigUnreadable(f"{path}: {error.strerror}") from None
        changes = diff(old, new)
        if core := [line for change in changes if change.device is None for line in change.why]:
            raise ReloadRefused("\n".join(f"{line}: only a restart of the daemon does this" for line in core))
        begins = [change.device for change in changes if change.action in ("add", "restart")]
        twins = [name for name in begins if name in new.twins]
        tables = _tables(twins, new, folder)
        for name in twins:  # imports take their time
            load_firmware(catalogue.profiles[new.devices[name].profile])
            load_verbs(new.devices[name].profile)
        return Plan(new, tuple(changes), tables)


def _tables(twins: list[str], new: BenchConfig, folder: Path) -> dict[str, dict[str, bytes]]:
    tables, problems = {}, []
    for name in twins:
        try:
            tables[name] = start_sections(new.devices[name], {}, folder)
        except TableFileError as error:
            problems.append(f"devices.{name}.flash.table: {error}")
    if problems:
        raise ReloadRefused("\n".join(problems))
    return tables


@contextmanager
def _giving_way() -> Iterator[None]:
    """Python runs here while the event loop serves: it gets its turn soon, and no collection of garbage in
    between stops both."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH_S)
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
        sys.setswitchinterval(before)


def problems_of(error: ConfigError | ReloadRefused) -> str:
    """In a line, for where there is room for one."""
    first, *others = str(error).splitlines() or [""]
    return first + (f" (and {len(others)} more)" if others else "")
