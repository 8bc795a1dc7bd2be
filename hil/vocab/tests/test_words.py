"""Vocabulary: it has words and no behaviour."""

import ast
from pathlib import Path

import pytest

MODULES = sorted(Path(__file__).parents[1].glob("*.py"))
FORMS = {
    "time": {"ms"},  # a number in the unit that its name says
    "address": {"address_of", "owner_of", "pin_of", "no_part", "no_input"},  # how a name is spelled
    "problem": {"not_text"},  # what is wrong with a file, in one form
    "parameters": {"filled", "plain"},  # what a Parameter means, for several
    "fault_words": {"example", "group_of", "shown_by"},  # how a kind of fault is told
    "typed_numbers": {  # what a text says of a number, for every door that takes one
        *("typed_number", "number_problem", "_unit_problem", "_is_with_unit"),
        *("unit_in", "unit_said", "is_unit", "quoted", "plain_number"),
    },
    "near_words": {
        "nearest",
        "nearest_or_begun",
        "nearest_or_longer",
        "did_you_mean",
        "meant",
        "_plain",
    },  # what a word that was mistyped means
    "line_format": {"format_named"},  # how a format is spelled
    "packed_fields": {"struct_of", "value_at"},  # what a layout means, for all who read one
    "port_programs": {"port_use", "is_held"},  # which row of the table is a port's
    "operation": {"urgency_of", "moved_by"},  # how urgent a request is, and what it moves
    "bench_labels": {"has_labels", "is_label_value", "wanted_label"},  # how labels are spelled and compared
    "lease": {"time_said"},  # how a time is said in a refusal
    "seen_over": {"seen_over"},  # how a figure is shown beside its limit
    "segment": {"speed_notes"},  # which speeds of a line do not go together
    "typed_bytes": {"typed"},  # how bytes are spelled where people type them
    "shown_text": {"printable", "printable_lines", "_escaped"},  # how a text from outside is shown
    "drive_words": {
        "cells_of",
        "cells_text",
        "is_finite",
        "_number",
    },  # how a text has cells and their numbers
    "verbs": {"checked", "described", "table_of"},
    "text_digest": {"text_digest"},  # what a run or a drawing is known by
    "late_dataclass": {"make_later"},  # when the dataclasses of all words are made
    "wire": {"one_of", "errors_of", "counted"},  # how a wire tells its counters, for all buses
}
"""Functions that are part of a word's meaning."""


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.stem)
def test_a_module_defines_words(path: Path) -> None:
    body = ast.parse(path.read_text()).body
    functions = {node.name for node in body if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)}
    assert functions <= FORMS.get(path.stem, set())
    for node in body:
        if isinstance(node, ast.ClassDef) and "Protocol" not in map(ast.unparse, node.bases):
            methods = [item for item in node.body if isinstance(item, ast.FunctionDef)]
            assert sum(len(ast.unparse(item).splitlines()) for item in methods) < 60, node.name
