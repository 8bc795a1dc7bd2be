"""Kinds of documents that users write, and what a document is that was given in the place of another."""

from pathlib import PurePath
from typing import NamedTuple

from hil.config.document import Document, Finding
from hil.vocab.problem import ConfigError


class DocumentKind(NamedTuple):
    """Kind of document. ``marks``: keys of no other kind; ``use``: what takes it, of which ``FILE`` is the
    name."""

    what: str
    marks: frozenset[str]
    use: str


BENCH = DocumentKind(
    "a bench's configuration", frozenset({"bench", "devices"}), "`hil serve FILE` starts the bench"
)
RUN = DocumentKind("a run", frozenset({"run", "steps"}), "`hil run FILE` carries it out")
MACHINE = DocumentKind(
    "a machine", frozenset({"machine"}), "`hil gcode PROGRAM --machine FILE` draws with it"
)
DRIVE_MAP = DocumentKind(
    "a map of a Modbus drive",
    frozenset({"modbus_map", "word_order", "position_deg", "velocity_rpm", "set_point_deg", "cells"}),
    "`map: FILE` at a device uses it",
)
BOARD = DocumentKind(
    "a board's profile", frozenset({"title", "uarts", "dialogue"}), "`hil profile check FOLDER` checks it"
)
KINDS = (BENCH, RUN, MACHINE, DRIVE_MAP, BOARD)


class OtherKindError(ConfigError):
    """Error of a document that is of another kind than was wanted: of ``kind``. ``text``: all of it, if it
    was noted, as a pipe cannot be read again."""

    text = ""

    def __init__(self, document: Document, kind: DocumentKind, wanted: DocumentKind) -> None:
        mark = next(key for key in document.keys if len(key) == 1 and key[0] in kind.marks)
        message = f"this is {kind.what}, not {wanted.what}"
        folder = str(PurePath(document.file).parent)
        use = kind.use.replace("FILE", document.file).replace("FOLDER", folder)
        finding = Finding(mark, message, use, at_key=True)
        super().__init__(document.error([finding]).problems)
        self.kind = kind


def kind_of(value: object) -> DocumentKind | None:
    """Kind of a document by the keys at its top; None: of no kind, or of several alike."""
    if not isinstance(value, dict):
        return None
    found = sorted(KINDS, key=lambda kind: len(kind.marks & value.keys()), reverse=True)
    counts = [len(kind.marks & value.keys()) for kind in found]
    return found[0] if counts[0] > counts[1] else None


def check_kind(document: Document, wanted: DocumentKind) -> None:
    """Check that a document is none of another kind. Raises OtherKindError."""
    kind = kind_of(document.value)
    if kind not in (None, wanted):
        raise OtherKindError(document, kind, wanted)
