"""Every name in ``docs/follow-a-byte.md`` exists: code spans ``file: name`` and ``file: Class.name``."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "follow-a-byte.md"
MENTION = re.compile(r"`([\w/]+\.(?:py|pyx|c|h)):\s+([\w.]+)`")
MENTIONS = sorted(set(MENTION.findall(PAGE.read_text())))


def python_names(text: str) -> set[str]:
    """What a module defines at its top, and ``Class.name`` for what its classes define."""
    names: set[str] = set()

    def collect(body: list[ast.stmt], prefix: str) -> None:
        for node in body:
            if isinstance(node, ast.ClassDef):
                names.add(prefix + node.name)
                collect(node.body, f"{prefix}{node.name}.")
            elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                names.add(prefix + node.name)
            elif isinstance(node, ast.Assign):
                names.update(prefix + target.id for target in node.targets if isinstance(target, ast.Name))
            elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
                names.add(prefix + node.target.id)

    collect(ast.parse(text).body, "")
    return names


def is_defined(path: Path, name: str) -> bool:
    text = path.read_text()
    if path.suffix == ".py":
        return name in python_names(text)
    if path.suffix == ".pyx":
        return all(re.search(rf"^\s*(def|cdef class) {part}\b", text, re.M) for part in name.split("."))
    # A definition, not a call: it begins a line and its body follows.
    return re.search(rf"^\w[\w *]*\b{name}\([^;{{]*\)\s*{{", text, re.M) is not None


def test_the_page_has_names_to_check() -> None:
    assert len(MENTIONS) > 40
    assert len(MENTION.findall("`a/b.py: C.d` and `a/b.c:\n  f`, not `x.py` nor `C.d`")) == 2


@pytest.mark.parametrize(("file", "name"), MENTIONS, ids=lambda part: part)
def test_a_name_exists(file: str, name: str) -> None:
    assert (ROOT / file).is_file(), f"{PAGE.name} mentions {file}, which does not exist"
    assert is_defined(ROOT / file, name), f"{PAGE.name} mentions {name} in {file}, which does not define it"
