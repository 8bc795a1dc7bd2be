"""Bundles: a recording in one file, with the boards that it needs and what it ran on.

A zip. ``manifest.json`` names each other file with its length and SHA-256; nothing else may be in it. The
log is ``run.log``; boards from outside of hil are folders in ``boards/``; ``versions.json`` and
``doctor.json`` are for people. What others have made is read with care: names that lead out of the folder,
links, devices, and files that would fill the disk are refused, and the boards' code runs only if somebody
says so.
"""

import hashlib
import json
import re
import shutil
import stat
import tempfile
import weakref
import zipfile
import zlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, BinaryIO

from pydantic import Field, ValidationError

from hil.config.explain import StrictModel
from hil.host.regular_file import open_regular
from hil.sim.inputs import InputLogError

FORMAT, VERSION = "hil-bundle", 1
MANIFEST, LOG, BOARDS, VERSIONS, DOCTOR = "manifest.json", "run.log", "boards", "versions.json", "doctor.json"
MAGIC = b"PK\x03\x04"
MOST_FILES = 10_000
MOST_BYTES = 2 << 30
"""Maximum that a bundle is unpacked to: a day of a busy segment."""
MOST_TIMES = 250
"""Maximum times that its length it is unpacked to, beyond ``FREE_BYTES``: logs are packed to a tenth."""
FREE_BYTES = 64 << 20
_MANIFEST_BYTES = 8 << 20
_PIECE_BYTES = 1 << 20
_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.+-]{0,99}(?:/[A-Za-z0-9_][A-Za-z0-9_.+-]{0,99}){0,9}")
"""Names of files: relative, of plain characters, no part of which begins with a dot."""

Trusts = Callable[[Sequence[str]], bool]
"""Answers whether the code of these boards may run here."""


def trusts_nobody(boards: Sequence[str]) -> bool:
    """Refuse the code of all boards."""
    return False


def trusts_all(boards: Sequence[str]) -> bool:
    """Let the code of all boards run."""
    return True


class BundleError(InputLogError):
    """Error of a bundle that cannot be used: ``str(error)`` says which and why."""


class BundledFile(StrictModel):
    """File of a bundle."""

    bytes: int = Field(ge=0)
    sha256: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]


class BundledBoard(StrictModel):
    """Board of a bundle's run. ``origin``: ``hil``, ``bundle``, or the package that has it, with its
    version; ``sha256``: of its files (``board_files.board_hash``)."""

    origin: str
    sha256: str


class Manifest(StrictModel):
    """Content of a bundle."""

    format: str
    version: int
    program: str = Field(max_length=100)
    files: Mapping[str, BundledFile] = Field(max_length=MOST_FILES)
    boards: Mapping[str, BundledBoard]

    @property
    def own_boards(self) -> list[str]:
        """Names of the boards that are in the bundle."""
        return [name for name, board in self.boards.items() if board.origin == "bundle"]


def is_bundle(path: Path) -> bool:
    """True if a file begins as a bundle does. Raises OSError: it cannot be read."""
    with open_regular(path) as file:
        return file.read(len(MAGIC)) == MAGIC


class UnpackedBundle:
    """Bundle that is unpacked into a temporary folder, which is removed with the object, or at the end of the
    program.

    Raises:
        BundleError: it cannot be used.
        OSError: it cannot be read, or there is no room.
    """

    def __init__(self, path: Path, trusts: Trusts = trusts_nobody) -> None:
        with open_regular(path) as file:
            try:
                self.manifest = self._unpack(file, path, trusts)
            except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
                raise BundleError(f"{path}: the bundle is damaged: {error}") from None
            except _Wrong as error:
                raise BundleError(f"{path}: {error}") from None

    def _unpack(self, file: BinaryIO, path: Path, trusts: Trusts) -> Manifest:
        with zipfile.ZipFile(file) as packed:
            entries = _checked_entries(packed)
            manifest = _manifest(packed, entries)
            _check_sizes(manifest, entries, path.stat().st_size)
            if (own := manifest.own_boards) and not trusts(own):
                names = f"boards of its own ({', '.join(own)})"
                raise _Wrong(
                    f"it has {names}, whose code would run here: if you trust who made it,"
                    " give --trust, or trust=True in a test"
                )
            self.folder = Path(tempfile.mkdtemp(prefix="hil-bundle-"))
            weakref.finalize(self, shutil.rmtree, self.folder, ignore_errors=True)
            for name, about in manifest.files.items():
                _extract(packed, entries[name], about, self.folder)
        return manifest

    @property
    def log(self) -> Path:
        """Path of the log."""
        return self.folder / LOG


