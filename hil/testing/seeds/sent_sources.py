"""Tests on their way to other computers: the files of a project, packed and unpacked."""

import hashlib
import io
import os
import subprocess
import tempfile
import zipfile
from pathlib import Path

MOST_BYTES = 64 << 20
"""Maximum size of a project that is sent; what is larger has data in it that a test seldom needs."""
_NOT_SENT = {"__pycache__", "node_modules", "build", "dist"}
_DONE = ".hil-unpacked"


class SourcesRefused(Exception):
    """Error of a project that cannot be sent: ``str(error)`` says why."""


def files_of(root: Path) -> list[Path]:
    """List the files of a project: those that git knows or would add; without git all but hidden ones,
    environments and what others have built."""
    try:
        listed = subprocess.run(
            ["git", "-C", root, "ls-files", "-coz", "--exclude-standard"], capture_output=True, check=True
        )
        names = [Path(os.fsdecode(name)) for name in listed.stdout.split(b"\0") if name]
    except (OSError, subprocess.CalledProcessError):
        names = []
        for folder, below, files in os.walk(root):
            below[:] = [each for each in below if not _is_left_out(Path(folder, each))]
            names += [Path(folder, name).relative_to(root) for name in files if not name.startswith(".")]
    return sorted(name for name in names if (root / name).is_file())


def _is_left_out(folder: Path) -> bool:
    name = folder.name
    return name.startswith(".") or name in _NOT_SENT or (folder / "pyvenv.cfg").exists()


def pack(root: Path) -> bytes:
    """Pack a project, the same files to the same bytes.

    Raises:
        SourcesRefused: it is too large.
    """
    names = files_of(root)
    size = sum((root / name).stat().st_size for name in names)
    if size > MOST_BYTES:
        raise SourcesRefused(
            f"{root} has {size >> 20} MiB in {len(names)} files, and at most {MOST_BYTES >> 20} are sent to a"
            " farm: let git ignore what tests do not need, or give pytest a --rootdir that has less"
        )
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in names:
            info = zipfile.ZipInfo(str(name))  # with a date that is always the same
            info.external_attr = (root / name).stat().st_mode << 16
            archive.writestr(info, (root / name).read_bytes(), zipfile.ZIP_DEFLATED)
    return packed.getvalue()


def mark_of(packed: bytes) -> str:
    """Mark of a packed project, the same for the same files."""
    return hashlib.sha256(packed).hexdigest()[:16]


def folder_of(mark: str) -> Path:
    """Folder of a project on this computer."""
    home = Path(tempfile.gettempdir(), f"hil-farm-{os.getuid()}")
    home.mkdir(mode=0o700, exist_ok=True)
    if home.stat().st_uid != os.getuid():
        raise SourcesRefused(f"{home} belongs to somebody else")
    return home / mark


def unpacked(packed: bytes) -> Path:
    """Folder of a project here; it is unpacked once for each version."""
    folder = folder_of(mark_of(packed))
    if not (folder / _DONE).exists():
        new = Path(tempfile.mkdtemp(dir=folder.parent))
        with zipfile.ZipFile(io.BytesIO(packed)) as archive:
            for info in archive.infolist():
                Path(archive.extract(info, new)).chmod(info.external_attr >> 16 & 0o777 | 0o600)
        (new / _DONE).touch()
        try:
            new.rename(folder)
        except OSError:  # another worker here was first
            if not (folder / _DONE).exists():
                raise
    return folder
