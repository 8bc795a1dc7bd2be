"""Text to a validated bench: reads a configuration, says what is wrong with it and where.

Belongs here: the configuration's model, its checks, its JSON Schema and reference, and the
difference between two configurations. Pure: the caller reads the files and finds the profiles and
ports (``Catalogue``). May import ``hil.vocab``, PyYAML and pydantic; never a device, a port or a
file system.
"""

from hil.config.catalogue import (
    AxisParameter,
    Catalogue,
    HardwareVersion,
    ProfileInfo,
    profile_from_yaml,
)
from hil.config.check import from_dict, parse
from hil.config.diff import Change, diff
from hil.config.model import BenchConfig, DeviceConfig, FlashConfig, PortConfig, SegmentConfig, WireConfig
from hil.config.problem import ConfigError, Problem
from hil.config.reference_page import reference
from hil.config.schema import schema

__all__ = [
    "AxisParameter",
    "BenchConfig",
    "Catalogue",
    "Change",
    "ConfigError",
    "DeviceConfig",
    "FlashConfig",
    "HardwareVersion",
    "PortConfig",
    "Problem",
    "ProfileInfo",
    "SegmentConfig",
    "WireConfig",
    "diff",
    "from_dict",
    "parse",
    "profile_from_yaml",
    "reference",
    "schema",
]
