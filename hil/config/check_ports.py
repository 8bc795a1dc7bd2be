"""Checks of a configuration's ports, by the models of their kinds, and for clashes."""

import difflib
import json
import posixpath
from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple

from pydantic import BaseModel, ValidationError

from hil.config.document import Document, Finding, KeyPath
from hil.config.explain import findings_of, no_such, shown, unknown_key
from hil.config.port_model import PortConfig
from hil.config.written import old_key_problems
from hil.vocab.address import CONTROL_SOCKET
from hil.vocab.near_words import did_you_mean
from hil.vocab.problem import Problem, Unusable

if TYPE_CHECKING:
    from hil.vocab.bridge_protocol import DoorPort

DEFAULT_PORT = "pty"
_Place = tuple[object, ...]


class _Taken(NamedTuple):
    """Place of a port. ``who``: whose it is, with a verb; ``path``: the option that says so; ``is_path``: the
    place is a path in the bench's runtime directory."""

    who: str
    path: KeyPath
    place: _Place
    is_path: bool


class _NoOptions(BaseModel):
    """Stands in for the options of a port that has a finding."""


class PortsCheck:
    """Reads ports; ``findings`` has their mistakes."""

    def __init__(self, document: Document, kinds: Mapping[str, type[BaseModel]]) -> None:
        self._document = document
        self._kinds = kinds
        self._taken: list[_Taken] = []
        self.findings: list[Finding] = []
        self.old_keys: list[Problem] = []
        """Warnings of old keys, of ports and of bridges."""

    def read(self, label: str, path: KeyPath, value: object) -> PortConfig:
        """Read the port at a key path; ``label`` is its name in the bench."""
        port = self._port(path, value)
        if port is not None:
            who = f"device {label} has its port"
            places = _places(label, port.options)
            self._taken += [_Taken(who, (*path, key), place, is_path) for key, place, is_path in places]
        # After a finding the value no longer matters, but it must not raise a second one.
        return port or PortConfig(kind="", options=_NoOptions())

    def _port(self, path: KeyPath, value: object) -> PortConfig | None:
        if isinstance(value, str):
            return self._options(value, {}, path, path)
        kinds = f"known kinds are: {', '.join(sorted(self._kinds)) or 'none'}"
        wanted = "the name of a kind of port is wanted here"
        if not isinstance(value, dict):
            self.findings.append(Finding(path, f"{wanted}, or its options, not {shown(value)}", kinds))
            return None
        options, at_kind = dict(value), (*path, "kind")
        kind = options.pop("kind", None)
        if isinstance(kind, str):
            return self._options(kind, options, path, at_kind)
        if "kind" in value:
            found = Finding(at_kind, f"{wanted}, not {shown(kind)}", kinds)
        elif close := difflib.get_close_matches("kind", value, n=1):
            found = Finding((*path, close[0]), "unknown key", did_you_mean("kind"), at_key=True)
        else:
            found = Finding(at_kind, "this key is missing", 'say which kind of port, as in "kind: pty"')
        self.findings.append(found)
        return None

    def _options(
        self, kind: str, options: dict[str, object], path: KeyPath, kind_path: KeyPath
    ) -> PortConfig | None:
        try:
            model = self._kinds.get(kind)
        except Unusable as error:
            self.findings.append(Finding(kind_path, f"port {kind} cannot be used: {error}", error.remedy))
            return None
        if model is None:
            self.findings.append(no_such(kind_path, "kind of port", kind, self._kinds))
            return None
        known = [field.alias or name for name, field in model.model_fields.items()]
        old = getattr(model, "old_keys", ())
        unknown = [
            unknown_key((*path, key), ["kind", *known], {"kind", *options})
            for key in options
            if key not in known and key not in old
        ]
        self.findings += unknown
        mine = json.dumps({key: value for key, value in options.items() if key in known or key in old})
        try:
            # As JSON, so that strict still reads a path or an enumeration from text.
            read = model.model_validate_json(mine, strict=True)
            self.old_keys += old_key_problems(self._document, path, options, read)
            return PortConfig(kind=kind, options=read)
        except ValidationError as error:
            meant = {finding.remedy for finding in unknown}
            self.findings += [
                finding
                for finding in findings_of(error, model, path, self._document)
                if did_you_mean(str(finding.path[-1])) not in meant
            ]
            return None

    def want(self, owner: str, path: KeyPath, port: "DoorPort") -> None:
        """Note a port that a bridge will want; ``path``: the option that says where it is."""
        with suppress(Unusable):
            if model := self._kinds.get(port.kind):
                places = _places("", model(**port.options))
                self._taken += [_Taken(f"{owner} has a port", path, *place[1:]) for place in places]

    def door(self, name: str, options: BaseModel) -> None:
        """Note where a bridge listens."""
        listens = getattr(options, "listen", None)
        path = ("bridges", name, "listen")
        for listen in [listens] if isinstance(listens, str) else []:
            self._taken += [_Taken(f"the bridge {name} listens", path, place, False) for place in _at(listen)]

    def real(self, name: str, path: KeyPath, at: str) -> None:
        """Note the serial port of a real board. Two boards at one are found elsewhere."""
        board = _Taken(f"device {name} is", path, _real_place(at), False)
        if board.place not in (each.place for each in self._taken):
            self._taken.append(board)

    def clashes(self, runtime_dir: object, bench: object) -> Iterator[Finding]:
        """Findings of ports in a place that another port has already, or the bench itself."""
        directory = posixpath.join(runtime_dir, str(bench)) if isinstance(runtime_dir, str) else ""
        taken: dict[_Place, str] = {
            (posixpath.normpath(directory or "."),): "the bench has its folder",
            (
                posixpath.normpath(posixpath.join(directory, CONTROL_SOCKET)),
            ): "the bench has its control socket",
        }
        folders: dict[str, _Place] = {}
        for whole, owner in taken.items():
            _note_folders(whole, owner, folders)
        for each in self._taken:
            place = each.place
            if each.is_path:
                place = (posixpath.normpath(posixpath.join(directory, str(place[0]))),)
            where, remedy = shown(":".join(map(str, place))), "give each device a place of its own"
            if who := taken.get(place):
                yield Finding(each.path, f"{who} in the same place, {where}", remedy)
            elif each.is_path and (inner := _folder_and_port(str(place[0]), taken, folders)):
                message = f"{taken[inner]} at {shown(inner[0])}, and what is a port is no folder of another"
                yield Finding(each.path, message, remedy)
            else:
                taken[place] = each.who
                _note_folders(place, each.who, folders)


