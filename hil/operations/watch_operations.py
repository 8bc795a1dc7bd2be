"""Watches on a bench: samples of axes, packets on segments, bytes at ports, runs."""

from collections.abc import Callable
from fractions import Fraction
from functools import partial
from typing import Any

from hil.config.port_interface import port_interface
from hil.live.captures import Capture
from hil.live.core_thread import WallClock
from hil.live.devices.bench_devices import Devices
from hil.live.places import Places
from hil.live.runs.queue import RunQueue
from hil.live.watches import Watches
from hil.operations.command_log import CommandLog
from hil.operations.event_log import EventLog
from hil.operations.table import WATCH_IDLE_S, Asked
from hil.runs import Progress
from hil.sim.bench import BenchRuntime
from hil.sim.segment_tap import Tap
from hil.vocab.address import address_of, owner_of
from hil.vocab.desk_protocol import Watch, Watched
from hil.vocab.near_words import meant
from hil.vocab.verbs import VerbRefused
from hil.vocab.wire import Wire
from hil.wire.pcapng import RAW, Interface

SAMPLES_AT_A_TIME = 5000


class WatchOperations:
    """Operations that watch one bench."""

    def __init__(
        self,
        sim: BenchRuntime,
        devices: Devices,
        places: Places,
        clock: WallClock,
        watches: Watches,
        runs: RunQueue,
        events: EventLog,
        commands: CommandLog,
    ) -> None:
        self._sim, self._devices, self._places = sim, devices, places
        self._clock, self._watches, self._runs = clock, watches, runs
        self._events, self._commands = events, commands

    def open(
        self, what: Watched, target: str, call: Callable[..., Any], interval_ns: int | Fraction, points: int
    ) -> Watch:
        """Begin a watch, as ``Desk.watch``; a target of samples is an axis that is seen."""
        try:
            match what:
                case Watched.SAMPLES:
                    device, part = self._devices.at(target)
                    return device.watch(part, interval_ns, points, call)
                case Watched.PACKETS | Watched.FRAMES:
                    return _Calls(_listening(self._sim.wires[target].watchers, call))
                case Watched.BYTES:
                    return _Calls(_listening(self._places[target].listeners, call))
                case Watched.RUNS:
                    return self._watch_runs(call)
                case Watched.EVENTS:
                    return _Calls(_listening(self._events.listeners, call))
                case Watched.COMMANDS:
                    return _Calls(_listening(self._commands.listeners, call))
        except KeyError:
            raise self._no_place(target) from None
        except ValueError as error:
            raise VerbRefused("bad_parameter", str(error)) from None

    def _watch_runs(self, call: Callable[..., Any]) -> Watch:
        def tell(progress: Progress) -> None:
            call(progress.as_dict())

        return _Calls(_listening(self._runs.listeners, tell))

    def watch(self, asked: Asked, signals: list[str], interval_ns: int, points: int) -> dict[str, Any]:
        """Begin a watch that keeps samples; answers its number, for those who come back for them."""
        device, part = self._devices.at(asked.target)
        try:
            names = device.signals(part, signals)
            watch = self._watches.open(asked.target, names, interval_ns, points)
            return {"watch": watch, "signals": names}
        except ValueError as error:
            raise VerbRefused("bad_parameter", str(error)) from None

    def samples(self, asked: Asked, watch: int) -> dict[str, Any]:
        """Samples since the last call."""
        try:
            rows, lost = self._watches.drain(watch, SAMPLES_AT_A_TIME)
        except KeyError:
            raise VerbRefused(
                "not_now", f"watch {watch} has ended; ask for samples every {WATCH_IDLE_S} s"
            ) from None
        return {"rows": rows, "lost": lost, "sim_ns": self._sim.now_ns}

    def unwatch(self, asked: Asked, watch: int) -> dict[str, Any]:
        """End a watch, also one that has ended."""
        self._watches.close(watch)
        return {}

    def capture(self, asked: Asked, ports: list[str]) -> tuple[Capture, Callable[[], None]]:
        """Make a capture, which waits for a writer, and a function that ends it."""
        for name in ports:
            known = (self._sim.wires, self._places, self._cards())
            if not any(name in each for each in known):
                raise self._no_place(name)
        capture = Capture([self._interface(name) for name in ports], self._clock)
        ends = [self._captured(capture, index, name) for index, name in enumerate(ports)]

        def end() -> None:
            for each in ends:
                each()

        return capture, end

    def _interface(self, name: str) -> Interface:
        """Line of a place: a wire, or the one that a node or a tap of packets is on."""
        card, tap = self._cards().get(name), self._sim.taps.get(name)
        on = owner_of(name) if isinstance(tap, Tap) else name
        line: Wire | None = card.wire if card else self._sim.wires.get(on)
        found: Interface = line.interface(name) if line else self._terminal(name)
        return found

    def _terminal(self, name: str) -> Interface:
        owner, part = address_of(name)
        if (device := self._sim.devices.get(owner)) and part in device.uarts:
            return port_interface(name, device, part)
        return Interface(name, RAW)

    def _captured(self, capture: Capture, index: int, name: str) -> Callable[[], None]:
        """Let a capture record what passes at a place; answers a function that ends it."""
        if wire := self._sim.wires.get(name):
            if wire.frames:
                return _listening(wire.watchers, partial(capture.carried, index, wire.frames))
            return _listening(wire.watchers, partial(capture.heard, index))
        if card := self._cards().get(name):
            return _listening(card.watchers, partial(capture.passed_at, index))
        place, call = self._places[name], partial(capture.passed, index)
        end_beside = _listening(place.listeners_beside, call)
        end = _listening(place.listeners, call)

        def end_both() -> None:
            end_beside()
            end()

        return end_both

    def _cards(self) -> dict[str, Any]:
        """Cards at which what passes can be seen apart from their wire."""
        return {name: card for name, card in self._sim.cards.items() if hasattr(card, "watchers")}

    def _no_place(self, name: str) -> VerbRefused:
        known = [*self._sim.wires, *self._cards(), *self._places]
        if (device := self._sim.devices.get(name)) and not device.uarts:
            there = ", ".join(known) or "none"
            return VerbRefused("no_place", f"{name} has no serial port; ports and segments are {there}")
        return VerbRefused("no_place", f"there is no port {name!r}; {meant(name, known)}")


def _listening(listeners: list[Any], call: Callable[..., Any]) -> Callable[[], None]:
    """Add a listener; answers a function that removes it."""
    listeners.append(call)
    return partial(listeners.remove, call)


class _Calls:
    """Watch that calls by itself until ``end``."""

    lost = 0

    def __init__(self, end: Callable[[], None]) -> None:
        self.close = end

    def flush(self) -> None:
        """Do nothing: everything has been told."""
