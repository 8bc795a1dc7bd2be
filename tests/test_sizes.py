"""Sizes of the product's classes and functions: what can be read at once."""

import ast
from collections.abc import Iterator
from functools import cache
from itertools import chain
from pathlib import Path

ROOT = Path(__file__).parents[1]
FOLDERS = ("hil", "bridges", "device_profiles", "virtual_ports")
MOST_LINES, MOST_LINES_OF_MODULE = 200, 400
P90_OF_FUNCTIONS = 17
GENERATED = ("hil/core/abi.py",)
"""Tables that a command writes."""
REASON = "\n\nLong because "
"""Beginning of the paragraph with which a longer class says why it is one."""


@cache
def trees() -> dict[str, ast.Module]:
    """Modules that are read by people, by path; without tests and the native core's."""
    paths = chain.from_iterable((ROOT / folder).rglob("*.py") for folder in FOLDERS)
    names = {str(path.relative_to(ROOT)): path for path in sorted(paths)}
    return {
        name: ast.parse(path.read_text())
        for name, path in names.items()
        if not {"tests", "native", "build"} & set(path.parts) and name not in GENERATED
    }


def nodes(*kinds: type[ast.AST]) -> Iterator[tuple[str, ast.AST]]:
    for name, tree in trees().items():
        yield from ((name, node) for node in ast.walk(tree) if isinstance(node, kinds))


def lines_of(node: ast.AST) -> int:
    assert isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef)
    assert node.end_lineno
    return node.end_lineno - node.lineno + 1


def test_a_long_class_says_why_it_is_one() -> None:
    silent = {
        f"{name}: {node.name}": lines_of(node)
        for name, node in nodes(ast.ClassDef)
        if isinstance(node, ast.ClassDef)
        and lines_of(node) > MOST_LINES
        and REASON not in (ast.get_docstring(node) or "")
    }
    assert silent == {}


def test_most_functions_are_short() -> None:
    lengths = sorted(lines_of(node) for _, node in nodes(ast.FunctionDef, ast.AsyncFunctionDef))
    assert lengths[int(len(lengths) * 0.9)] <= P90_OF_FUNCTIONS


def test_no_module_is_long() -> None:
    lengths = {name: len((ROOT / name).read_text().splitlines()) for name in trees()}
    assert {name: lines for name, lines in lengths.items() if lines > MOST_LINES_OF_MODULE} == {}
