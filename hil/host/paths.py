"""Folders of a bench's files: from options, the configuration and the environment, in this order."""

import os
import stat
import tempfile
from collections.abc import Mapping
from pathlib import Path

from hil.vocab.address import CONTROL_SOCKET

STARTING = stat.S_IXUSR
"""Mode bit of a control socket until its bench serves; on a socket this bit has no other meaning."""
SERVICES = Path("/run/hil")
"""Runtime directories of services."""
SERVICE_STATES = Path("/var/lib/hil")
"""State directories of services."""


def runtime_base(
    option: Path | None, configured: Path | None, env: Mapping[str, str], bench: str = ""
) -> Path:
    """Directory that has one folder for each running bench: the option, the configuration's ``runtime_dir``,
    the service's ``$RUNTIME_DIRECTORY`` (or what it is in, where it has the name of the bench and so is that
    folder), or ``hil`` in ``$XDG_RUNTIME_DIR``; without that variable a folder of the user's in the directory
    for temporary files."""
    if chosen := _chosen(option, configured, "RUNTIME_DIRECTORY", env, bench):
        return chosen
    if env.get("XDG_RUNTIME_DIR"):
        return Path(env["XDG_RUNTIME_DIR"]) / "hil"
    return Path(tempfile.gettempdir()) / f"hil-{os.getuid()}"


def runtime_bases(option: Path | None, env: Mapping[str, str]) -> list[Path]:
    """Folders to search for running benches: the option alone, in a service its own folder alone (its
    ``ExecReload`` means no other's bench), or the user's and the services'."""
    base = runtime_base(option, None, env)
    is_meant = option or _service_directory("RUNTIME_DIRECTORY", env)
    return [base] if is_meant else list(dict.fromkeys([base, SERVICES]))


def state_base(option: Path | None, configured: Path | None, env: Mapping[str, str], bench: str = "") -> Path:
    """Directory that has one folder of boards' memories for each bench: the option, the configuration's
    ``state_dir``, the service's ``$STATE_DIRECTORY`` (as in ``runtime_base``), or ``hil`` in
    ``$XDG_STATE_HOME`` (``~/.local/state``)."""
    if chosen := _chosen(option, configured, "STATE_DIRECTORY", env, bench):
        return chosen
    if env.get("XDG_STATE_HOME"):
        return Path(env["XDG_STATE_HOME"]) / "hil"
    return Path(env.get("HOME", "/")) / ".local" / "state" / "hil"


def state_bases(option: Path | None, env: Mapping[str, str]) -> list[Path]:
    """Directories to search for what benches have left: the option alone, or the user's and the services'."""
    base = state_base(option, None, env)
    return [base] if option else list(dict.fromkeys([base, SERVICE_STATES]))


def _chosen(
    option: Path | None, configured: Path | None, variable: str, env: Mapping[str, str], bench: str
) -> Path | None:
    if given := option or configured:
        return given.absolute()
    service = _service_directory(variable, env)
    return service.parent if service and service.name == bench else service


def log_file(option: Path | None, env: Mapping[str, str]) -> Path | None:
    """File of ``--log``; a service's stands in its ``$LOGS_DIRECTORY`` where its path is relative."""
    service = _service_directory("LOGS_DIRECTORY", env)
    return service / option if service and option else option


def control_sockets(base: Path) -> list[Path]:
    """Control sockets below a directory, or in it; of benches that run, or were killed."""
    return [
        path for pattern in ("", "*/", "*/*/") for path in sorted(base.glob(f"{pattern}{CONTROL_SOCKET}"))
    ]


def closed_folders(base: Path) -> list[Path]:
    """Folders below a directory, or itself, that this user may not look into, so that ``control_sockets``
    does not see what is in them."""
    below = [base, *sorted(base.glob("*/")), *sorted(base.glob("*/*/"))]
    return [each for each in below if each.is_dir() and not os.access(each, os.R_OK | os.X_OK)]


def _service_directory(name: str, env: Mapping[str, str]) -> Path | None:
    """First directory of a service's variable: systemd.exec(5) separates several by colons."""
    first = env.get(name, "").partition(":")[0]
    return Path(first) if first else None


def make_folder(folder: Path, mode: int = 0o700) -> None:
    """Create the folder with this mode where it is new (0700 any new one above it) and check that it is
    usable.

    Raises:
        OSError: it cannot be made or written, or belongs to somebody else.
    """
    for new in reversed([each for each in (folder, *folder.parents) if not each.exists()]):
        new.mkdir(mode=mode if new == folder else 0o700, exist_ok=True)
    if folder.stat().st_uid != os.getuid():
        raise PermissionError(13, "it belongs to another user", str(folder))
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(13, "it may not be written", str(folder))
