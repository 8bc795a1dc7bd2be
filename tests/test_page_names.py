"""What the pages name is there: make targets, extras, keys of configurations and of zenoh, names of Python;
and the benches that they show can be."""

import re
import tomllib
from collections.abc import Iterator
from dataclasses import fields
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
import yaml
from markdown_blocks import ROOT, blocks

from bridges.zenoh.keys import KEYS
from hil.compose import find_catalogue
from hil.config import parse
from hil.config.catalogue import ProfileInfo
from hil.config.dialogue_model import DialogueInfo
from hil.config.schema import schema
from hil.runs.run_document import RunDocument
from hil.toolpath.machine import MachineText
from hil.vocab.faults import FAULT_KINDS, TIMING
from hil.vocab.profile import Profile

PAGES = [
    *(
        ROOT / name
        for name in ("README.md", "CONTRIBUTING.md", "docs/tour.md", "docs/faq.md", "docs/benchmarks.md")
    ),
    *sorted((ROOT / "docs/how-to").glob("*.md")),
]
IDS = [page.stem for page in PAGES]
NO_MODULES = {"hil.bridges", "hil.buses", "hil.ports", "hil.profiles", "hil.service"}
"""Groups of entry points, and a unit of systemd."""
SAID = {"health", "rt", "limits", "master"}
"""Words with a colon that are no keys: of `hil status`, of a check, a tap's name."""
PLACEHOLDER = re.compile(r"<\w+>")


def spans(page: Path) -> list[str]:
    """Code spans of a page's sentences."""
    text = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.M | re.S)
    return [re.sub(r"\s+", " ", span) for span in re.findall(r"`([^`]+)`", text)]


def properties(part: Any) -> Iterator[str]:
    """Names of all keys in a JSON schema."""
    if isinstance(part, dict):
        yield from part.get("properties", {})
        for each in part.values():
            yield from properties(each)
    elif isinstance(part, list):
        for each in part:
            yield from properties(each)


@pytest.fixture(scope="module")
def keys() -> set[str]:
    documents = (RunDocument, MachineText, DialogueInfo)
    schemas = (schema(find_catalogue()), *(each.model_json_schema() for each in documents))
    profiles = (yaml.safe_load(file.read_text()) for file in ROOT.glob("device_profiles/*/profile.yaml"))
    of_code = {each.name for each in fields(Profile)}
    of_faults = {each.name for kind in FAULT_KINDS.values() for each in (*kind.parameters, *TIMING)}
    return of_code.union(*map(properties, schemas), *profiles, ProfileInfo.model_fields, of_faults)


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_keys_of_configurations_are_there(page: Path, keys: set[str]) -> None:
    named = {found[1] for span in spans(page) if (found := re.match(r"([a-z_]+):( |$)", span))}
    assert named - keys - SAID == set()


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_names_of_python_are_there(page: Path) -> None:
    for span in spans(page):
        name = re.match(r"(?:hil|virtual_ports|device_profiles|bridges)(?:\.\w+)+", span)
        if name and name[0] not in NO_MODULES:
            parts = name[0].split(".")
            found: Any = import_module(parts[0])
            for at, part in enumerate(parts[1:], 2):
                found = getattr(found, part, None) or import_module(".".join(parts[:at]))


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_targets_of_make_are_there(page: Path) -> None:
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.M))
    assert set(re.findall(r"(?:`|[$#] |, )make ([a-z][a-z-]*)", page.read_text())) <= targets


def test_extras_are_there() -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    named = {name for page in PAGES for name in re.findall(r"(?:hil-motion|'\.)\[(\w+)\]", page.read_text())}
    assert named
    assert named <= set(extras)


def test_keys_of_zenoh_are_there() -> None:
    known = [PLACEHOLDER.sub(r"[\\w<>*]+", key.pattern) for key in KEYS]
    roots = {pattern.partition("/")[0] for pattern in known if "/" in pattern}
    named = {
        span
        for page in PAGES
        for span in spans(page)
        if "/" in span and span.partition("/")[0] in roots and re.fullmatch(r"[\w@/<>*]+", span)
    }
    assert len(named) > 8
    assert {name for name in named if not any(re.fullmatch(key, name) for key in known)} == set()


BENCHES = [
    (page, each.heading, each.text)
    for page in PAGES
    for each in blocks(str(page.relative_to(ROOT)))
    if each.language == "yaml" and re.search(r"^bench:", each.text, re.M) and "profile_path" not in each.text
]


@pytest.mark.parametrize(("page", "heading", "text"), BENCHES, ids=[f"{p.stem}-{h}" for p, h, _ in BENCHES])
def test_benches_can_be(page: Path, heading: str, text: str) -> None:
    if page.stem not in ("add-a-port", "own-sketch"):  # a port of its own; a program that is built first
        folder = "drives" if "eds:" in text else "own_mechaduino" if "sketch:" in text else "modbus"
        parse(text, str(ROOT / "examples" / folder / "page.yaml"), find_catalogue())
