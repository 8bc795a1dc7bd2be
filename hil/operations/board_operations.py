"""Operations on one board: power, pins, surroundings, terminal, verbs."""

import asyncio
import re
from collections.abc import Coroutine, Mapping
from functools import partial
from typing import Any

from hil.core import CoreAxis
from hil.core.axis_kind import ANGLE
from hil.core.fields import packed
from hil.live.configured import Configured
from hil.live.motion_wait import motion_ended
from hil.live.off_loop import off_loop
from hil.live.places import Places
from hil.live.runs.real_axes import RealAxes
from hil.operations.drive_operations import DriveOperations
from hil.operations.table import Asked
from hil.sim.axis_look import axis_look
from hil.sim.bench import BenchRuntime
from hil.sim.device import Device
from hil.sim.input_reading import read_field
from hil.sim.inputs import Bytes, Drive, Input, InputLogError, Pin, Play, Reset, SetField, bursts_problem
from hil.sim.motion_end import BEGINS_NS, BegunMotion
from hil.sim.settable import setting_problem
from hil.vocab.address import address_of, no_input, no_part, owner_of
from hil.vocab.axis import Axes
from hil.vocab.desk_protocol import AxisLook, Done
from hil.vocab.dialogue import DialogueError
from hil.vocab.firmware import MAIN
from hil.vocab.near_words import meant
from hil.vocab.verbs import Verb, VerbRefused
from hil.wire.step_dir import Train, train_length_ns, train_problem

EDGE_COLUMNS = 5
BURST_BYTES = 65536
"""Maximum length of one burst."""
_ESCAPES = {"r": "\r", "n": "\n", "t": "\t", "\\": "\\"}


