"""Names of files, which say what is in them: no two of the product have one name, and none has its
folder's."""

import ast
import re
from collections import defaultdict
from fnmatch import fnmatch
from pathlib import Path

ROOT = Path(__file__).parents[1]
ROOTS = sorted(init.parent.name for init in ROOT.glob("*/__init__.py"))
ALLOWED = {
    "*/__init__.py": "a package",
    "device_profiles/*/board.py": "hil looks for it: what the board says of itself",
    "device_profiles/*/firmware.py": "the board's program",
    "*/framing.py": "how packets are made of a line's bytes: the words, the SAC's, Modbus RTU's",
    "device_profiles/*/verbs.py": "what can be asked of the board",
    "device_profiles/*/dialogues.py": "what is typed at a real board",
    "device_profiles/*/cli.py": "the board's own commands",
    "device_profiles/*/sessions.py": "how recorded sessions with the board are written",
    "virtual_ports/*/port.py": "hil looks for it: a kind of port",
    "virtual_ports/*/segment.py": "hil looks for it: a kind of wire",
    "bridges/*/bridge.py": "hil looks for it: a kind of bridge",
    "*/bus_kind.py": "hil looks for it: a kind of bus",
    "bridges/*/testing/fixtures.py": "hil looks for it: the bus's fixtures of pytest",
    "bridges/*/cli.py": "hil looks for it: the bridge's own commands",
    "hil/core/kinds/*/kind.py": "all that hil asks of a kind of axis",
    "*/reference.py": "each has its section of docs/reference.md",
    "hil/testing/bench.py": "the kit's, to be imported by tests of others",
    "hil/testing/ports.py": "the kit's, to be imported by tests of others",
}
"""Names that several files may have, or a file and a folder, by what they say."""
STILL = {
    *("memory", "metrics", "monitor", "parameters", "verbs"),
    *("core/core", "motion/motion"),
}
"""Names that are still to be changed."""


def product() -> list[Path]:
    files = [path.relative_to(ROOT) for root in ROOTS for path in (ROOT / root).rglob("*.*")]
    return sorted(path for path in files if path.suffix in (".py", ".c") and "tests" not in path.parts)


def names_twice(files: list[Path]) -> dict[str, list[str]]:
    """Places of files that share a name, by the name, without those that are allowed."""
    places = defaultdict(list)
    for path in files:
        if not any(fnmatch(path.as_posix(), pattern) for pattern in ALLOWED):
            places[path.name].append(path.as_posix())
    return {name.partition(".")[0]: where for name, where in places.items() if len(where) > 1}


def test_no_name_twice() -> None:
    twice = names_twice(product())
    assert {name: where for name, where in twice.items() if name not in STILL} == {}


def test_no_name_of_its_folder() -> None:
    stutters = {f"{path.parent.name}/{path.stem}" for path in product() if path.stem == path.parent.name}
    assert stutters <= STILL


def test_a_second_file_of_a_name_is_found() -> None:
    new = [Path("hil/live/guard.py"), Path("hil/runs/guard.py"), Path("virtual_ports/new/port.py")]
    assert names_twice([*new, Path("virtual_ports/tcp/port.py")]) == {
        "guard": ["hil/live/guard.py", "hil/runs/guard.py"]
    }


def test_whatever_is_allowed_is_there() -> None:
    files = [path.as_posix() for path in product()]
    assert [pattern for pattern in ALLOWED if not any(fnmatch(name, pattern) for name in files)] == []


def test_a_docstring_names_files_that_are_there() -> None:
    looked_for = {pattern.rpartition("/")[2] for pattern in ALLOWED}
    gone = []
    for path in (ROOT / path for path in product() if path.suffix == ".py"):
        docstring = ast.get_docstring(ast.parse(path.read_text())) or ""
        for name in re.findall(r"``([\w/.]+\.(?:py|c|h|md))``", docstring):
            is_there = any((folder / name).exists() for folder in (path.parent, ROOT))
            if not is_there and name not in looked_for:
                gone.append(f"{path.relative_to(ROOT)}: {name}")
    assert gone == []
