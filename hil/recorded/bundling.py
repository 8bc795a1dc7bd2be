"""Making of a bundle (``hil.compose.bundles``) of a recording.

What goes in is listed here by name; all else of the configuration and the machine stays: doors with their
users, keys and addresses, real boards, folders, names of hosts and of users.
"""

import json
import platform
import re
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path
from typing import Any, BinaryIO

from hil import __version__
from hil.compose.bundles import (
    BOARDS,
    DOCTOR,
    FORMAT,
    LOG,
    MANIFEST,
    VERSION,
    VERSIONS,
    is_bundle,
    is_plain_name,
)
from hil.compose.log_lines import LogLines
from hil.discovery.board_files import MOST_BYTES, board_files, board_hash
from hil.discovery.board_places import BoardPlace, find_places
from hil.discovery.installed import BOARDS as BOARD_POINTS
from hil.discovery.installed import installed
from hil.host.doctor import Diagnosis
from hil.recorded.recorded_run import RecordedRun, open_recorded
from hil.sim.inputs import InputLogError
from hil.sim.noted_events import decode_event, encode_event, without_names

_TOP = ("bench", "devices", "wires", "faults", "rate_hz", "speed", "seed")
"""Keys of a configuration that go into a bundle, beside those of wires with stations."""
_DEVICE = (
    *("profile", "port", "baud", "bauds", "flash", "hardware", "plant", "load", "axis", "registers", "axes"),
    *("setpoints", "setpoint_rate_Hz", "line_delay_ms", "spi_previous_command", "map", "units"),
    *("auto_reset", "voltages", "rs485", "magnet"),
)
"""Keys of a device that go into a bundle."""
_DOCTORS = frozenset(
    {
        *("real-time priority", "RLIMIT_RTPRIO", "real-time throttling", "seccomp", "CPUs", "isolated CPU"),
        *("kernel", "CPU frequency", "clock source", "virtual machine", "inotify", "RLIMIT_NOFILE"),
    }
)
"""Findings of the doctor whose words name no folders and people, and count nothing that changes from moment
to moment, as ptys in use: the same recording gives the same bundle. Of others only the verdict goes in."""
_EVENT = re.compile(rb'\{"at_ns":\d+,"event":')
_CHECK = re.compile(rb'(\{(?:"end":true,"why":"\w*",)?"at_ns":\d+,"check":)(\d+)')
"""Beginning of a line of ``hil.sim.log_checks``."""
_RELOAD = re.compile(rb'\{"at_ns":\d+,"reload":')
"""Beginning of a line with another configuration."""


class BundleRefused(Exception):
    """Error of a bundle that cannot be made: ``str(error)`` says why."""


@dataclass(frozen=True)
class BundleContent:
    """File that goes into a bundle. ``about``: for people; ``pieces``: makes its bytes, as often as asked."""

    about: str
    pieces: Callable[[], Iterator[bytes]]
    size: int
    sha256: str


@dataclass
class Bundling:
    """Bundle that is to be written. ``left_out``: what stays, for people."""

    files: dict[str, BundleContent] = field(default_factory=dict)
    boards: dict[str, dict[str, str]] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)

    def add(self, name: str, about: str, pieces: Callable[[], Iterator[bytes]]) -> None:
        """Add a file."""
        digest, size = sha256(), 0
        for piece in pieces():
            digest.update(piece)
            size += len(piece)
        self.files[name] = BundleContent(about, pieces, size, digest.hexdigest())

    def write(self, file: BinaryIO) -> None:
        """Write the bundle: the same content gives the same bytes."""
        manifest = {
            "format": FORMAT,
            "version": VERSION,
            "program": f"hil {__version__}",
            "files": {name: {"bytes": each.size, "sha256": each.sha256} for name, each in self.files.items()},
            "boards": self.boards,
        }
        text = json.dumps(manifest, indent=1).encode()
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as packed:
            _write(packed, MANIFEST, iter((text,)))
            for name, each in self.files.items():
                _write(packed, name, each.pieces())


def _write(packed: zipfile.ZipFile, name: str, pieces: Iterator[bytes]) -> None:
    info = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
    info.compress_type, info.external_attr = zipfile.ZIP_DEFLATED, 0o100644 << 16
    with packed.open(info, "w", force_zip64=True) as file:
        for piece in pieces:
            file.write(piece)


def bundling(path: Path, diagnoses: Sequence[Diagnosis]) -> Bundling:
    """Gather a bundle of a log. ``diagnoses``: of this machine.

    Raises:
        BundleRefused: it is a bundle, or a board cannot go into one.
        InputLogError, ConfigError: as ``open_recorded``.
        OSError: something cannot be read.
    """
    if is_bundle(path):
        raise BundleRefused(f"{path} is a bundle already")
    made = Bundling()
    with closing(open_recorded(path)) as run:
        own = _add_boards(made, run)
        wires, paths = run.config.bus_keys, {"profile_path": [BOARDS]} if own else {}
        made.left_out = _left_out(run)
        about = f"the run: {len(run.log.inputs)} inputs, with all bytes that were typed; what the boards sent"
        made.add(LOG, about, lambda: _log_lines(path, lambda config: _shared_config(config, wires) | paths))
    made.add(VERSIONS, "versions of hil, Python and libraries", lambda: iter((_json(_versions()),)))
    told = _json([_told(each) for each in diagnoses])
    made.add(DOCTOR, "what `hil doctor` says of this machine", lambda: iter((told,)))
    return made


