"""Bridges, checked against the kinds that exist and by each one's own model."""

import json
from collections.abc import Mapping

from pydantic import BaseModel, ValidationError

from hil.config.document import Document, Finding
from hil.config.explain import findings_of, shown, suggestion


def read_bridges(
    raw: Mapping[str, object], kinds: Mapping[str, type[BaseModel]], document: Document
) -> tuple[dict[str, BaseModel], list[Finding]]:
    """The options of each bridge, and what is wrong with them. ``~`` stands for the defaults."""
    options: dict[str, BaseModel] = {}
    findings: list[Finding] = []
    for name, given in raw.items():
        path = ("bridges", name)
        if name not in kinds:
            findings.append(
                Finding(path, f"there is no bridge {shown(name)}", suggestion(name, kinds), at_key=True)
            )
            continue
        if given is not None and not isinstance(given, Mapping):
            findings.append(
                Finding(path, f"options are wanted here, not {shown(given)}", "write {} for none")
            )
            continue
        try:
            # As JSON, so that strict still reads a path or an enumeration from text.
            options[name] = kinds[name].model_validate_json(json.dumps(dict(given or {})), strict=True)
        except ValidationError as error:
            findings += findings_of(error, kinds[name], path, document)
    return options, findings
