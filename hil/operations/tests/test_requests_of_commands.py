"""Agreement of the requests of commands, and of the client's methods, with the tables."""

import ast
import inspect
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import hil
from hil.client.verbs import AxisVerbs
from hil.compose.find import find_boards
from hil.operations.table import OPERATIONS

ASKING = ("ask", "begin")
OWN = {"timeout_s"}
TABLES = [board.table for board in find_boards().values()]
METHODS = [
    name
    for name, method in vars(AxisVerbs).items()
    if inspect.isfunction(method) and not name.startswith("_") and name != "do"
]


def requests() -> Iterator[tuple[str, str, set[str], bool]]:
    """Requests of commands: where, the verb, the names of its arguments, and whether others are known only as
    it runs."""
    for folder in ("cli", "arduino"):
        for path in sorted((Path(hil.__path__[0]) / folder).rglob("*.py")):
            if "tests" in path.parts:
                continue
            for node in ast.walk(ast.parse(path.read_text())):
                if not isinstance(node, ast.Call):
                    continue
                called = (
                    node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
                )
                texts = [each.value for each in node.args if isinstance(each, ast.Constant)]
                if called in ASKING and texts and isinstance(texts[-1], str):
                    named = {keyword.arg for keyword in node.keywords if keyword.arg} - OWN
                    is_open = any(keyword.arg is None for keyword in node.keywords)
                    yield f"{path.name}:{node.lineno}", texts[-1], named, is_open


def test_each_request_of_a_command_fits_the_table() -> None:
    found = list(requests())
    assert len(found) > 20
    for where, verb, named, is_open in found:
        operation = OPERATIONS[verb]
        assert operation.answer is not None, where
        optional = {p.name for p in operation.parameters if p.is_optional or p.default is not None}
        assert named <= set(operation.arguments), where
        assert is_open or set(operation.arguments) - optional <= named, where


@pytest.mark.parametrize("name", METHODS)
def test_each_method_of_the_client_is_a_verb_with_its_parameters(name: str) -> None:
    tables = [table[name] for table in TABLES if name in table]
    known = {parameter.name for verb in tables for parameter in verb.parameters} | {"self", "wait"}
    signature = inspect.signature(getattr(AxisVerbs, name))
    assert {p.name for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD} <= known


def test_what_a_method_is_given_is_asked_for_by_name() -> None:
    asked: list[tuple[str, bool, dict[str, object]]] = []

    class Axis(AxisVerbs[None]):
        def do(self, verb: str, *, wait: bool = False, timeout_s: float = 0, **given: Any) -> None:
            asked.append((verb, wait, given))

    axis = Axis()
    axis.move_abs(90, acceleration=5, wait=True)
    axis.gains(pKp=12.0)
    axis.queue(3, 200, microsteps=8)
    axis.stop()
    axis.reset()
    assert asked == [
        ("move_abs", True, {"position_deg": 90, "acceleration": 5}),
        ("gains", False, {"pKp": 12.0}),
        ("queue", False, {"position": 3, "steps": 200, "microsteps": 8}),
        ("stop", False, {"how": "grace"}),
        ("reset", False, {}),
    ]
