"""Files of the page, read once: a daemon serves those that were there when it began."""

import gzip
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

STATIC = Path(__file__).parent / "static"
VERSION_FILE = "build.json"
INDEX = "index.html"
_TYPES: Mapping[str, str] = {
    ".css": "text/css; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".ico": "image/x-icon",
    ".js": "text/javascript; charset=utf-8",
    ".json": "application/json",
    ".map": "application/json",
    ".png": "image/png",
    ".svg": "image/svg+xml",
    ".txt": "text/plain; charset=utf-8",
    ".webmanifest": "application/manifest+json",
    ".woff2": "font/woff2",
}
_PACKED_BYTES = 1024
"""A file from this size on is packed, if that makes it smaller: below it all fits into one packet anyway."""
_NO_PAGE = b"This hil was built without its page: `make web` builds it. The door itself works.\n"


@dataclass(frozen=True)
class PageFile:
    """File of the page. ``compressed``: the same by gzip, empty where it would not be smaller."""

    content: bytes
    compressed: bytes
    content_type: str
    etag: str


@dataclass(frozen=True)
class PageFiles:
    """Files of the page by their paths in a URL, ``/`` too. ``version``: of the sources that they are built
    from; empty where nobody said."""

    files: Mapping[str, PageFile]
    version: str


def read_page(folder: Path = STATIC) -> PageFiles:
    """Read the files below a folder. Without an index there is a text in its place."""
    files: dict[str, PageFile] = {}
    for path in sorted(folder.rglob("*")) if folder.is_dir() else ():
        if path.is_file() and path.suffix in _TYPES:
            place = f"/{path.relative_to(folder).as_posix()}"
            files[place] = _page_file(path.read_bytes(), _TYPES[path.suffix])
    if f"/{INDEX}" not in files:
        files[f"/{INDEX}"] = _page_file(_NO_PAGE, _TYPES[".txt"])
    return PageFiles({**files, "/": files[f"/{INDEX}"]}, _version(files))


def _page_file(content: bytes, content_type: str) -> PageFile:
    packed = gzip.compress(content, mtime=0) if len(content) >= _PACKED_BYTES else content
    compressed = packed if len(packed) < len(content) else b""
    return PageFile(content, compressed, content_type, f'"{hashlib.sha256(content).hexdigest()[:32]}"')


def _version(files: Mapping[str, PageFile]) -> str:
    try:
        said = json.loads(files[f"/{VERSION_FILE}"].content)["version"]
    except (KeyError, TypeError, ValueError):
        return ""
    return str(said)
