"""Checks of a configuration's ports, by the models of their kinds, and for clashes."""

import difflib
import json
import posixpath
from collections.abc import Iterator, Mapping

from pydantic import BaseModel, ValidationError

from hil.config.catalogue import Unusable
from hil.config.document import Document, Finding, KeyPath
from hil.config.explain import findings_of, no_such, shown, unknown_key
from hil.config.port_model import PortConfig

DEFAULT_PORT = "pty"


class _NoOptions(BaseModel):
    """Stands in for the options of a port that has a finding."""


class PortsCheck:
    """Reads ports; ``findings`` has their mistakes."""

    def __init__(self, document: Document, kinds: Mapping[str, type[BaseModel]]) -> None:
        self._document = document
        self._kinds = kinds
        self._read: list[tuple[str, KeyPath, PortConfig]] = []
        self.findings: list[Finding] = []

    def read(self, label: str, path: KeyPath, value: object) -> PortConfig:
        """Read the port at a key path; ``label`` is its name in the bench."""
        port = self._port(path, value)
        if port is not None:
            self._read.append((label, path, port))
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
            found = Finding((*path, close[0]), "unknown key", 'did you mean "kind"?', at_key=True)
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
        unknown = [
            unknown_key((*path, key), ["kind", *known], {"kind", *options})
            for key in options
            if key not in known
        ]
        self.findings += unknown
        mine = json.dumps({key: value for key, value in options.items() if key in known})
        try:
            # As JSON, so that strict still reads a path or an enumeration from text.
            return PortConfig(kind=kind, options=model.model_validate_json(mine, strict=True))
        except ValidationError as error:
            meant = {finding.remedy for finding in unknown}
            self.findings += [
                finding
                for finding in findings_of(error, model, path, self._document)
                if f'did you mean "{finding.path[-1]}"?' not in meant
            ]
            return None

    def clashes(self, runtime_dir: object) -> Iterator[Finding]:
        """Findings of ports in a place that another port has already."""
        taken: dict[tuple[object, ...], str] = {}
        directory = runtime_dir if isinstance(runtime_dir, str) else ""
        for label, path, port in self._read:
            for place, key in _places(label, port.options, directory):
                owner = taken.setdefault(place, label)
                if owner != label:
                    where = shown(":".join(map(str, place)))
                    message = f"device {owner} has its port in the same place, {where}"
                    yield Finding((*path, key), message, "give each device a place of its own")


def _places(device: str, options: BaseModel, runtime_dir: str) -> Iterator[tuple[tuple[object, ...], str]]:
    """Places of a port by its options, each with the option that says so.

    By convention ``path`` is relative to the runtime directory and None stands for the device's name there;
    ``host`` and ``port`` are a listener's address, and port 0 any free one.
    """
    if hasattr(options, "path"):
        path = device if options.path is None else str(options.path)
        yield (posixpath.normpath(posixpath.join(runtime_dir, path)),), "path"
    host, port = getattr(options, "host", None), getattr(options, "port", None)
    if host is not None and port:
        yield (str(host).lower(), port), "port"
