"""Operations on one device (power, pins, surroundings, terminal, verbs), and on channels of wires."""

from collections.abc import Mapping
from typing import Any

from hil.live.devices.bench_devices import Devices
from hil.live.off_loop import off_loop
from hil.operations.table import Asked
from hil.sim.bench import BenchRuntime
from hil.sim.client_tap import ClientChannel
from hil.sim.input_check import channel_problem
from hil.sim.input_reading import read_field
from hil.sim.inputs import Attach, Detach, Frames, InputLogError, Play, PulseTrain, bursts_problem
from hil.vocab.address import Address
from hil.vocab.desk_protocol import AxisLook, Done
from hil.vocab.device import Doing
from hil.vocab.dialogue import DialogueError, Refusal
from hil.vocab.near_words import meant
from hil.vocab.typed_bytes import typed
from hil.vocab.verbs import Verb, VerbRefused
from hil.wire.step_dir import Train, train_problem


class ChannelOperations:
    """Operations on the channels of a bench."""

    def __init__(self, sim: BenchRuntime) -> None:
        self._sim = sim

    def attach(self, asked: Asked, node: str) -> Done:
        """Put a channel's node on a bus; answers its address, and how many frames it takes now."""
        if problem := channel_problem(self._sim, asked.target, node):
            raise VerbRefused("no_place", problem)
        at_ns = self._sim.apply_input(asked.target, Attach(node))[0]
        label = str(Address(asked.target, node))
        return Done(at_ns, {"node": label, "free": self._node(label).free})

    def detach(self, asked: Asked) -> Done:
        """Take a channel's node off its bus."""
        return Done(self._sim.apply_to(self._node(asked.target), Detach()), {})

    def transmit(self, asked: Asked, frames: list[str]) -> Done:
        """Send frames from a channel's node; answers how many were refused, and how many it takes now."""
        node = self._node(asked.target)
        if problem := node.frames_problem(frames):
            raise VerbRefused("bad_parameter", problem)
        before = node.refused
        at_ns = self._sim.apply_to(node, Frames(tuple(frames)))
        answer: dict[str, Any] = {"refused": node.refused - before, "free": node.free}
        return Done(at_ns, answer)

    def _node(self, target: str) -> ClientChannel:
        node = self._sim.taps.get(target)
        if not isinstance(node, ClientChannel):
            known = ", ".join(name for name, tap in self._sim.taps.items() if isinstance(tap, ClientChannel))
            raise VerbRefused("no_place", f"there is no channel {target!r}; there are {known or 'none'}")
        return node


EDGE_COLUMNS = 5
BURST_BYTES = 65536
"""Maximum length of one burst."""


class DeviceOperations:
    """Operations on the devices of a bench, and on its taps: each finds the device, and calls it."""

    def __init__(self, sim: BenchRuntime, devices: Devices) -> None:
        self._sim, self._devices = sim, devices

    def reset(self, asked: Asked) -> Doing:
        """Reset a device."""
        return self._devices.at(asked.target)[0].reset()

    def pin(self, asked: Asked, pin: str, level: float) -> Done:
        """Drive an input pin, whatever the firmware does: a level at a pin is there."""
        device, part = self._devices.at(asked.target)
        return device.pin(part, pin, int(level))

    def set_field(self, asked: Asked, field: str, value: Any) -> Doing:
        """Set a field of the axis; answers its value."""
        device, part = self._devices.at(asked.target)
        return device.set(part, field, value)

    def zero(self, asked: Asked) -> Done:
        """Let the shaft's angle be 0 here."""
        device, part = self._devices.at(asked.target)
        return device.zero(part)

    def type(self, asked: Asked, text: str) -> Done:
        r"""Type a text with ``\r``, ``\xHH`` and the like."""
        return self._type(asked.target, typed(text))

    def send(self, asked: Asked, data: str) -> Done:
        """Send bytes, given as hexadecimal digits."""
        return self._type(asked.target, bytes.fromhex(data))

    def _type(self, target: str, data: bytes) -> Done:
        device, uart = self._devices.at(target)
        return device.type(uart, data)

    def do(self, asked: Asked, verb: Verb, parameters: Mapping[str, float | str]) -> Doing:
        """Carry out a verb of the device's own table."""
        device, part = self._devices.at(asked.target)
        return device.do(part, verb.name, parameters)

    async def drive(self, asked: Asked, train: list[Any]) -> Done:
        """Play a pulse train; answers when it began, and its length."""
        rows = await off_loop(train, _train, train)
        device, part = self._devices.at(asked.target)  # now: the bench may have changed meanwhile
        return device.drive(part, rows)

    async def play(self, asked: Asked, bursts: list[Any]) -> Done:
        """Play bursts at a tap."""
        rows = await off_loop(bursts, _bursts, bursts)
        taps = self._sim.taps
        if asked.target not in taps:
            raise VerbRefused(
                "no_place", f"there is no tap {asked.target!r}; {meant(asked.target, list(taps))}"
            )
        return Done(self._sim.apply_to(taps[asked.target], Play(rows)), {})

    def state(self, asked: Asked) -> dict[str, float | None]:
        """State of an axis; None for what is no number."""
        device, part = self._devices.at(asked.target)
        return device.state(part)

    def packed(self, asked: Asked) -> bytes:
        device, part = self._devices.at(asked.target)
        return device.packed(part)

    def look(self, asked: Asked) -> AxisLook:
        device, part = self._devices.at(asked.target)
        return device.look(part)

    async def read_text(self, asked: Asked, reader: str, text: str, file: str) -> Mapping[str, Any] | str:
        """Read a text as the board's profile does; answers what is wrong if it is none."""
        device, part = self._devices.at(asked.target)
        info = device.info(part)
        if (read := info.readers.get(reader)) is None:
            raise VerbRefused(
                "bad_parameter", f"a {info.profile} has no reader {reader!r}; {meant(reader, info.readers)}"
            )
        try:
            return await off_loop(text, read, text, file)
        except (DialogueError, Refusal) as error:
            return str(error)

    async def wait(
        self,
        asked: Asked,
        effective_at_ns: int,
        at_most_s: float,
        ends_after_ns: float | None = None,
        set_point: float | None = None,
    ) -> dict[str, bool]:
        """Wait until what a verb began has ended; answers whether something else ended it."""
        device, part = self._devices.at(asked.target)
        return await device.wait(part, effective_at_ns, at_most_s, ends_after_ns, set_point)


def _train(rows: list[Any]) -> Train:
    if any(isinstance(row, list) and len(row) != EDGE_COLUMNS for row in rows):
        raise VerbRefused(
            "bad_parameter", f"train: write rows of {EDGE_COLUMNS}"
        )  # in logs some are left out
    train: Train = _read(PulseTrain, "train", rows)
    if problem := train_problem(train):
        raise VerbRefused("bad_parameter", problem)
    return train


def _bursts(rows: list[Any]) -> tuple[tuple[int, str], ...]:
    bursts: tuple[tuple[int, str], ...] = _read(Play, "bursts", rows)
    if any(len(digits) > 2 * BURST_BYTES for _, digits in bursts):
        raise VerbRefused("bad_parameter", f"bursts: write at most {BURST_BYTES} bytes in a row")
    if problem := bursts_problem(bursts):
        raise VerbRefused("bad_parameter", problem)
    return bursts


def _read(kind: type, field: str, rows: list[Any]) -> Any:
    try:
        return read_field(kind, field, rows)
    except InputLogError as error:
        raise VerbRefused("bad_parameter", str(error)) from None
