"""Names of the code in the project's pages: a code span ``file: name`` or ``file: Class.name``."""

import ast
import re
from pathlib import Path

MENTION = re.compile(r"`([\w/]+\.(?:py|pyx|c|h)):\s+([\w.]+)`")


def definitions(path: Path) -> dict[str, ast.stmt]:
    """Names that a module defines at its top, and ``Class.name`` for what its classes define."""
    found: dict[str, ast.stmt] = {}

    def collect(body: list[ast.stmt], prefix: str) -> None:
        for node in body:
            if isinstance(node, ast.ClassDef):
                found[prefix + node.name] = node
                collect(node.body, f"{prefix}{node.name}.")
            elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                found[prefix + node.name] = node
            elif isinstance(node, ast.Assign):
                names = [target.id for target in node.targets if isinstance(target, ast.Name)]
                found.update(dict.fromkeys((prefix + name for name in names), node))
            elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
                found[prefix + node.target.id] = node

    collect(ast.parse(path.read_text()).body, "")
    return found


def is_defined(path: Path, name: str) -> bool:
    """True if a file of Python, Cython or C defines the name."""
    if path.suffix == ".py":
        return name in definitions(path)
    text = path.read_text()
    if path.suffix == ".pyx":
        return all(re.search(rf"^\s*(def|cdef class) {part}\b", text, re.M) for part in name.split("."))
    # A definition, not a call: it begins a line and its body follows.
    return re.search(rf"^\w[\w *]*\b{name}\([^;{{]*\)\s*{{", text, re.M) is not None
