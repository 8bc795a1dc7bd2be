"""The input log of a run: enough to run it again, exactly, on the virtual clock.

A text file of JSON lines. The first is the header: format, version, the program's version, the
configuration, and each device's memory at the start; the others are inputs (``inputs.encode_line``).
"""

import base64
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, TextIO

from hil.session.inputs import LOG_FORMAT, LOG_VERSION, InputLogError, Logged, decode_line, encode_line

Memories = Mapping[str, Mapping[str, bytes]]
"""Non-volatile sections of each device."""


@dataclass(frozen=True)
class InputLog:
    """A log as read back."""

    config: dict[str, Any]
    memories: dict[str, dict[str, bytes]]
    inputs: list[Logged]


class InputLogWriter:
    """Appends to an open text file. The caller flushes and closes it."""

    def __init__(self, file: TextIO, program: str, config: Mapping[str, object], memories: Memories) -> None:
        self.file = file
        nvm = {
            device: {name: base64.b64encode(data).decode() for name, data in sections.items()}
            for device, sections in memories.items()
        }
        header = {"format": LOG_FORMAT, "version": LOG_VERSION, "program": program, "config": config, "nvm": nvm}
        file.write(json.dumps(header, separators=(",", ":")) + "\n")

    def write(self, logged: Logged) -> None:
        self.file.write(encode_line(logged) + "\n")


def read_input_log(lines: Iterable[str]) -> InputLog:
    """Read a log; a last line without its end (the writer was killed) is left out.

    Raises:
        InputLogError: this is not an input log, or not of a version that is known here.
    """
    texts = list(lines)
    if texts and not texts[-1].endswith("\n"):
        texts.pop()
    try:
        header = json.loads(texts[0])
        if header["format"] != LOG_FORMAT:
            raise InputLogError("this is not an input log")
        if header["version"] != LOG_VERSION:
            raise InputLogError(f"the log has version {header['version']}; this program reads {LOG_VERSION}")
        memories = {
            device: {name: base64.b64decode(data) for name, data in sections.items()}
            for device, sections in header["nvm"].items()
        }
        return InputLog(header["config"], memories, [decode_line(text) for text in texts[1:]])
    except (ValueError, KeyError, TypeError, IndexError, AttributeError) as error:
        raise InputLogError(f"this is not an input log: {error!r}") from error
