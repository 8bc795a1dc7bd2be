"""Kinds of buses: one that hil does not have, beside those that it has."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import pytest

from hil.compose import bench_runtime, find_catalogue
from hil.config import BenchConfig, Catalogue, ConfigError, from_dict, schema
from hil.config.document import Finding
from hil.config.explain import StrictModel
from hil.config.port_model import USUAL_BAUD
from hil.testing.memory_store import MEMORY_STORE
from hil.vocab.bus import BusKind, NodeKind, NodeLine, WireKind
from hil.vocab.problem import Problem
from hil.vocab.wire import WireInfo
from hil.wire.bytes_framing import BYTES

DEVICES = {"m1": {"profile": "mechaduino"}, "m2": {"profile": "mechaduino"}}


class RingConfig(StrictModel):
    """A ring."""

    taps: Mapping[str, Any] = {}
    devices: Sequence[Any] = ()

    def members(self) -> tuple[str, ...]:
        return tuple(self.devices)


RING = BusKind(
    WireKind(
        key="rings",
        about="Rings.",
        model=lambda: RingConfig,
        findings=lambda config, devices, real: [
            Finding(("rings", name), "this ring is empty", "put a device on it")
            for name, ring in (config.get("rings") or {}).items()
            if not ring.get("devices")
        ],
        fault_places=lambda name, ring, devices: {name: {"line"}},
        info=WireInfo("rings", "ring", lambda reports: (), ()),
        add=lambda bench, config, catalogue: None,
    ),
    sections=(("## Rings: `rings.<name>`", "RingConfig"),),
)


class BeadsConfig(StrictModel):
    """Beads on a segment."""

    numbers: Mapping[str, int]


BEADS = BusKind(
    nodes=NodeKind(
        key="beads",
        about="Beads.",
        model=lambda: BeadsConfig,
        axes_key="numbers",
        findings=lambda segments, devices, real: [],
        framing=lambda line_format: BYTES,
        add=lambda bench, beads, line: ADDED.append((beads.numbers, line)),
    ),
    sections=(("## Beads: `segments.<name>.beads`", "BeadsConfig"),),
)
ADDED: list[tuple[Mapping[str, int], NodeLine]] = []


@pytest.fixture
def catalogue() -> Catalogue:
    found = find_catalogue()
    return replace(found, buses=(*found.buses, RING, BEADS))


def read(catalogue: Catalogue, **keys: object) -> BenchConfig:
    return from_dict({"bench": "t", "devices": DEVICES, **keys}, catalogue)


def test_its_key_joins_devices_and_has_targets_of_faults(catalogue: Catalogue) -> None:
    noise = {"fault": "wire_noise", "target": "r", "rate": 0.1}
    config = read(catalogue, rings={"r": {"devices": ("m1", "m2")}}, faults=[noise])
    assert config.joints() == [("m1", "m2")]
    assert list(config.bus_wires()) == ["r"]


def test_nodes_of_a_kind_are_on_a_segment_and_targets_of_faults(catalogue: Catalogue) -> None:
    noise = {"fault": "wire_cut", "target": "m2.beads"}
    config = read(catalogue, segments={"s": {"beads": {"numbers": {"m1": 3, "m2": 4}}}}, faults=[noise])
    assert config.joints() == [("m1", "m2")]
    ADDED.clear()
    bench = bench_runtime(config, catalogue, {}, MEMORY_STORE)
    ((numbers, line),) = ADDED
    assert numbers == {"m1": 3, "m2": 4}
    assert (line.segment, line.baud) == (bench.segments["s"], USUAL_BAUD)


def test_its_findings_are_problems(catalogue: Catalogue) -> None:
    with pytest.raises(ConfigError, match="this ring is empty"):
        read(catalogue, rings={"r": {}})


def test_its_key_is_unknown_without_it() -> None:
    with pytest.raises(ConfigError, match="rings"):
        read(find_catalogue(), rings={"r": {"devices": ("m1",)}})


def test_schema_has_its_key(catalogue: Catalogue) -> None:
    properties: Any = schema(catalogue)["properties"]
    assert properties["rings"]["description"] == "Rings."


def test_a_kind_that_cannot_be_used_is_a_problem() -> None:
    problem = Problem("the bus ring", 0, 0, "it is broken", "mend it")
    with pytest.raises(ConfigError, match="it is broken"):
        read(replace(find_catalogue(), bus_problems=(problem,)))