def is_plain_name(name: str) -> bool:
    """True if a file of a bundle may have this name."""
    return bool(_NAME.fullmatch(name)) and ".." not in name


class _Wrong(Exception):
    """Error of a bundle, without its name."""


def _checked_entries(packed: zipfile.ZipFile) -> dict[str, zipfile.ZipInfo]:
    """Entries by name, all of which are files within the folder."""
    entries: dict[str, zipfile.ZipInfo] = {}
    infos = packed.infolist()
    if len(infos) > MOST_FILES:
        raise _Wrong(f"it has {len(infos)} files; {MOST_FILES} are the most")
    for info in infos:
        name = info.orig_filename
        if not is_plain_name(name):
            raise _Wrong(f"it wants to write {ascii(name)[:200]}, which is no plain name within its folder")
        kind = stat.S_IFMT(info.external_attr >> 16)
        if kind not in (0, stat.S_IFREG):
            raise _Wrong(f"{name} is a link, a folder or a device, and no file")
        if info.flag_bits & 1:
            raise _Wrong(f"{name} is encrypted")
        if name in entries:
            raise _Wrong(f"{name} is in it twice")
        entries[name] = info
    folders = {name[: at.start()] for name in entries for at in re.finditer("/", name)}
    if both := folders & entries.keys():
        raise _Wrong(f"{min(both)} is a file and a folder")
    return entries


def _manifest(packed: zipfile.ZipFile, entries: Mapping[str, zipfile.ZipInfo]) -> Manifest:
    if MANIFEST not in entries:
        raise _Wrong("this zip is no bundle: it has no manifest.json")
    if entries[MANIFEST].file_size > _MANIFEST_BYTES:
        raise _Wrong(f"its manifest has {entries[MANIFEST].file_size:,} bytes")
    try:
        values = json.loads(_read(packed, entries[MANIFEST], _MANIFEST_BYTES))
    except (ValueError, RecursionError) as error:
        raise _Wrong(f"its manifest is no JSON: {error}") from None
    if not isinstance(values, dict) or values.get("format") != FORMAT:
        raise _Wrong("this zip is no bundle of hil")
    version, program = values.get("version"), ascii(values.get("program"))[:100].strip("'")
    if version != VERSION:
        said = f"it has version {ascii(version)[:80]}, of {program}"
        raise _Wrong(f"{said}; this program reads {VERSION}")
    try:
        manifest = Manifest.model_validate(values)
    except ValidationError as error:
        first = error.errors()[0]
        raise _Wrong(f"its manifest: {'.'.join(map(str, first['loc']))}: {first['msg']}"[:300]) from None
    named = {MANIFEST, *manifest.files}
    for name in sorted({*entries} ^ named):
        there = "is not named by its manifest" if name in entries else "is missing"
        raise _Wrong(f"{ascii(name)[1:-1][:200]} {there}")
    if LOG not in manifest.files or MANIFEST in manifest.files:
        raise _Wrong("it has no log")
    for name in manifest.own_boards:
        if not any(each.startswith(f"{BOARDS}/{name}/") for each in manifest.files):
            raise _Wrong(f"the board {ascii(name)[:80]} is missing")
    if not manifest.own_boards and any(each.startswith(f"{BOARDS}/") for each in manifest.files):
        raise _Wrong("it has boards that its manifest does not name")
    return manifest


def _check_sizes(manifest: Manifest, entries: Mapping[str, zipfile.ZipInfo], packed_bytes: int) -> None:
    total = sum(about.bytes for about in manifest.files.values())
    if total > MOST_BYTES or total > max(packed_bytes * MOST_TIMES, FREE_BYTES):
        raise _Wrong(f"{packed_bytes:,} bytes would be unpacked to {total:,}, which is too much")
    for name, about in manifest.files.items():
        if entries[name].file_size != about.bytes:
            raise _Wrong(f"{name} has another length than its manifest says")


def _read(packed: zipfile.ZipFile, info: zipfile.ZipInfo, at_most: int) -> bytes:
    with packed.open(info) as file:
        return file.read(at_most + 1)


def _extract(packed: zipfile.ZipFile, info: zipfile.ZipInfo, about: BundledFile, folder: Path) -> None:
    path, digest, left = folder / info.filename, hashlib.sha256(), about.bytes
    path.parent.mkdir(parents=True, exist_ok=True)
    with packed.open(info) as file, path.open("xb") as out:
        while piece := file.read(min(_PIECE_BYTES, left + 1)):
            left -= len(piece)
            if left < 0:
                break
            digest.update(piece)
            out.write(piece)
    if left or digest.hexdigest() != about.sha256:
        raise _Wrong(f"{info.filename} is damaged: it is not what its manifest says")
