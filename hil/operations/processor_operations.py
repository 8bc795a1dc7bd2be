"""Operations on the processor of a device, which runs a user's program."""

import base64
import binascii
from functools import partial
from typing import Any

from hil.live.configured import Configured
from hil.live.devices.bench_devices import Devices
from hil.live.off_loop import off_loop
from hil.live.standing_time import StandingTime
from hil.operations.table import Asked
from hil.sketch.chip_program import ChipProgram, packed, read_program
from hil.sketch.program_error import ProgramError
from hil.vocab.address import owner_of
from hil.vocab.desk_protocol import Done
from hil.vocab.device import DeviceProcessor, ProcessorSession
from hil.vocab.verbs import VerbRefused


class ProcessorOperations:
    """Operations on processors: each finds the device, and asks it."""

    def __init__(self, devices: Devices, configured: Configured, time: StandingTime) -> None:
        self._devices, self._configured, self._time = devices, configured, time

    def _at(self, asked: Asked) -> DeviceProcessor:
        return self._devices.at(asked.target)[0].processor()

    def processor(self, asked: Asked) -> dict[str, Any]:
        """Describe what is in the chip now, and who is wired to its pins."""
        seen = self._at(asked).look()
        for row in seen["pins"].values():
            row["wired"] = []
        for wire in self._configured.config.wires:
            for (address, pin), other in zip(wire.ends(), (wire.to, wire.from_), strict=True):
                if owner_of(address) == asked.target and pin in seen["pins"]:
                    seen["pins"][pin]["wired"].append(other)
        return seen

    async def load_program(self, asked: Asked, program: str, file: str) -> Done:
        """Load a program, an Intel HEX or ELF file, into the chip; it starts as after a power-up."""
        self._at(asked)
        try:
            given = await off_loop(program, _read, file, program)
        except ProgramError as error:
            raise VerbRefused("bad_parameter", str(error)) from None
        done = self._at(asked).load(packed(given))  # of now: the bench may have changed meanwhile
        return Done(done.effective_at_ns, {"program": given.title})

    def count(self, asked: Asked, starts: list[int], lap_at: int) -> dict[str, Any]:
        """Count from now on where the processor's time goes."""
        self._at(asked).count(sorted(starts), lap_at if lap_at >= 0 else None)
        return {}

    def counted(self, asked: Asked) -> dict[str, Any]:
        """Answer what was counted since then."""
        return self._at(asked).counted()

    def debug(self, asked: Asked) -> ProcessorSession:
        """Make a session for GDB, which begins when there is a connection for it."""
        return self._at(asked).debugging(partial(self._time.note, asked.target))


def _read(file: str, program: str) -> ChipProgram:
    try:
        content = base64.b64decode(program, validate=True)
    except (binascii.Error, ValueError):
        raise VerbRefused("bad_parameter", "program: write the file's content in base64") from None
    return read_program(file, content)
