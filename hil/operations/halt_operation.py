"""Stop of all that moves on a bench: its runs, and its axes."""

import asyncio
from collections.abc import Coroutine, Iterator
from dataclasses import dataclass
from typing import Any

from hil.live.devices.bench_devices import Devices
from hil.live.runs.queue import RunQueue
from hil.operations.table import Asked
from hil.vocab.address import address_of
from hil.vocab.axis import CONTROL_MODES, TURNS_RPM, How
from hil.vocab.desk_protocol import Done
from hil.vocab.device import Device, Doing
from hil.vocab.near_words import meant as meant_word
from hil.vocab.operation import OFF_VERB, STOP_VERB
from hil.vocab.verbs import HOW_TO_STOP, VerbRefused

CONFIRM_S = 5.0
"""Maximum time for real boards to say that they have stopped."""
_TURNS_ON = frozenset(ord(CONTROL_MODES[mode]) for mode in ("velocity", "torque"))
"""Values of ``mode`` in which a servo turns on, as long as its set-point is not 0."""
_STEP = "step"
"""Input of boards that follow pulses."""


@dataclass(frozen=True)
class HaltOperation:
    """Stop of all: everything is told to stop before anything is awaited."""

    devices: Devices
    queue: RunQueue

    def halt(self, asked: Asked, how: How, axes: list[str] | None = None) -> Any:
        """End all runs and stop all axes that move, or do not tell; answers what was stopped. ``axes``: only
        these, of a device all; and only the runs that have one of them.

        Raises:
            VerbRefused: one of them is not there; nothing is stopped.
        """
        meant = self._meant(axes) if axes else None
        runs = [name for name, progress in list(self.queue.progress.items()) if not progress.is_over]
        if meant is not None:
            runs = [name for name in runs if not meant.isdisjoint(self.queue.devices_of(name))]
        held = {device for name in runs for device in self.queue.devices_of(name)}
        stopped, refused = list[str](), dict[str, str]()
        waits: dict[str, Coroutine[Any, Any, Done]] = {}
        for name in runs:
            self.queue.cancel(name, how)
        for address, device, part in self._axes():
            if address in held:
                stopped.append(address)  # by its run, on its path
                continue
            if meant is not None and address not in meant:
                continue
            try:
                if isinstance(doing := _stopped(device, part, how), Done):
                    stopped.append(address)
                elif doing:
                    waits[address] = doing
            except VerbRefused as refusal:
                refused[address] = str(refusal)
        answer = {"stopped": stopped, "runs": runs, "refused": refused}
        return _confirmed(waits, answer) if waits else answer

    def _meant(self, names: list[str]) -> set[str]:
        """Find addresses of axes by their names, of a device by its own. Raises VerbRefused."""
        own: dict[str, list[str]] = {}
        for address, device, _ in self._axes():
            own.setdefault(device.name, []).append(address)
            own[address] = own.get(address, [address])
        if wrong := [name for name in names if name not in own]:
            whys = [f"there is no axis {name!r}; {meant_word(name, list(own))}" for name in wrong]
            raise VerbRefused("no_device", "; ".join(whys))
        return {address for name in names for address in own[name]}

    def _axes(self) -> Iterator[tuple[str, Device, str]]:
        for device in list(self.devices.values()):
            for address in device.addresses():
                yield address, device, address_of(address).part


def _stopped(device: Device, part: str, how: How) -> Doing | None:
    """Stop an axis, by its verb, or by ending the pulses that drive it. None: it stands.

    Raises:
        VerbRefused: it does not stop.
    """
    info = device.info(part)
    if not info.is_seen and _holds(device):
        return None
    moves = not info.is_seen or _moves(device, part)
    if verb := info.verbs.get(STOP_VERB):
        has_how = any(parameter.name == HOW_TO_STOP.name for parameter in verb.parameters)
        return device.do(part, STOP_VERB, verb.filled({"how": how} if has_how else {})) if moves else None
    if not info.is_seen and OFF_VERB in info.verbs:
        return _switched_off(device, part, how)
    if _STEP not in info.inputs:
        return None
    ended = device.drive(part, ())
    return ended if moves else None


def _holds(device: Device) -> bool:
    """True for a real board that hil brought where it stands, and at which nobody has typed since."""
    return any(not now.tells_position and now.why_not is None for now in device.axes().values())


def _switched_off(device: Device, part: str, how: How) -> Doing:
    """Take the current off a real board whose terminal has no stop: a load may fall, so ``grace`` leaves it
    to who asks.

    Raises:
        VerbRefused: it may move.
    """
    if how == "prejudice":
        return device.do(part, OFF_VERB, {})
    why = next((now.why_not for now in device.axes().values()), None) or "what it does is not known"
    remedy = f"`hil axis {device.name} {OFF_VERB}` takes its current off"
    raise VerbRefused("cannot", f"{why}, and its terminal has no stop; {remedy}")


def _moves(device: Device, part: str) -> bool:
    """True if an axis moves or is going to, by what it was given or by pulses."""
    motion = device.look(part).motion
    if motion.is_on is False:
        return False
    state = device.state(part)
    # the shaft may stand for now: at the first moments of a speed, at a turn back, against a stop
    turns_on = motion.is_on and state.get("mode") in _TURNS_ON and bool(motion.commanded_deg)
    is_turning = abs(state.get("velocity_rpm") or 0.0) > TURNS_RPM
    return motion.is_moving or motion.is_under_way or turns_on or is_turning


async def _confirmed(waits: dict[str, Coroutine[Any, Any, Done]], answer: dict[str, Any]) -> dict[str, Any]:
    """Answer when all that were told to stop have confirmed it, or have not in time."""

    async def confirm(address: str, doing: Coroutine[Any, Any, Done]) -> None:
        try:
            async with asyncio.timeout(CONFIRM_S):
                await doing
        except TimeoutError:
            why = f"it was told to stop, and has not confirmed it within {CONFIRM_S:g} s"
            answer["refused"][address] = why
        except VerbRefused as refusal:
            answer["refused"][address] = str(refusal)
        else:
            answer["stopped"].append(address)

    async with asyncio.TaskGroup() as group:
        for address, doing in waits.items():
            group.create_task(confirm(address, doing))
    return answer
