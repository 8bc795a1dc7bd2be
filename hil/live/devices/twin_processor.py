"""Processor of a twin, as ``hil.vocab.device.DeviceProcessor``."""

from collections.abc import Callable, Sequence
from typing import Any

from hil.core.core_processor import DATA_BYTES, CoreProcessor
from hil.live.chip_debugging import ChipDebugging
from hil.sim.bench import BenchRuntime
from hil.sim.debugger import NO_DEBUGGER
from hil.sim.inputs import LoadProgram
from hil.sim.twin import Twin
from hil.sketch.chip import BOOT_START
from hil.sketch.chip_program import SECTION, ChipProgram, flash_program, unpacked
from hil.vocab.desk_protocol import Done
from hil.vocab.verbs import VerbRefused


class TwinProcessor:
    """Processor of a twin."""

    def __init__(self, sim: BenchRuntime, device: Twin) -> None:
        self._sim, self._device = sim, device
        self._processor: CoreProcessor = device.processor

    def look(self) -> dict[str, Any]:
        processor = self._processor
        with self._sim.present(self._device):
            program = self._program()
            return {
                "device": self._device.name,
                "program": program.title if program else "",
                "flash": flash_program("", processor.flash[:BOOT_START]).flash.hex(),
                "is_running": processor.is_running,
                "is_halted": processor.debug.is_halted,
                "crystal_Hz": processor.clock_Hz,
                "cycles": processor.cycles,
                "pc": processor.program_counter,
                "stack_lowest": processor.debug.stack_lowest,
                "data": processor.data(0, DATA_BYTES).hex(),
                "pins": self._pins(),
                "symbols": [list(symbol) for symbol in program.symbols] if program else [],
            }

    def _program(self) -> ChipProgram | None:
        """Program that the chip holds, if the memory knows it."""
        try:
            program = unpacked(self._device.nvm[SECTION])
        except (KeyError, ValueError):
            return None
        return program if self._processor.flash.startswith(program.flash) else None

    def _pins(self) -> dict[str, dict[str, Any]]:
        axis = next(iter(self._device.processors))
        return {name: self._processor.pin(name)._asdict() for name in self._device.axes[axis].pins}

    def load(self, program: bytes) -> Done:
        return Done(self._sim.apply_to(self._device, LoadProgram(program.hex())), {})

    def count(self, starts: Sequence[int], lap_at: int | None) -> None:
        with self._sim.present(self._device):
            self._processor.debug.count(starts, lap_at)

    def counted(self) -> dict[str, Any]:
        with self._sim.present(self._device):
            cycles, rows = self._processor.debug.counted()
            return {"cycles": cycles, "rows": [list(row) for row in rows], "laps": self._processor.debug.laps}

    def debugging(self, stand: Callable[[bool], None]) -> ChipDebugging:
        name = self._device.name
        if not self._sim.real_time.is_on:
            raise VerbRefused("cannot", "the time of a bench in memory is its test's")
        if not self._processor.is_running:
            load = f"`hil sketch load {name} FILE` gives it one"
            raise VerbRefused("not_now", f"{name} runs no compiled program now; {load}")
        if self._device.debugger is not NO_DEBUGGER:
            raise VerbRefused("not_now", f"another GDB debugs {name}; end it first")
        return ChipDebugging(self._sim, self._device, stand)
