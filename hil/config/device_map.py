"""Check of a device's map of registers of its own: a file, or written out in the configuration."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from hil.config.catalogue import ProfileInfo
from hil.config.document import Document, Finding, KeyPath
from hil.config.explain import shown
from hil.config.port_model import is_path
from hil.vocab.bus import MapKind
from hil.vocab.problem import ConfigError, Problem, not_text


class MapCheck:
    """Check of ``map`` of one device. ``findings``: mistakes in the configuration; ``problems``: in the file.
    ``profile``: None if there is none of its name."""

    def __init__(
        self,
        path: KeyPath,
        raw: Mapping[str, Any],
        document: Document,
        profile: ProfileInfo | None,
        maps: MapKind,
        read_text: Callable[[Path], str] | None,
    ) -> None:
        self._path: KeyPath = (*path, "map")
        self._raw, self._given = raw, raw["map"]
        self._document, self._profile = document, profile
        self._maps, self._read_text = maps, read_text
        self.findings: list[Finding] = []
        self.problems: list[Problem] = []

    def read(self) -> Any:
        """Read the map as its kind's model; None: it has mistakes."""
        if self._profile and self._profile.map is None:
            message = f"a {self._profile.name} has no map of its own, but one of its verbs and fields"
            self.findings.append(Finding(self._path, message, "leave this key out", at_key=True))
            return None
        if isinstance(self._given, dict):
            found = [*self._maps.findings(self._document, self._path, self._parameters())]
            is_bad = any(each.path[: len(self._path)] == self._path for each in self._document.findings)
            self.findings += found
            return None if found or is_bad else self._maps.model().model_validate(self._given)
        if not is_path(self._given):
            what = f"a file's path or a map is wanted here, not {shown(self._given)}"
            self.findings.append(Finding(self._path, what, "write the path, as in lathe.yaml"))
            return None
        return self._read_file(Path(self._document.file).parent / self._given)

    def _read_file(self, path: Path) -> Any:
        assert self._read_text is not None, "this catalogue reads no files"
        try:
            return self._maps.read(self._read_text(path), str(path), self._parameters())
        except ConfigError as error:
            self.problems += error.problems
        except UnicodeDecodeError as error:
            self.problems.append(not_text(str(path), error))
        except OSError as error:
            message = f"{path} cannot be read: {error.strerror}"
            self.findings.append(Finding(self._path, message, "write where it is, from this file on"))
            return None
        message = f"the map {self._given} cannot be used"
        self.findings.append(Finding(self._path, message, "mend what is said of it below"))
        return None

    def _parameters(self) -> list[str] | None:
        """Fields that a map's parameters may be; None: any, of a real drive."""
        if self._raw.get("at") is not None or self._profile is None:
            return None
        kinds = [self._profile.kind(axis) for axis in self._profile.axes][:1]
        return [name for kind in kinds for name, of in kind.settable.items() if not of.is_around]
