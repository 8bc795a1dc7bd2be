"""Plans of how the bench becomes what a configuration says. Reads everything that has to be read.

A start is planned as a reload is, from a bench without devices.
"""

import gc
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from hil.compose.build import TableFileError, named_sections, start_sections, with_programs
from hil.config import BenchConfig, Catalogue, Change, diff, parse
from hil.firmware.nvm import Content
from hil.host.regular_file import read_text
from hil.live.refusals import ConfigUnreadable, Refused
from hil.live.store import Loaded, NvmStore, StoreError, belongs_to
from hil.vocab.problem import not_text
from hil.vocab.profile import Profile

SWITCH_S = 0.0005
"""Maximum time that this thread keeps Python from the event loop, at each system call; otherwise 5 ms."""


@dataclass(frozen=True)
class BenchPlan:
    """Plan for a configuration that can be had. ``memories`` (of twins that do not go on with their own) and
    ``tables`` (what the configuration puts into a memory) are of twins that begin. ``is_start``: nothing runs
    yet, so that devices can be joined."""

    config: BenchConfig
    changes: tuple[Change, ...]
    memories: Mapping[str, Loaded]
    tables: Mapping[str, Mapping[str, bytes]]
    boards: Mapping[str, Profile]
    is_start: bool = False

    def has_twin(self, name: str) -> bool:
        """True if the configuration has a twin of this name."""
        device = self.config.devices.get(name)
        return device is not None and device.at is None

    def named(self, *actions: str) -> list[str]:
        """Names of devices that have one of these actions, in order."""
        return [change.device for change in self.changes if change.device and change.action in actions]

    def begun(self) -> list[str]:
        """Names of devices that are new or start again."""
        return self.named("restart", "add")

    def sections(self, name: str, stored: Mapping[str, bytes]) -> dict[str, bytes]:
        """Memory of a twin as it begins: what the configuration asks for, over what is stored."""
        config = self.config.devices[name]
        board = self.boards[config.profile]
        if config.flash.table in ("stored", "empty"):
            return start_sections(config, board, stored, Path())
        return with_programs(config, named_sections(board, stored)) | dict(self.tables[name])


def plan_start(config: BenchConfig, folder: Path, catalogue: Catalogue, files: NvmStore) -> BenchPlan:
    """Plan the start of all devices of a configuration. Files that it names are looked up from ``folder``.

    Raises:
        Refused: memories or tables cannot be used; all of them are named.
    """
    nothing = config.model_copy(
        update={"devices": {}, "wires": [], "faults": [], **{key: {} for key in config.bus_keys}}
    )
    return _plan(nothing, config, diff(nothing, config), folder, catalogue, files, is_start=True)


def plan_reload(
    path: Path, folder: Path, catalogue: Catalogue, old: BenchConfig, files: NvmStore
) -> BenchPlan:
    """Read the configuration again, and plan the change to it.

    Raises:
        ConfigError: it has problems, all of them with file:line:column.
        ConfigUnreadable: it cannot be read.
        Refused: it cannot be had without a restart, or as ``plan_start``.
    """
    with _giving_way():
        try:
            new = parse(read_text(path), str(path), catalogue)
        except UnicodeDecodeError as error:
            raise ConfigUnreadable(str(not_text(str(path), error))) from None
        except OSError as error:
            raise ConfigUnreadable(f"{path}: {error.strerror}") from None
        changes = diff(old, new)
        if core := [line for change in changes if change.device is None for line in change.why]:
            raise Refused("\n".join(f"{line}: only a restart of the daemon does this" for line in core))
        return _plan(old, new, changes, folder, catalogue, files)


def _plan(
    old: BenchConfig,
    new: BenchConfig,
    changes: list[Change],
    folder: Path,
    catalogue: Catalogue,
    files: NvmStore,
    *,
    is_start: bool = False,
) -> BenchPlan:
    memories: dict[str, Loaded] = {}
    tables: dict[str, Mapping[str, bytes]] = {}
    plan, problems = BenchPlan(new, tuple(changes), memories, tables, catalogue.boards, is_start), []
    for name in filter(plan.has_twin, plan.begun()):
        try:
            if memory := _memory(old, new, name, files):
                memories[name] = memory
            device = new.devices[name]
            tables[name] = start_sections(device, catalogue.boards[device.profile], {}, folder)
        except StoreError as error:
            problems.append(str(error))
        except TableFileError as error:
            problems.append(f"devices.{name}.flash.table: {error}")
    if problems:
        raise Refused("\n".join(problems))
    return plan


def _memory(old: BenchConfig, new: BenchConfig, name: str, files: NvmStore) -> Loaded | None:
    """Load the memory of a device; None: it goes on with its own."""
    before, profile = old.devices.get(name), new.devices[name].profile
    if before is None or before.at is not None:
        return files.look(name, profile)
    if before.profile != profile:  # the old board may still write the file
        return Loaded(Content(profile, 0, {}), None, belongs_to(before.profile, profile))
    return None


@contextmanager
def _giving_way() -> Iterator[None]:
    """Share Python with the serving event loop: it soon gets its turn, and no garbage collection runs."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH_S)
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
        sys.setswitchinterval(before)


def problems_of(error: Exception) -> str:
    """Format an error's problems in one line, for where there is room for one."""
    first, *others = str(error).splitlines() or [""]
    return first + (f" (and {len(others)} more)" if others else "")
