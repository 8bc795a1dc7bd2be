"""Boards outside of hil, written for a test, and benches with them."""

from pathlib import Path

import pytest

from hil.config import ConfigError
from hil.testing import Bench

YAML = """\
name: {name}
title: A board that says its name
law: mechaduino
plant: simple
uarts:
  main: {{baud: 9600}}
default_hardware: "1"
hardware:
  "1": {{supply_min_V: 8, supply_max_V: 25, inputs_5V: []}}
axis:
  inertia_kg_m2: {{value: 5.4e-6, unit: kg m2, about: Rotor., source: chosen}}
  viscous_Nm_s_per_rad: {{value: 0.004, unit: Nm s/rad, about: Friction., source: chosen}}
  torque_constant_Nm_per_A: {{value: 0.2, unit: Nm/A, about: Torque., source: chosen}}
  rotor_teeth: {{value: 50, unit: teeth, about: Teeth., source: chosen}}
  sense_resistor_ohm: {{value: 0.15, unit: ohm, about: Resistor., source: chosen}}
  start_deg: {{value: 0, unit: deg, about: Angle., source: chosen}}
  load_torque_Nm: {{value: 0, unit: Nm, about: Load., source: chosen}}
registers: {{}}
"""
BOARD = """\
from hil.vocab.profile import Profile

from .firmware import Namer

PROFILE = Profile(firmware=Namer)
"""
FIRMWARE = """\
from hil.vocab.firmware import ByteAvailable


class Namer:
    def __init__(self, board):
        self._uart = board.uart

    def main(self):
        while True:
            yield ByteAvailable()
            self._uart.read()
            self._uart.write(b"{name}")

    def interrupt(self, event):
        pass
"""


def write(folder: Path, **changed: str) -> Path:
    """Write a board; ``changed`` has other texts of its files, by their names without ends."""
    folder.mkdir(parents=True)
    (folder / "profile.yaml").write_text(changed.get("profile", YAML.format(name=folder.name)))
    (folder / "board.py").write_text(changed.get("board", BOARD))
    (folder / "firmware.py").write_text(changed.get("firmware", FIRMWARE.format(name=folder.name)))
    return folder


def bench(folder: Path, *names: str, path: str = "[boards]") -> Path:
    text = f"bench: t\nprofile_path: {path}\ndevices:\n"
    file = folder / "bench.yaml"
    file.write_text(text + "".join(f"  d{index}: {{profile: {name}}}\n" for index, name in enumerate(names)))
    return file


def answers(file: Path, device: str = "d0") -> bytes:
    with Bench(file) as made:
        made.run(ms=10)
        made.port(device).write(b"?")
        made.run(ms=100)
        return made.port(device).read()


def problems(file: Path) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        Bench(file)
    return [str(problem).replace(f"{file.parent}/", "") for problem in caught.value.problems]
