"""Hardware folder that tells the Arduino IDE of hil: ``hardware/hil/virtual`` in the sketchbook.

Each file's first line has a checksum of the rest, so that a file which somebody else wrote or changed is
neither overwritten nor removed.
"""

import hashlib
import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path

from hil import __version__
from hil.arduino.protocol import ARCHITECTURE, PROTOCOL, VENDOR
from hil.config import ProfileInfo
from hil.host.new_file import write_file

_MARK = "# Written by `hil arduino install`; `hil arduino uninstall` removes it. sha256 of the rest: "


class InstallError(Exception):
    """Error of a hardware folder that cannot be written or removed: ``str(error)`` says why, and the
    remedy."""


def platform_txt(command: Path, arguments: Iterable[str]) -> str:
    """Make ``platform.txt``: the discovery of the IDE 2 and that of the IDE 1.8, and the monitor. ``command``
    is the program ``hil``; ``arguments`` go to the discoveries.

    Raises:
        InstallError: a path has what the file's format cannot quote.
    """
    words = [str(command), *arguments]
    for word in words:
        if re.search(r'["{}\\\n]', word):
            raise InstallError(f"platform.txt has no way to quote {word!r}; install hil in another folder")
    program, options = f'"{words[0]}"', "".join(f' "{word}"' for word in words[1:])
    version = re.match(r"\d+\.\d+\.\d+", __version__)
    return "\n".join(
        (
            "name=Virtual boards (hil)",
            f"version={version.group() if version else '0.0.0'}",
            f"pluggable_discovery.{PROTOCOL}.pattern={program} arduino-discovery{options}",
            f"discovery.{PROTOCOL}.pattern={program} arduino-discovery --ide-1.8{options}",
            f"pluggable_monitor.pattern.{PROTOCOL}={program} arduino-monitor",
            "",
        )
    )


def boards_txt(profiles: Iterable[ProfileInfo]) -> str:
    """Make ``boards.txt``: a board for each profile, recognised by the property ``profile`` of its port, and
    by its name in the IDE 1.8. Nothing is built or uploaded for it, so that it has no core and no tool."""
    lines = []
    for profile in profiles:
        lines += [
            f"{profile.name}.name={profile.title} (virtual)",
            f"{profile.name}.build.board=HIL_{profile.name.upper()}",
            f"{profile.name}.upload_port.0.profile={profile.name}",
        ]
    return "\n".join([*lines, ""])


def install(sketchbook: Path, files: Mapping[str, str]) -> list[Path]:
    """Write the files, by name; answers those that were new or have changed.

    Raises:
        InstallError: a file of that name is somebody else's, or cannot be written.
    """
    folder = _folder(sketchbook)
    marked = {folder / name: _marked(text.encode()) for name, text in files.items()}
    try:
        _refuse_foreign(marked)
        folder.mkdir(parents=True, exist_ok=True)
        stale = [path for path, data in marked.items() if _read(path) != data]
        for path in stale:
            write_file(path, marked[path])
    except OSError as error:
        raise InstallError(f"{folder}: {error.strerror}") from error
    return stale


def uninstall(sketchbook: Path, names: Iterable[str], with_folder: bool = False) -> list[Path]:
    """Remove the files that ``install`` wrote, and folders above them up to ``hardware`` that are empty then,
    with ``with_folder`` the sketchbook itself, too; answers all that were removed.

    Raises:
        InstallError: a file was changed since, or cannot be removed; nothing was removed then.
    """
    folder = _folder(sketchbook)
    try:
        found = [path for name in names if (path := folder / name).exists()]
        _refuse_foreign(found)
        for path in found:
            path.unlink()
    except OSError as error:
        raise InstallError(f"{folder}: {error.strerror}") from error
    removed = list(found)
    if not found:
        return removed
    with suppress(OSError):  # not empty
        for empty in (folder, *folder.parents[: 3 if with_folder else 2]):
            empty.rmdir()
            removed.append(empty)
    return removed


def _folder(sketchbook: Path) -> Path:
    return sketchbook / "hardware" / VENDOR / ARCHITECTURE


def _marked(data: bytes) -> bytes:
    return f"{_MARK}{hashlib.sha256(data).hexdigest()}\n".encode() + data


def _read(path: Path) -> bytes | None:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        return None


def _refuse_foreign(paths: Iterable[Path]) -> None:
    for path in paths:
        data = _read(path)
        if data is not None and data != _marked(data.partition(b"\n")[2]):
            raise InstallError(f"{path} was written or changed by somebody else; move it away first")
