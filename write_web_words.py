"""Writes what the editors of the page know of documents and of G-code: ``make web-types``.

Keys come from the models that check a run and a machine, words from ``hil/gcode/words.py``.
``bridges/web/tests/test_web_types.py`` holds the written file fresh.
"""

import json
from collections.abc import Iterator, Mapping
from itertools import chain
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from hil.gcode.expressions import FUNCTIONS
from hil.gcode.words import G_WORDS, LETTERS, M_WORDS, REFUSED_LETTERS, Word
from hil.runs.run_document import AXIS_PATTERN, DOCUMENT_BYTES, RunDocument
from hil.toolpath.machine import MachineText

FILE = Path(__file__).parent / "web/src/model/document_words.ts"
_HEAD = """/** Keys of documents and words of G-code. Written by `make web-types` from run_document.py,
 * machine.py and hil/gcode/words.py: change those. */

/** Key of a part. `value`: form of its value; `part`: what its mapping, or each item of its list, is made of;
 * `names`: what the keys of its mapping are. */
export interface KeyRow {
  name: string;
  about: string;
  value: "number" | "whole" | "flag" | "text" | "axis" | "field" | "input" | "choice" | "mapping";
  unit?: string;
  minimum?: number;
  maximum?: number;
  choices?: string[];
  default?: number | string | boolean | null;
  part?: string;
  names?: "axis" | "input";
  isList?: boolean;
  isRequired?: boolean;
}

/** Word of G-code, or a letter before a number. `use`: what is done with it here. */
export interface CodeWord {
  name: string;
  meaning: string;
  group?: string;
  use?: "done" | "accepted" | "refused";
  remedy?: string;
}
"""
_UNITS = {
    "_rpm_per_s2": "rpm/s²",
    "_rpm_per_s": "rpm/s",
    "_rpm": "rpm",
    "_mm_per_min": "mm/min",
    "_mm_per_s2": "mm/s²",
    "_deg_per_min": "deg/min",
    "_deg_per_s2": "deg/s²",
    "_per_mm": "1/mm",
    "deg_per_mm": "deg/mm",
    "deg_per_deg": "deg/deg",
    "_mm": "mm",
    "_deg": "deg",
    "_ms": "ms",
    "_s": "s",
}
"""Units by the ends of keys."""
_KINDS = {"pin": "input", "field": "field"}
_NAMES = {"pins": "input"}


def written() -> str:
    """Text of the file."""
    parts = dict(chain(_parts(RunDocument), _parts(MachineText)))
    tables = {
        "RUN_CHARACTERS": DOCUMENT_BYTES,
        "PARTS: Readonly<Record<string, readonly KeyRow[]>>": parts,
        "CODE_WORDS: readonly CodeWord[]": [_word(each) for each in (*G_WORDS.values(), *M_WORDS.values())],
        "CODE_LETTERS: readonly CodeWord[]": list(_letters()),
        "CODE_FUNCTIONS: readonly CodeWord[]": [
            {"name": name, "meaning": about} for name, about in FUNCTIONS.items()
        ],
    }
    return "\n".join([_HEAD, *(f"export const {name} = {_text(value)};\n" for name, value in tables.items())])


def _text(value: Any) -> str:
    """Encode with one row in a line."""
    if isinstance(value, dict):
        return "{\n" + "".join(f"{json.dumps(name)}: {_text(each)},\n" for name, each in value.items()) + "}"
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return "[\n" + "".join(f"  {json.dumps(each, ensure_ascii=False)},\n" for each in value) + "]"
    return json.dumps(value, ensure_ascii=False)


def _parts(model: type[BaseModel]) -> Iterator[tuple[str, list[dict[str, Any]]]]:
    """Parts of a document by the names of their models."""
    schema = model.model_json_schema()
    for name, part in {model.__name__: schema, **schema["$defs"]}.items():
        needed = part.get("required", [])
        yield (
            name.lstrip("_"),
            [
                {**_key(key, each), **({"isRequired": True} if key in needed else {})}
                for key, each in part["properties"].items()
            ],
        )


def _key(name: str, schema: Mapping[str, Any]) -> dict[str, Any]:
    form = next((each for each in schema.get("anyOf", ()) if each.get("type") != "null"), schema)
    row = {
        "name": name,
        "about": schema.get("description") or form.get("description", ""),
        **_form(name, form),
    }
    if "maximum" in row and (unit := _unit(name)):
        row["unit"] = unit
    plain = schema.get("default")
    if isinstance(plain, int | float | str | bool):
        row["default"] = plain
    return row


def _form(name: str, form: Mapping[str, Any]) -> dict[str, Any]:
    """Form of a value, as members of a row."""
    if reference := form.get("$ref"):
        return {"value": "mapping", "part": reference.rpartition("/")[2].lstrip("_")}
    if choices := form.get("enum"):
        return {"value": "choice", "choices": [str(each) for each in choices]}
    kind = form.get("type")
    if kind == "array":
        items = form["items"]
        return {**_form(name, items), "isList": True}
    if kind == "object":
        (values,) = (
            [form["additionalProperties"]]
            if "additionalProperties" in form
            else form["patternProperties"].values()
        )
        inner = _form(name, values)
        return {**inner, "names": _NAMES.get(name, "axis")} | (
            {} if "part" in inner else {"value": "mapping"}
        )
    if kind in ("number", "integer"):
        ends = {
            "minimum": form.get("minimum", form.get("exclusiveMinimum")),
            "maximum": form.get("maximum", form.get("exclusiveMaximum")),
        }
        return {
            "value": "whole" if kind == "integer" else "number",
            **{key: end for key, end in ends.items() if end is not None},
        }
    if kind == "boolean":
        return {"value": "flag"}
    if form.get("pattern") == AXIS_PATTERN:
        return {"value": "axis"}
    return {"value": _KINDS.get(name, "text")}


def _unit(name: str) -> str:
    if name in ("move", "move_by", "line", "line_by"):
        return "deg"
    return next((unit for end, unit in _UNITS.items() if name.endswith(end)), "")


def _word(word: Word) -> dict[str, str]:
    row = {"name": word.name, "meaning": word.meaning, "group": word.group, "use": word.use}
    return row | ({"remedy": word.remedy} if word.remedy else {})


def _letters() -> Iterator[dict[str, str]]:
    for letters, meaning in LETTERS.items():
        for letter in letters.split():
            yield {"name": letter, "meaning": meaning}
    for letter, why in REFUSED_LETTERS.items():
        yield {"name": letter.upper(), "meaning": why, "use": "refused"}


if __name__ == "__main__":
    FILE.write_text(written())