def _note_folders(place: _Place, who: str, folders: dict[str, _Place]) -> None:
    """Note the folders that a place is in, each with the first place there."""
    if len(place) == 1 and not who.endswith("its folder"):
        for folder in _above(str(place[0])):
            folders.setdefault(folder, place)


def _above(path: str) -> Iterator[str]:
    """Folders above a path, the nearest last."""
    return (path[:at] for at, letter in enumerate(path) if letter == "/")


def _folder_and_port(path: str, taken: Mapping[_Place, str], folders: Mapping[str, _Place]) -> _Place | None:
    """Find a place in the folder that a path would be, or in whose folder it would be."""
    if inner := folders.get(path):
        return inner
    above = ((folder,) for folder in _above(path))
    return next((place for place in above if not taken.get(place, "its folder").endswith("its folder")), None)


def _places(name: str, options: BaseModel) -> Iterator[tuple[str, _Place, bool]]:
    """Places of a port by its options, each behind the option that says so; True: it is a path.

    By convention ``path`` is relative to the bench's runtime directory and None stands for the name of the
    device there; ``listen`` is a listener's address, and port 0 any free one, as ``host`` and ``port`` are of
    a kind that has them apart; ``url`` is a real serial port; ``serial_number`` is that of a USB device.
    """
    if hasattr(options, "path"):
        yield "path", (name if options.path is None else str(options.path),), True
    if isinstance(listen := getattr(options, "listen", None), str):
        yield from (("listen", place, False) for place in _at(listen))
    host, port = getattr(options, "host", None), getattr(options, "port", None)
    if host is not None and port:
        yield "port", (str(host).lower(), port), False
    if serial_number := getattr(options, "serial_number", None):
        yield "serial_number", (f"serial number {serial_number}",), False
    url = getattr(options, "url", None)
    if isinstance(url, str):
        yield "url", _real_place(url), False


def _at(listen: str) -> Iterator[_Place]:
    """Place of an address whose port is fixed."""
    host, _, port = listen.lower().rpartition(":")
    if host and port.isdecimal() and port != "0":
        yield host, port


def _real_place(url: str) -> _Place:
    return (posixpath.normpath(url) if url.startswith("/") else url,)
