"""Names of what runs, for a shell's completion: ``hil _names KIND WORD...``, where the words are those of the
command line so far. Prints a name in each line, and after a tab what it is.

A key is pressed and waits: this imports little, and gives a bench half a second.
"""

import os
import sys
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hil.net.benches_here import Found, find
from hil.net.control_client import ControlError, ask

_TIMEOUT_S = 0.5
_MOST_AXES = 16
"""Axes whose fields are offered; of a bench with more the user knows the names."""


@dataclass(frozen=True)
class TypedLine:
    """Command line so far: the bench that it means, and its words that are no options."""

    runtime_dir: Path | None
    bench: str | None
    words: tuple[str, ...]

    def found(self) -> Found:
        return find(self.runtime_dir, os.environ)

    def ask(self, verb: str, **arguments: Any) -> Any:
        """Ask the bench that the command would ask.

        Raises:
            ControlError: there is none, or it refuses.
        """
        wanted = self.bench or os.environ.get("HIL_BENCH") or None
        meant = self.found().meant(wanted)
        if len(meant) > 1:
            meant = self.found().running().meant(wanted)
        if len(meant) != 1:
            raise ControlError("no bench, or several")
        return ask(meant[0].socket, verb, timeout_s=_TIMEOUT_S, **arguments)


Names = Iterable[tuple[str, str]]


def _benches(line: TypedLine) -> Names:
    found = line.found()
    names = [(found.called(bench), str(bench.folder)) for bench in found.benches]
    several = len({bench.name for bench in found.benches}) < len(names)
    return names if several else [(name, "") for name, _ in names]


def _ports(line: TypedLine) -> Names:
    for row in line.ask("list")["devices"]:
        if row["address"]:
            yield row["device"], row["profile"]
        for name in row["ports"]:
            yield name, f"{row['profile']}, its {name.partition('.')[2]}"


def _verb_values(line: TypedLine) -> Names:
    _, device, verb, *_ = line.words
    for row in line.ask("verbs", device=device):
        if row["verb"] == verb.replace("-", "_"):
            yield from ((f"{name}=", about) for name, about in row["parameters"].items())


def _faults(line: TypedLine) -> Names:
    from hil.vocab.faults import FAULT_KINDS

    return [(kind.name, kind.about) for kind in FAULT_KINDS.values()]


def _fault_words(line: TypedLine) -> Names:
    from hil.vocab.fault_words import GROUPS

    yield from _faults(line)
    yield from GROUPS.items()
    with suppress(ControlError):
        yield from _targets(line)


def _fault_values(line: TypedLine) -> Names:
    from hil.vocab.faults import FAULT_KINDS, TIMING

    kind = FAULT_KINDS[line.words[2]]
    return [(f"{each.name}=", each.about) for each in (*kind.parameters, *TIMING)]


def _shells(line: TypedLine) -> Names:
    from hil.cli.documents.completion import SHELLS

    return [(shell, "") for shell in SHELLS]


def _pages(line: TypedLine) -> Names:
    from hil.cli.framework.installed_files import find_pages

    return [(name, page.title) for name, page in find_pages().items()]


def _boards(line: TypedLine) -> Names:
    from hil.discovery.board_places import find_places

    return [(name, "") for name in sorted(find_places().places)]


def _sessions(line: TypedLine) -> Names:
    from hil.discovery.board_places import find_places
    from hil.discovery.board_sessions import shipped_sessions

    return [(name, "") for name in shipped_sessions(find_places())]


def _taps(line: TypedLine) -> Names:
    return [(row["tap"], "tap") for row in line.ask("list")["taps"]]


def _lines(line: TypedLine) -> Names:
    rows = line.ask("segments")
    nodes = [(node, f"Modbus node of {row['segment']}") for row in rows for node in row["nodes"]]
    buses = ((row["bus"], "CAN bus") for row in line.ask("buses"))
    return [*_ports(line), *_taps(line), *nodes, *((row["segment"], "segment") for row in rows), *buses]


def _members(row: dict[str, Any]) -> list[str]:
    """A device and its further axes."""
    return [row["device"], *(axis for axis in row["axes"] if axis != row["device"])]


def _targets(line: TypedLine) -> Names:
    lines = list(_lines(line))
    known = {name for name, _ in lines}
    rows = line.ask("list")["devices"]
    axes = [(name, row["profile"]) for row in rows for name in _members(row) if name not in known]
    return [*lines, *_on_buses(line), *axes]


def _on_buses(line: TypedLine) -> Names:
    """Nodes of CAN buses, except taps."""
    for row in line.ask("buses"):
        taps = {each["tap"] for each in row["taps"]}
        for node in row["nodes"]:
            if node not in taps:
                yield node, f"{'CANopen node' if node in row['drives'] else 'channel'} of {row['bus']}"


def _fields(line: TypedLine) -> Names:
    """Fields of the first axes: each is a question of its own."""
    axes = [name for row in line.ask("list")["devices"] for name in _members(row)]
    for name in axes[:_MOST_AXES]:
        yield from ((f"{name}.{field}", "") for field in line.ask("state", device=name) if field != "at_ns")


KINDS: dict[str, Callable[[TypedLine], Names]] = {
    "benches": _benches,
    "devices": lambda line: [(row["device"], row["profile"]) for row in line.ask("list")["devices"]],
    "axes": lambda line: [
        (name, row["profile"]) for row in line.ask("list")["devices"] for name in _members(row)
    ],
    "ports": _ports,
    "targets": _targets,
    "taps": _taps,
    "lines": _lines,
    "buses": lambda line: [(row["bus"], f"{row['bit_rate']} bit/s") for row in line.ask("buses")],
    "verbs": lambda line: [
        (row["verb"].replace("_", "-"), row["about"]) for row in line.ask("verbs", device=line.words[1])
    ],
    "verb-values": _verb_values,
    "faults": _faults,
    "fault-words": _fault_words,
    "fault-values": _fault_values,
    "fault-numbers": lambda line: [
        (str(row["number"]), f"{row['kind']} {row['target']}") for row in line.ask("faults")
    ],
    "runs": lambda line: [(row["run"], row["state"]) for row in line.ask("runs", name="")],
    "fields": _fields,
    "boards": _boards,
    "sessions": _sessions,
    "shells": _shells,
    "pages": _pages,
}
"""Kinds of names, as in ``command_table.VALUES``."""


def print_names(arguments: list[str]) -> None:
    """Run ``hil _names``. Without an answer it prints nothing, as the shell can do nothing about it."""
    kind, *words = arguments
    try:
        found = list(KINDS[kind](_parsed(words)))
    except (ControlError, IndexError, KeyError, ValueError):
        return
    sys.stdout.write("".join(f"{name}\t{about}\n" for name, about in found))


def _parsed(words: list[str]) -> TypedLine:
    """Parse words; a shell may have split ``--bench=a`` at the equals sign. Of other options only those with
    = are known to take no word, which does for the commands that ask for names by their words."""
    given: dict[str, str] = {}
    plain: list[str] = []
    left = iter([part for word in words for part in _split(word)])
    for word in left:
        if word in ("--bench", "-b", "--runtime-dir"):
            given[word.lstrip("-")[0]] = next(left, "")
        elif not word.startswith("-"):
            plain.append(word)
    runtime_dir = given.get("r")
    return TypedLine(Path(runtime_dir) if runtime_dir else None, given.get("b") or None, tuple(plain))


def _split(word: str) -> list[str]:
    if word.startswith("--"):
        return [part for part in word.split("=", 1) if part]
    return [] if word == "=" else [word]
