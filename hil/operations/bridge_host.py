"""The daemon as bridges and the control socket see it: the one place where a verb is carried out."""

import asyncio
import re
from collections.abc import Callable, Coroutine, Iterator, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from hil.compose.find import load_dialogues, load_verbs
from hil.config import ConfigError
from hil.config.explain import suggestion
from hil.core.fields import FIELDS, OF_KIND, OFFSETS, SERVO, packed
from hil.live import real_boards
from hil.live.captures import watch_segment
from hil.live.changes import Changed
from hil.operations.health import health
from hil.operations.metrics import readings
from hil.operations.segments import listed as listed_segments
from hil.runs import How, Progress
from hil.sim.inputs import Pin, Reset, SetField
from hil.sim.settable import SETTABLE, setting_problem
from hil.telemetry import Sampler
from hil.vocab.bridges import AxisField, DeviceInfo, Done, Source
from hil.vocab.dialogue import DialogueError
from hil.vocab.faults import FaultRefused
from hil.vocab.metrics import Reading
from hil.vocab.segment import SegmentEvent
from hil.vocab.verbs import Verb, VerbRefused

if TYPE_CHECKING:
    from hil.daemon import Daemon

STATE = (
    *("at_ns", "position_deg", "yw", "velocity_rpm", "torque_Nm"),
    *("loop_on", "mode", "r", "u", "following"),
    *("commanded_deg", "lag_steps", "lost_steps", "motion_state", "speed_rpm", "queue_position", "pending"),
)
"""What most want to see of an axis; each kind has some of them."""
_POLL_NS = 20_000_000
_ESCAPES = {"r": "\r", "n": "\n", "t": "\t", "\\": "\\"}


