"""Configuration of a bench as an input log has it: what a replay builds the bench from."""

from typing import Any

from hil.config import BenchConfig
from hil.config.device_program import PROGRAM_KEYS
from hil.config.drive_findings import EMULATED_KEYS


def as_simulated(config: BenchConfig) -> dict[str, Any]:
    """Convert a configuration for the log, to a dict that ``hil.config.from_dict`` takes: without ports and
    real boards, whose bytes are no part of a simulation."""
    dumped: dict[str, Any] = config.model_dump(mode="json", by_alias=True)
    for device in dumped["devices"].values():
        device["port"] = "memory" if device["port"] else None
        device |= {"network": None, "ports": {}, **dict.fromkeys(PROGRAM_KEYS)}  # they are in the memories
        if device["at"]:
            for key in EMULATED_KEYS:
                device.pop(key)
    for line in (wire for key in config.bus_keys for wire in dumped[key].values()):
        for tap in line["taps"].values():
            tap["port"] = "memory"
    return dumped