class BoardOperations:
    """Operations on the boards of a bench. ``axes``: all of them; ``real``: those of real boards, which carry
    out dialogues."""

    def __init__(
        self,
        sim: BenchRuntime,
        places: Places,
        configured: Configured,
        axes: Axes,
        real: RealAxes,
        drives: DriveOperations,
    ) -> None:
        self._sim, self._places, self._configured = sim, places, configured
        self._axes, self._real, self._drives = axes, real, drives

    def reset(self, asked: Asked) -> Done | Coroutine[Any, Any, Done]:
        """Reset a board; a real one by a dialogue."""
        if asked.target in self._drives:
            if "reset" not in self._places.drives[asked.target].drive.verbs:
                raise VerbRefused("cannot", f"the map of {asked.target} has no control bit reset")
            return self._drives.do(asked.target, "reset", {})
        if asked.target in self._places.boards:
            return self._by_dialogue(asked.target, "reset")
        return Done(self._sim.apply_to(self._twin(asked.target), Reset()), {})

    def pin(self, asked: Asked, pin: str, level: float) -> Done:
        """Drive an input pin, whatever the firmware does: a level at a pin is there."""
        pins = self._axis(asked).pins
        if pin not in pins:
            raise VerbRefused("bad_parameter", "; ".join(no_input(asked.target, pin, pins)))
        return self._give(asked, Pin(pin, int(level)))

    def set_field(self, asked: Asked, field: str, value: Any) -> Done | Coroutine[Any, Any, Done]:
        """Set a field of the axis; answers its value."""
        if asked.target in self._drives:
            return self._drives.set_field(asked.target, field, value)
        fields = self._axis(asked).kind.settable
        if field not in fields:
            raise VerbRefused(
                "no_parameter",
                f"{asked.target} has no field {field!r} that can be set; {meant(field, fields)}",
            )
        if problem := self._setting_problem(asked, field, value):
            raise VerbRefused("bad_parameter", problem)
        return self._give(asked, SetField(field, float(value)), {field: value})

    def zero(self, asked: Asked) -> Done:
        """Let the shaft's angle be 0 here; answers what it was, and the angle that the board itself counts,
        None for one that counts none or does not count now."""
        if asked.target in self._drives:
            raise VerbRefused("cannot", f"{asked.target} is a real drive: its own homing makes its zero")
        if problem := self._setting_problem(asked, ANGLE, 0.0):
            raise VerbRefused("not_now", problem)
        shot, kind = self._sim.snapshot(asked.target), self._axis(asked).kind
        state = kind.motion(shot)
        board_deg = state.position_deg if kind.follows_paths and state.is_on else None
        answer = {"was_deg": shot.position_deg, "board_deg": board_deg}
        return self._give(asked, SetField(ANGLE, 0.0), answer)

    def _setting_problem(self, asked: Asked, field: str, value: Any) -> str | None:
        device, part = self._twin(asked.target), address_of(asked.target).part
        look = partial(self._sim.snapshot, asked.target)
        return setting_problem(self._sim.faults, device, field, value, part, look)

    def type(self, asked: Asked, text: str) -> Done:
        r"""Type a text with ``\r``, ``\xHH`` and the like."""
        return self._type(asked.target, typed(text))

    def send(self, asked: Asked, data: str) -> Done:
        """Send bytes, given as hexadecimal digits."""
        return self._type(asked.target, bytes.fromhex(data))

    def _type(self, target: str, data: bytes) -> Done:
        name, uart = address_of(target)
        if name in self._drives:
            raise self._drives.refuse(name)
        board, device = self._places.boards.get(name), self._sim.devices.get(name)
        if uart not in (device.uarts if device else ("", MAIN)):
            known = device.uarts if device else {MAIN: None}
            raise VerbRefused("no_device", no_part(name, "serial interface", uart, known))
        if device is None and board is not None:
            try:
                board.end.send(data)
            except DialogueError as error:
                raise VerbRefused("not_now", str(error)) from None
            return Done(self._sim.now_ns, {})
        device = self._twin(name)
        if device.failed:
            remedy = "reset it" if device.power.is_there else "end it"
            raise VerbRefused("failed", f"{device.failed}; {remedy}")
        if place := self._places.uarts.get(device.uarts.label(name, uart)):
            return Done(place.end.type(data), {})
        return Done(self._sim.apply_to(device, Bytes(data, port=device.uarts.short(uart))), {})

    def do(
        self, asked: Asked, verb: Verb, parameters: Mapping[str, float | str]
    ) -> Done | Coroutine[Any, Any, Done]:
        """Carry out a verb of the board's own table."""
        if asked.target in self._drives:
            return self._drives.do(asked.target, verb.name, parameters)
        if asked.target in self._places.boards:
            return self._by_dialogue(asked.target, verb.name)
        device, part = self._twin(asked.target), address_of(asked.target).part
        return Done(*self._sim.do_verb(device, verb.name, parameters, part))

    async def _by_dialogue(self, name: str, verb: str) -> Done:
        profile = self._configured.config.devices[name].profile
        if (dialogue := self._configured.catalogue.boards[profile].dialogues.get(verb)) is None:
            raise VerbRefused(
                "cannot", f"{name} is a real {profile}: its terminal has no {verb}; do it at the board"
            )
        if self._places.boards[name].end.is_held:
            raise VerbRefused("not_now", f"{name}: a run has this board; cancel it, or wait for its end")
        try:
            await self._real.carry_out(name, verb, dialogue())
        except DialogueError as error:
            raise VerbRefused("not_now", str(error)) from None
        return Done(self._sim.now_ns, {})

    async def drive(self, asked: Asked, train: list[Any]) -> Done:
        """Play a pulse train; answers when it began, and its length."""
        rows = await off_loop(train, _train, train)
        inputs = self._axis(asked).pins  # now: the bench may have changed while the rows were read
        if "step" not in inputs:
            raise VerbRefused("cannot", f"{asked.target} has no step input")
        if wrong := next((row.pin for row in rows if row.pin not in inputs), None):
            raise VerbRefused("cannot", f"{asked.target} has no input {wrong}; it has {', '.join(inputs)}")
        return self._give(asked, Drive(rows), {"length_ns": train_length_ns(rows)})

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
        if asked.target in self._drives:
            return self._drives.state(asked.target)
        state = self._sim.snapshot(asked.target).as_dict()
        return {name: value if abs(value) < float("inf") else None for name, value in state.items()}

    def packed(self, asked: Asked) -> bytes:
        if asked.target in self._drives:
            return self._drives.packed(asked.target)
        return packed(self._sim.snapshot(asked.target).values)

    def look(self, asked: Asked) -> AxisLook:
        if asked.target in self._drives:
            return self._drives.look(asked.target)
        axis, shot = self._axis(asked), self._sim.snapshot(asked.target)
        return axis_look(self._twin(asked.target), axis.kind, shot)

    async def wait(
        self,
        asked: Asked,
        effective_at_ns: int,
        at_most_s: float,
        ends_after_ns: float | None = None,
        set_point: float | None = None,
    ) -> dict[str, bool]:
        """Wait until what a verb began has ended; answers whether something else ended it."""
        if asked.target in self._drives:
            return await self._drives.wait(asked.target, effective_at_ns, at_most_s)
        sim, speed, device = self._sim, self._configured.config.speed, self._twin(asked.target)
        motion = BegunMotion(effective_at_ns, ends_after_ns, set_point)
        end_ns, interval_s = effective_at_ns + (ends_after_ns or 0), BEGINS_NS / 1e9 / speed

        def was_cut_short() -> bool | None:
            if sim.devices.get(device.name) is not device:
                return True  # a reload has taken it away
            state = self._axes[asked.target].state()
            return motion.was_cut_short(device, self._axis(asked), state, sim.now_ns)

        def pause_s() -> float:
            return max(min(interval_s, (end_ns - sim.now_ns) / 1e9 / speed), interval_s / 10)

        await asyncio.sleep(interval_s)  # what a main program does begins with its next step
        return await motion_ended(was_cut_short, lambda: sim.now_ns, effective_at_ns, at_most_s, pause_s)

    def _twin(self, address: str) -> Device:
        if (device := self._sim.devices.get(owner_of(address))) is None:
            raise VerbRefused("no_device", f"no device {address!r}; a reload has taken it away")
        return device

    def _axis(self, asked: Asked) -> CoreAxis:
        if asked.target in self._drives:
            raise self._drives.refuse(asked.target)
        if asked.target not in self._sim.roster.axes:
            raise VerbRefused("no_device", f"no axis {asked.target!r}; a reload has taken it away")
        return self._sim.roster.axis(asked.target)

    def _give(self, asked: Asked, given: Input, answer: Mapping[str, Any] | None = None) -> Done:
        return Done(self._sim.apply_input(asked.target, given)[0], answer or {})


def _train(rows: list[Any]) -> Train:
    if any(isinstance(row, list) and len(row) != EDGE_COLUMNS for row in rows):
        raise VerbRefused(
            "bad_parameter", f"train: write rows of {EDGE_COLUMNS}"
        )  # in logs some are left out
    train: Train = _read(Drive, "train", rows)
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


def typed(text: str) -> bytes:
    r"""Bytes of a text: ``\r``, ``\n``, ``\t``, ``\\`` and ``\xHH`` are one byte each.

    Raises:
        VerbRefused: something else follows a backslash, or a character is no byte.
    """

    def one(match: re.Match[str]) -> str:
        code = match[1]
        if code in _ESCAPES:
            return _ESCAPES[code]
        if code.startswith("x") and len(code) == 3:
            return chr(int(code[1:], 16))
        raise VerbRefused(
            "bad_parameter", f"text: \\{code} means nothing; write \\r, \\n, \\t, \\\\ or \\xHH"
        )

    try:
        return re.sub(r"\\(x[0-9A-Fa-f]{2}|.|$)", one, text, flags=re.S).encode("latin-1")
    except UnicodeEncodeError:
        raise VerbRefused("bad_parameter", "text: a character is no byte; write it as \\xHH") from None
