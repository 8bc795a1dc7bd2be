"""Reading of the configuration that a test gives for a bench in memory."""

from collections.abc import Mapping
from pathlib import Path

from hil.compose import find_catalogue, read_text
from hil.compose.replay import MemoryOptions
from hil.config import BenchConfig, from_dict, parse
from hil.testing.given import GivenConfig, path_of, unreadable


def read_config(config: GivenConfig) -> tuple[BenchConfig, Path]:
    """Read a configuration from a path, YAML text or a dict; answers it with the folder its files are looked
    up from.

    Raises:
        ConfigError: with every problem, or the file cannot be read.
        TypeError: it is no path, no text and no dict.
    """
    __tracebackhide__ = True
    path = path_of(config)
    catalogue = find_catalogue({"memory": MemoryOptions})
    if path:
        try:
            text = read_text(path)
        except (OSError, ValueError) as error:
            raise unreadable(path, error) from None
        return parse(text, str(path), catalogue), path.parent
    if isinstance(config, Mapping):
        return from_dict(config, catalogue), Path()
    return parse(str(config), "<text>", catalogue), Path()