def _json(values: Any) -> bytes:
    return (json.dumps(values, indent=1) + "\n").encode()


# ---- the configuration and the log ----


def _shared_config(config: Mapping[str, Any], wires: Sequence[str]) -> dict[str, Any]:
    kept = {key: config[key] for key in (*_TOP, *wires) if key in config}
    kept["devices"] = {
        name: _shared_device(device) for name, device in config["devices"].items() if not device.get("at")
    }
    return kept


def _shared_device(device: Mapping[str, Any]) -> dict[str, Any]:
    kept = {key: device[key] for key in _DEVICE if key in device}
    if "/" in str(kept.get("flash", {}).get("table", "")):  # a file's path; its content is in the log
        kept["flash"] = kept["flash"] | {"table": "stored"}
    return kept


def _left_out(run: RecordedRun) -> list[str]:
    config = run.log.config
    keys = [key for key, value in config.items() if value and key not in (*_TOP, *run.config.bus_keys)]
    real = [f"the real board {name}" for name in run.config.real]
    return [*(f"`{key}` of the configuration" for key in keys if key != "profile_path"), *real]


def _log_lines(path: Path, shared: Callable[[dict[str, Any]], dict[str, Any]]) -> Iterator[bytes]:
    """Lines of a log with what is shared of its configurations, up to where its checks say that it is whole;
    the checks are those of what is written."""
    was = now = 0
    waiting: list[bytes] = []
    with LogLines(path) as lines:
        try:
            for number, line in enumerate(lines.more()):
                if number == 0:
                    new = _with_shared(line, "config", shared)
                elif _RELOAD.match(line):
                    new = _with_shared(line, "reload", shared)
                elif _EVENT.match(line):
                    event = without_names(decode_event(json.loads(line)))
                    new = encode_event(event).encode() + b"\n"
                elif check := _CHECK.match(line):
                    if int(check[2]) != was:
                        return
                    new = b"".join(waiting)
                    yield new
                    now, waiting = zlib.crc32(new, now), []
                    new = b"%s%d%s" % (check[1], now, line[check.end() :])
                else:
                    new = line
                was = zlib.crc32(line, was)
                waiting.append(new)
        except InputLogError:  # the file is no gzip from here on
            pass
    yield b"".join(waiting)


def _with_shared(line: bytes, key: str, shared: Callable[[dict[str, Any]], dict[str, Any]]) -> bytes:
    values = json.loads(line)
    return json.dumps(values | {key: shared(values[key])}, separators=(",", ":")).encode() + b"\n"


# ---- boards, versions, the machine ----


def _add_boards(made: Bundling, run: RecordedRun) -> bool:
    """Add the boards of a run; answers whether some are in the bundle."""
    configs = [run.log.config, *(place.reload.config for place in run.log.reloads)]
    folders = [Path(folder) for config in configs for folder in config.get("profile_path", ())]
    places = find_places([*dict.fromkeys(folders)]).places
    devices = [device for config in configs for device in config["devices"].values()]
    for name in sorted({device["profile"] for device in devices if not device.get("at")}):
        place = places[name]
        origin = _origin(place)
        made.boards[name] = {"origin": origin, "sha256": board_hash(place.folder)}
        if origin != "bundle":
            continue
        files = [*board_files(place.folder)]
        if odd := next((relative for relative, _ in files if not is_plain_name(relative)), None):
            raise BundleRefused(f"{place.folder / odd}: no file of a bundle has this name; rename it")
        if (size := sum(file.stat().st_size for _, file in files)) > MOST_BYTES:
            said = f"the board {name} has {size:,} bytes"
            raise BundleRefused(f"{said}; {MOST_BYTES:,} are the most ({place.folder})")
        for relative, file in files:
            made.add(f"{BOARDS}/{name}/{relative}", f"the board {name}", _reader(file))
    return any(board["origin"] == "bundle" for board in made.boards.values())


def _reader(file: Path) -> Callable[[], Iterator[bytes]]:
    content = file.read_bytes()
    return lambda: iter((content,))


def _origin(place: BoardPlace) -> str:
    """Origin of a board: ``hil``, ``bundle`` for one from a folder, or the package that it is of."""
    for point in installed(BOARD_POINTS).get(place.name, ()):
        if point.value == place.package and point.dist:
            return f"{point.dist.name} {point.dist.version}"
    return "bundle" if place.package.startswith("board_") else "hil"


def _versions() -> dict[str, Any]:
    names = sorted({re.split(r"[^\w.-]", each)[0] for each in requires("hil-motion") or ()})
    libraries = {}
    for name in names:
        try:
            libraries[name] = version(name)
        except PackageNotFoundError:
            continue
    return {
        "hil": __version__,
        "python": platform.python_version(),
        "machine": platform.machine(),
        "libraries": libraries,
    }


def _told(diagnosis: Diagnosis) -> dict[str, str]:
    said = {"name": diagnosis.name, "verdict": diagnosis.verdict}
    return said | ({"found": diagnosis.found} if diagnosis.name in _DOCTORS else {})
