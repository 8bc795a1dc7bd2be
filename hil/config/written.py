"""Places of doors and ports in a bench's file, and its old keys, for messages after it was checked."""

from collections.abc import Iterable, Mapping
from dataclasses import field

from pydantic import BaseModel

from hil.config.document import NOWHERE, Document, KeyPath, Spot, dotted
from hil.vocab.late_dataclass import dataclass
from hil.vocab.problem import Problem

_DOORS = {"bridges", "port", "network", "ports"}
"""Keys below which something is opened."""


@dataclass(frozen=True, eq=False)
class Written:
    """File of a bench as it was written. Two benches that say the same are equal, however they are
    written."""

    file: str = ""
    spots: Mapping[KeyPath, Spot] = field(default_factory=dict)
    old_keys: tuple[Problem, ...] = ()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Written)

    def __hash__(self) -> int:
        return 0

    def placed(self, path: KeyPath, what: str) -> str:
        """Format what is wrong at a key path, with its place in the file if there is one."""
        known = path
        while known and known not in self.spots:
            known = known[:-1]
        at = self.spots.get(known, NOWHERE)
        place = f"{self.file}:{at.line}:{at.column}: " if at.line else ""
        return f"{place}{dotted(path)}{what}"


def written(document: Document, old_keys: Iterable[Problem]) -> Written:
    """Keep of a document what messages need later."""
    spots = {path: at for path, at in document.values.items() if not _DOORS.isdisjoint(path)}
    return Written(document.file, spots, tuple(old_keys))


def old_key_problems(
    document: Document, path: KeyPath, given: Mapping[str, object], options: BaseModel
) -> Iterable[Problem]:
    """Warnings of old keys of a door or port, which say what to write instead. ``given``: its options as they
    were written."""
    if old := [key for key in getattr(options, "old_keys", ()) if key in given]:
        at = document.keys.get((*path, old[0]), NOWHERE)
        keys, goes = (", ".join(old), "keys go") if len(old) > 1 else (old[0], "key goes")
        message = f"{dotted(path)}{keys}: the old {goes} with the next release"
        new = f"write `listen: {_quoted(getattr(options, 'listen', ''))}`"
        yield Problem(document.file, at.line, at.column, message, new)


def _quoted(listen: str) -> str:
    """Format an address for YAML, where a bracket begins a list."""
    return f'"{listen}"' if listen.startswith("[") else listen