class Host:
    """``hil.vocab.bridges.BridgeHost`` of a daemon that has been built."""

    def __init__(self, daemon: "Daemon") -> None:
        self._daemon = daemon
        self.bench = daemon.config.bench
        self.segments: Sequence[str] = list(daemon.bench.segments)
        self.devices = {name: self._info(name) for name in daemon.config.devices}
        daemon.changes.at_once(self._refresh)

    def _refresh(self, changed: Changed) -> None:
        begun = changed.begun
        known = dict(self.devices)
        self.devices.clear()
        for name in self._daemon.config.devices:
            self.devices[name] = self._info(name) if name in begun else known[name]

    @property
    def ports(self) -> Sequence[str]:
        return list(self._daemon.places)

    def _info(self, name: str) -> DeviceInfo:
        profile = self._daemon.config.devices[name].profile
        if name in self._daemon.config.real:
            dialogues = load_dialogues(profile)
            table = load_verbs(profile).table
            verbs = {verb: each for verb, each in table.items() if verb == "type" or verb in dialogues}
            return DeviceInfo(name, profile, True, verbs, {})
        device = self._daemon.bench.devices[name]
        fields = {
            field: AxisField(
                field,
                FIELDS[field].type,
                FIELDS[field].unit,
                FIELDS[field].meaning,
                OFFSETS[field],
                field in SETTABLE,
                field in STATE,
            )
            for field in OF_KIND[device.axis.kind]
        }
        return DeviceInfo(name, profile, False, load_verbs(profile).table, fields)

    def times_ns(self) -> tuple[int, int]:
        now_ns = self._daemon.bench.now_ns
        return now_ns, self.wall_ns(now_ns)

    def wall_ns(self, sim_ns: int) -> int:
        return self._daemon.clock.wall_ns(sim_ns)

    async def wait_until_done(self, device: str, done: Done, at_most_s: float) -> str | None:
        bench, speed = self._daemon.bench, self._daemon.config.speed
        asked = bench.devices.get(device)
        last_ns = done.effective_at_ns + round(at_most_s * 1e9)
        end_ns = int(done.effective_at_ns + done.answer.get("ends_after_ns", 0))
        pause_s = _POLL_NS / 1e9 / speed
        await asyncio.sleep(pause_s)  # what a main program does begins with its next step
        while bench.devices.get(device) is asked and self._is_under_way(device, end_ns):
            if bench.now_ns >= last_ns:
                return None
            await asyncio.sleep(max(min(pause_s, (end_ns - bench.now_ns) / 1e9 / speed), pause_s / 10))
        if bench.devices.get(device) is not asked:
            return "interrupted"  # a reload has taken it away
        wanted = done.answer.get("set_point")
        is_other = wanted is not None and abs(bench.snapshot(device).r - wanted) > abs(wanted) * 1e-6 + 1e-4
        return "interrupted" if is_other and "ends_after_ns" in done.answer else "ended"

    def _is_under_way(self, name: str, end_ns: int) -> bool:
        """Whether what a verb began goes on, as the board's state tells."""
        bench, device = self._daemon.bench, self._daemon.bench.devices[name]
        if device.failed:
            return False
        state = bench.snapshot(name)
        if device.axis.kind == SERVO:
            return device.is_busy or (bool(state.following) and bench.now_ns < end_ns + _POLL_NS)
        return bool(state.motion_state or state.pending)

    def packed(self, device: str) -> bytes:
        self._twin(device)
        return packed(self._daemon.bench.snapshot(device).values)

    def state(self, device: str) -> Mapping[str, float]:
        self._twin(device)
        return self._daemon.bench.snapshot(device).as_dict()

    def sample(self, device: str, interval_ns: int | Fraction) -> "Sampling":
        self._twin(device)
        try:
            return Sampling(self._daemon.watches.sampler, device, interval_ns)
        except ValueError as error:
            raise VerbRefused("bad_parameter", str(error)) from None

    async def do(self, source: Source, device: str, verb: str, given: Mapping[str, object]) -> Done:
        done = self.do_now(source, device, verb, given)
        if done is not None:
            return done
        known = self.devices[device].verbs[verb]
        return await self._do_real(device, known, known.filled(given))

    def do_now(self, source: Source, device: str, verb: str, given: Mapping[str, object]) -> Done | None:
        info = self._known(device)
        if verb not in info.verbs:
            raise VerbRefused(
                "no_verb", f"{device}, a {info.profile}, has no {verb!r}; {suggestion(verb, info.verbs)}"
            )
        known = info.verbs[verb]
        if source.role < known.role:
            raise VerbRefused("forbidden", f"{verb} needs the role {known.role.name.lower()}")
        parameters = known.filled(given)
        return None if info.is_real else self._do_twin(device, known, parameters)

    async def _do_real(self, device: str, verb: Verb, parameters: Mapping[str, float | str]) -> Done:
        try:
            if verb.name == "type":
                self._daemon.places.boards()[device].end.send(typed(str(parameters["text"])))
            else:
                daemon = self._daemon
                await real_boards.carry_out(
                    daemon.configured, daemon.places, daemon.real_axes, device, verb.name
                )
        except (DialogueError, real_boards.NoDialogue) as error:
            raise VerbRefused("not_now", str(error)) from None
        return Done(self._daemon.bench.now_ns, {})

    def _do_twin(self, name: str, verb: Verb, parameters: Mapping[str, float | str]) -> Done:
        bench = self._daemon.bench
        device = bench.devices[name]
        if verb.run or verb.types:
            return Done(*bench.do(device, verb.name, parameters))
        if verb.name == "reset":
            return Done(bench.give(device, Reset()), {})
        if device.failed:
            raise VerbRefused("failed", f"{device.failed}; {'reset it' if device.has_power else 'end it'}")
        if verb.name == "pin":
            pin = str(parameters["pin"])
            if pin not in device.axis.pins:
                raise VerbRefused("bad_parameter", f"pin: inputs of {name} are {', '.join(device.axis.pins)}")
            return Done(bench.give(device, Pin(pin, int(parameters["level"]))), {})
        return Done(self._daemon.places.uarts()[name].end.type(typed(str(parameters["text"]))), {})

    def set_field(self, source: Source, device: str, name: str, value: object) -> Done:
        self._twin(device)
        info = self.devices[device]
        if name not in info.fields or not info.fields[name].is_settable:
            settable = [field.name for field in info.fields.values() if field.is_settable]
            raise VerbRefused("no_parameter", f"{name!r} cannot be set; {suggestion(name, settable)}")
        twin = self._daemon.bench.devices[device]
        if problem := setting_problem(self._daemon.bench.faults, twin, name, value):
            raise VerbRefused("bad_parameter", problem)
        assert isinstance(value, int | float)
        at_ns = self._daemon.bench.give(twin, SetField(name, float(value)))
        return Done(at_ns, {name: value})

    def fault(self, source: Source, target: str, given: Mapping[str, object]) -> Mapping[str, Any]:
        registry = self._daemon.faults
        parameters = dict(given)
        try:
            if "clear" in parameters:
                which = parameters.pop("clear")
                on_it = [
                    row["number"] for row in registry.listed() if f"{row['target']}.".startswith(f"{target}.")
                ]
                chosen = on_it if which == "all" else [number for number in on_it if which == number]
                if parameters or isinstance(which, bool) or (which != "all" and not chosen):
                    raise VerbRefused(
                        "bad_parameter", f'clear: write "all" or one of {on_it}, and nothing beside it'
                    )
                for number in chosen:
                    registry.clear(number)
                return {"cleared": chosen}
            kind = parameters.pop("fault", None)
            if not isinstance(kind, str):
                raise VerbRefused("bad_parameter", "fault: its kind is missing; `hil fault kinds` lists them")
            at = parameters.pop("target", target)
            if not isinstance(at, str) or at.partition(".")[0] != target.partition(".")[0]:
                raise VerbRefused("bad_parameter", f"target: {target}, or something of it")
            return {"number": registry.inject(kind, at, parameters)}
        except FaultRefused as error:
            raise VerbRefused("bad_parameter", str(error)) from None

    def sim_ns(self, wall_ns: int) -> int:
        """The simulated time at one of the wall, as ``wall_ns`` tells it."""
        return self._daemon.clock.sim_ns(wall_ns)

    def submit_run(
        self, source: Source, text: str
    ) -> Mapping[str, Any] | Coroutine[Any, Any, Mapping[str, Any]]:
        try:
            submitted = self._daemon.runs.submit(source, text)
        except ConfigError as error:
            raise VerbRefused("bad_run", str(error)) from None
        return submitted.result().as_dict() if submitted.done() else self._submitted(submitted)

    @staticmethod
    async def _submitted(submitted: asyncio.Future[Progress]) -> Mapping[str, Any]:
        try:
            return (await submitted).as_dict()
        except ConfigError as error:
            raise VerbRefused("bad_run", str(error)) from None

    def part_of_run(
        self, source: Source, name: str, given: Mapping[str, Any]
    ) -> Coroutine[Any, Any, Mapping[str, Any]]:
        return self._daemon.parts.answer(source, name, given)

    def run_progress(self, name: str) -> Mapping[str, Any] | None:
        progress = self._daemon.runs.progress.get(name)
        return None if progress is None else progress.as_dict()

    def run_names(self) -> Sequence[str]:
        return list(self._daemon.runs.progress)

    def cancel_run(self, source: Source, name: str, how: object) -> Mapping[str, Any]:
        if how not in ("grace", "prejudice"):
            raise VerbRefused("bad_parameter", "how: write grace or prejudice")
        chosen: How = "grace" if how == "grace" else "prejudice"
        return self._daemon.runs.cancel(source, name, chosen).as_dict()

    def on_run(self, call: Callable[[Mapping[str, Any]], None]) -> Callable[[], None]:
        def tell(progress: Progress) -> None:
            call(progress.as_dict())

        listeners = self._daemon.runs.listeners
        listeners.append(tell)
        return lambda: listeners.remove(tell)

    def segment_stats(self, segment: str) -> Mapping[str, Any]:
        return next(row for row in listed_segments(self._daemon) if row["segment"] == segment)

    def health(self) -> Mapping[str, Any]:
        rt = self._daemon.bench.core.native.rt_stats()
        devices = self._daemon.bench.devices.values()
        return {
            "rt": self._daemon.grant.state if self._daemon.grant else "starting",
            "ticks": rt["ticks"],
            "missed": rt["missed"],
            "overruns": rt["overruns"],
            "failed": {device.name: device.failed for device in devices if device.failed},
            "starved": {device.name: n for device in devices if (n := device.setpoints.starved)},
        } | health(self._daemon)

    def metrics(self) -> Iterator[Reading]:
        return readings(self._daemon)

    def on_packets(self, segment: str, call: Callable[[SegmentEvent], None]) -> Callable[[], None]:
        return watch_segment(self._daemon.bench.segments[segment], call)

    def on_bytes(self, port: str, call: Callable[[str, bytes], None]) -> Callable[[], None]:
        return self._daemon.captures.watch(port, call)

    def _known(self, device: str) -> DeviceInfo:
        if device not in self.devices:
            raise VerbRefused(
                "no_device", f"there is no device {device!r}; {suggestion(device, self.devices)}"
            )
        return self.devices[device]

    def _twin(self, device: str) -> None:
        if self._known(device).is_real:
            raise VerbRefused("cannot", f"{device} is a real board: {real_boards.CANNOT}")


class Sampling:
    """``hil.vocab.bridges.Samples``."""

    def __init__(self, sampler: Sampler, device: str, interval_ns: int | Fraction) -> None:
        self._sampler = sampler
        self._subscription = sampler.subscribe(device, (), interval_ns)

    @property
    def lost(self) -> int:
        return self._subscription.lost

    def take(self) -> Sequence[bytes]:
        self._sampler.poll_device(self._subscription.device)
        return self._subscription.take_packed()

    def close(self) -> None:
        self._sampler.unsubscribe(self._subscription)


def typed(text: str) -> bytes:
    r"""What a text stands for: ``\r``, ``\n``, ``\t``, ``\\`` and ``\xHH`` are one byte each.

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
