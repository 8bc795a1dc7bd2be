"""Key ``dialogue`` of a ``profile.yaml``: its table, and the fields that its variables are."""

from typing import Any

from pydantic import ValidationError

from hil.config.board_fields import FIELDS_KEY, field_findings
from hil.config.dialogue_checks import table_findings
from hil.config.dialogue_model import DialogueInfo
from hil.config.dialogue_table import DIALOGUE, TableReader
from hil.config.dialogue_variables import field_keys, names_of
from hil.config.document import Document, Finding
from hil.config.explain import findings_of
from hil.config.own_field_model import FieldInfo
from hil.core.kinds import FIELDS_LAW
from hil.instruments.instrument_table import InstrumentTable

_OTHERS = ("law", "motor", "axis", "axes", "processor", "map", FIELDS_KEY)
"""Keys that such a board has not."""


def read_dialogue(document: Document) -> tuple[InstrumentTable | None, list[Finding]]:
    """Read the key of a document, which gets the fields that the variables are. Answers the table, None if
    there is none because of a finding."""
    value: Any = document.value
    try:
        info = DialogueInfo.model_validate(value[DIALOGUE])
    except ValidationError as error:
        found = findings_of(error, DialogueInfo, (DIALOGUE,), document)
        document.value = value | {DIALOGUE: None}
        return None, found
    findings = [
        Finding((key,), f"a board by a table has no {key}", _remedy(key), at_key=True)
        for key in _OTHERS
        if value.get(key) is not None
    ]
    uarts = value.get("uarts", {"main": {}})
    if not isinstance(uarts, dict) or len(uarts) != 1:
        remedy = "write one, as in uarts: {main: {baud: 9600}}"
        findings.append(Finding(("uarts",), "a board by a table has one serial interface", remedy))
    reader = TableReader(info, str(value.get("name", "")))
    table = reader.table()
    findings += reader.findings
    fields = field_keys(info)
    if not any("variables" in each.path or "takes" in each.path for each in findings):
        findings += _of_fields(info, fields)
        numbers = next(iter(uarts.values()), None) if isinstance(uarts, dict) else None
        baud = numbers.get("baud") if isinstance(numbers, dict) else None
        baud = baud if isinstance(baud, int) else None
        findings += table_findings(info, table, reader.rows, document.values, baud)
    rest = {key: each for key, each in value.items() if key not in _OTHERS}
    document.value = rest | ({FIELDS_KEY: {} if findings else fields})
    return table, findings


def _of_fields(info: DialogueInfo, fields: dict[str, dict[str, Any]]) -> list[Finding]:
    """Findings about the fields, at the variables that they are."""
    # The variables were checked as such: to check them again would first build another reader, 2 ms.
    made = {name: FieldInfo.model_construct(**keys) for name, keys in fields.items()}
    names = names_of(info)
    return [
        Finding((DIALOGUE, "variables", *_moved(each, names)), each.message, each.remedy, each.at_key)
        for each in field_findings(made, FIELDS_LAW, None)
    ]


def _moved(finding: Finding, names: dict[str, str]) -> tuple[str | int, ...]:
    """Path of a finding about a field below ``variables``."""
    return tuple(names.get(str(part), part) if at == 0 else part for at, part in enumerate(finding.path[1:]))


def _remedy(key: str) -> str:
    return "write them as variables of the dialogue" if key == FIELDS_KEY else "leave this key out"
