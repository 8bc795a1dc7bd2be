"""Checks of where real boards are: at a serial port or on a bus, no two at one port, no two drives with one
number."""

from collections.abc import Iterable, Iterator, Mapping

from hil.config.document import Finding, KeyPath
from hil.vocab.bus import DriveAddress, DriveKind
from hil.wire.address_keys import SERIAL_FORMS, AddressRefused, is_serial_address


def kind_at(at: str, kinds: Iterable[DriveKind]) -> DriveKind | None:
    """Kind of drive whose address a text is meant as, also of one that cannot be used; None: of none."""
    return next((kind for kind in kinds if at.startswith((f"{kind.scheme}+", f"{kind.scheme}://"))), None)


def address_finding(path: KeyPath, at: str, kinds: Iterable[DriveKind]) -> Finding | None:
    """Finding of a text that is neither the address of a serial port nor that of a drive."""
    kinds = list(kinds)
    if kind := kind_at(at, kinds):
        try:
            kind.address(at)
        except AddressRefused as error:
            return Finding(path, str(error), error.remedy)
    elif not is_serial_address(at):
        drives = ", ".join(f"of a {kind.protocol} drive {kind.example}" for kind in kinds)
        return Finding(path, "this is no serial port", f"{SERIAL_FORMS}; {drives}")
    return None


def same_at(devices: Mapping[str, Mapping[str, object]], kinds: Iterable[DriveKind]) -> Iterator[Finding]:
    """Findings of real boards at a place that another one has. Drives share a line or a bus, under numbers of
    their own."""
    boards: dict[str, str] = {}
    on_lines, kinds = _OnLines(), list(kinds)
    for name, raw in devices.items():
        at, path = raw.get("at"), ("devices", name, "at")
        if not isinstance(at, str):
            continue
        kind = kind_at(at, kinds)
        drive = _read(kind, at) if kind else None
        where = drive.place.where if drive else at
        taken = boards.get(where) or on_lines.other(where, kind if drive else None)
        if drive is None:
            boards.setdefault(where, name)
        if taken:
            yield Finding(path, f"device {taken} is there", "each board has its own port")
        elif kind and drive:
            yield from on_lines.check(path, name, kind, drive, raw)


def _read(kind: DriveKind, at: str) -> DriveAddress | None:
    try:
        return kind.address(at)
    except AddressRefused:
        return None  # told by ``address_finding``


class _OnLines:
    """Drives that were found on lines and buses. The first on each says how it is."""

    def __init__(self) -> None:
        self._first: dict[str, tuple[str, DriveKind, DriveAddress, Mapping[str, object]]] = {}
        self._taken: dict[tuple[str, int], str] = {}

    def other(self, where: str, kind: DriveKind | None) -> str | None:
        """Name of a drive that is there and is of another kind; None: there is none."""
        first = self._first.get(where)
        return first[0] if first and first[1] is not kind else None

    def check(
        self, path: KeyPath, name: str, kind: DriveKind, drive: DriveAddress, raw: Mapping[str, object]
    ) -> Iterator[Finding]:
        where = drive.place.where
        other, _, first, first_raw = self._first.setdefault(where, (name, kind, drive, raw))
        taken = self._taken.setdefault((where, drive.number), name)
        if taken != name:
            message = f"device {taken} has {kind.number} {drive.number} there already"
            remedy = f"each drive on a {kind.line} has a {kind.number} of its own"
            yield Finding(path, message, remedy)
        elif difference := kind.place_differs(other, first, drive):
            yield Finding(path, *difference)
        else:
            for key, remedy in kind.alike.items():
                if raw.get(key) != first_raw.get(key):
                    message = f"device {other} is on this {kind.line}, with another {key}"
                    yield Finding((*path[:-1], key), message, remedy, at_key=True)
                    return
