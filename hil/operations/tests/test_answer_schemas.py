"""JSON Schemas of answers: they are schemas, and they mean what the forms mean."""

from typing import Any

import jsonschema
import pytest

from hil.net.answers import ABSENT, misfit
from hil.operations.answer_schemas import answer_schema
from hil.operations.table import OPERATIONS

JSON_ANSWERS = {name: each.answer for name, each in OPERATIONS.items() if each.answer is not None}


@pytest.mark.parametrize("name", JSON_ANSWERS)
def test_each_is_a_schema(name: str) -> None:
    jsonschema.Draft202012Validator.check_schema(answer_schema(JSON_ANSWERS[name]))


@pytest.mark.parametrize(
    ("form", "schema"),
    [
        (str, {"type": "string"}),
        ((str, None), {"type": ["string", "null"]}),
        ((True, False), {"type": "boolean"}),
        ((None, "stands", "moves"), {"enum": ["stands", "moves", None]}),
        ((0, 1), {"enum": [0, 1]}),
        ([float], {"type": "array", "items": {"type": "number"}}),
        ({str: int}, {"type": "object", "additionalProperties": {"type": "integer"}}),
    ],
)
def test_schemas_of_forms(form: Any, schema: dict[str, Any]) -> None:
    assert answer_schema(form) == schema


def test_a_key_that_may_not_be_there() -> None:
    schema = answer_schema({"run": str, "state": ABSENT})
    jsonschema.validate({"run": "r"}, schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({"run": "r", "state": "done"}, schema)


@pytest.mark.parametrize(
    ("verb", "answer"),
    [
        ("inject", {"number": 1}),
        ("inject", {"number": "1"}),
        ("inject", {}),
        ("samples", {"rows": [[1, 2.5]], "lost": 0, "sim_ns": 5}),
        ("samples", {"rows": [[1, None]], "lost": 0}),
        ("state", {"a": 1.5, "b": None}),
        ("state", {"a": True}),
        ("wait", {"interrupted": 1}),
        ("run", {"run": "r", "steps": 1}),
        ("run", {"problems": "none"}),
        ("reload", {"problems": 1}),
        ("do", {"a": None, "b": [1]}),
    ],
)
def test_a_schema_takes_what_its_form_takes(verb: str, answer: Any) -> None:
    validator = jsonschema.Draft202012Validator(answer_schema(JSON_ANSWERS[verb]))
    assert validator.is_valid(answer) is not bool(misfit(verb, answer))
