"""Files of a board's folder that make it what it is, and their hash."""

from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path

_MINE = frozenset({"tests", "transcripts", "__pycache__", "node_modules"})
"""Folders that a run needs nothing of."""
_SECRET = (".pem", ".key", ".p12", ".pfx", ".crt", ".cer", ".kdbx", ".gpg")
"""Ends of files with keys and passwords."""
MOST_BYTES = 32 << 20
"""Maximum that a board's files have together."""


def board_files(folder: Path) -> Iterator[tuple[str, Path]]:
    """Find the files of a board that its code may need, by their names in its folder, in order. What is
    hidden, a link, or a key is left out."""
    for path in sorted(folder.rglob("*")):
        parts = path.relative_to(folder).parts
        hidden = any(part.startswith(".") or part in _MINE for part in parts)
        if not hidden and not path.is_symlink() and path.is_file() and path.suffix not in (".pyc", *_SECRET):
            yield "/".join(parts), path


def board_hash(folder: Path) -> str:
    """SHA-256 of a board's files and their names, as hexadecimal digits."""
    digest = sha256()
    for name, path in board_files(folder):
        digest.update(f"{name}\0{sha256(path.read_bytes()).hexdigest()}\n".encode())
    return digest.hexdigest()
