"""Docstrings are prose: a class that got another name leaves no trace in their sentences."""

import ast
import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).parent.parent
DOCUMENTED = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


def docstrings():
    """Docstrings of the product by file and line, and the names of all classes that are two words."""
    listed = ["git", "ls-files", "hil", "bridges", "device_profiles", "virtual_ports"]
    names, found = set(), []
    for name in subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split():
        if not name.endswith(".py") or "/tests/" in name:
            continue
        for node in ast.walk(ast.parse((ROOT / name).read_text())):
            if isinstance(node, ast.ClassDef) and re.search("[a-z][A-Z]", node.name):
                names.add(node.name)
            if isinstance(node, DOCUMENTED) and (text := ast.get_docstring(node)):
                found.append((f"{name}:{getattr(node, 'lineno', 1)}", text))
    return names, found


def documented():
    """Docstrings and texts below attributes, by file and line."""
    listed = [
        "git",
        "ls-files",
        "hil",
        "bridges",
        "device_profiles",
        "virtual_ports",
        "examples",
        "benchmarks",
    ]
    for name in subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split():
        if name.endswith((".py", ".pyi")) and "/tests/" not in name:
            for node in ast.walk(ast.parse((ROOT / name).read_text())):
                match node:
                    case ast.Expr(ast.Constant(str(text))) if text.strip():
                        yield f"{name}:{node.lineno}", text.strip()


def test_no_docstring_calls_a_thing_by_the_name_of_a_class():
    names, found = docstrings()
    assert len(names) > 300
    assert len(found) > 4000
    slips = []
    for place, text in found:
        word, _, rest = text.partition(" ")
        if word in names and rest.partition(" ")[0] in {"of", "as", "at", "with", "along", "that", "in"}:
            slips.append(f"{place}: {text.splitlines()[0]}")
    assert not slips


def test_no_docstring_begins_with_a_question() -> None:
    """A docstring names the thing or says what it does: ``Delay of an answer``, not ``How late it comes``."""
    questions = ("What", "Whether", "Who", "Whom", "Whose", "How", "Where", "Which", "When", "Why")
    asked = [
        f"{place}: {first}"
        for place, text in documented()
        if (first := text.splitlines()[0]).partition(" ")[0].rstrip(",.:;") in questions
    ]
    assert not asked
