"""Objects of the core and of libraries, which are compiled once and kept in the user's cache."""

import hashlib
import os
import shutil
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

_DONE = "done"
"""Name of the file that says that a folder has all of its objects."""


def cache_folder(env: Mapping[str, str]) -> Path:
    """Folder of what was compiled: ``hil/sketch`` in ``$XDG_CACHE_HOME`` (``~/.cache``)."""
    base = Path(env["XDG_CACHE_HOME"]) if env.get("XDG_CACHE_HOME") else Path(env.get("HOME", "/")) / ".cache"
    return base / "hil" / "sketch"


def key_of(files: Iterable[Path], words: Sequence[str]) -> str:
    """Key of what is compiled of files: it changes with the content of one, and with the compiler's words."""
    digest = hashlib.sha256("\0".join(words).encode())
    for file in files:
        digest.update(f"\0{file}\0".encode())
        digest.update(hashlib.sha256(file.read_bytes()).digest())
    return digest.hexdigest()[:32]


def kept(cache: Path, name: str, key: str, make: Callable[[Path], None]) -> list[Path]:
    """Objects under a key, as they are kept, or are made now. ``make``: is given a folder, and makes them
    there; where two make the same, the first one's are kept.

    Raises:
        OSError: they cannot be kept.
    """
    folder = cache / f"{name}-{key}"
    if not (folder / _DONE).exists():
        cache.mkdir(parents=True, exist_ok=True)
        new = Path(tempfile.mkdtemp(prefix=f".{name}-", dir=cache))
        try:
            make(new)
            (new / _DONE).touch()
            try:
                os.rename(new, folder)
            except OSError:
                if not (folder / _DONE).exists():
                    raise
        finally:
            shutil.rmtree(new, ignore_errors=True)
    return sorted(path for path in folder.iterdir() if path.suffix in (".o", ".a"))
