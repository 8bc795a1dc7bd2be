"""Reader of configurations: text to a validated bench, or every problem with its place.

Belongs here: the configuration's model, its checks, its JSON Schema and reference, and the difference between
two configurations. What a bus adds to them is in its folder. Pure: the caller reads the files and finds the
profiles and ports (``Catalogue``), and which motors the core refuses. Of hil.sim and
hil.wire it takes rules without state, so that a fault, a load or an address is refused here with a
running bench's words.

May import: hil.core, hil.instruments, hil.sim, hil.sketch, hil.vocab, hil.wire, the pure standard library,
ast, difflib, pathlib, posixpath, pydantic, pydantic_core, yaml.

Tests may import too: bridges.modbus.maps, hil.cli, hil.compose, hil.live, hil.runs, hil.testing,
hil.toolpath.
"""

from hil.config.catalogue import Catalogue, ProfileInfo, profile_from_yaml
from hil.config.check import from_dict, parse
from hil.config.diff import Change, diff
from hil.config.model import BenchConfig, DeviceConfig
from hil.config.port_model import PortConfig
from hil.config.reference_page import reference
from hil.config.schema import schema
from hil.vocab.problem import ConfigError

__all__ = [
    "BenchConfig",
    "Catalogue",
    "Change",
    "ConfigError",
    "DeviceConfig",
    "PortConfig",
    "ProfileInfo",
    "diff",
    "from_dict",
    "parse",
    "profile_from_yaml",
    "reference",
    "schema",
]
