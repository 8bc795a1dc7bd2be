"""Bench in memory, on simulated time, for keywords."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import serial
from robot.api import SkipExecution

from hil.robot.bench_kind import StartedProgram
from hil.sim.inputs import SetField
from hil.sim.settable import setting_problem
from hil.testing import Bench
from hil.testing.given import NamedThings, no_such
from hil.vocab.address import address_of
from hil.vocab.framing import Splitter
from hil.vocab.operation import Operation
from hil.vocab.segment import SegmentEvent, SegmentView
from hil.vocab.time import NS_PER_MS, NS_PER_S
from hil.vocab.verbs import VerbRefused, checked


class SegmentPackets:
    """Packets on a segment, as texts, from now on."""

    def __init__(self, segment: SegmentView) -> None:
        self._segment = segment
        self._splitter: Splitter = segment.framing.splitter()
        self.texts: list[str] = []
        segment.watchers.append(self._heard)

    def _heard(self, event: SegmentEvent) -> None:
        items = self._splitter.burst(event.data, event.at_ns, self._segment.baud).items
        self.texts += map(self._segment.framing.text, items)


class VirtualKind:
    """``BenchKind`` in memory. Raises ConfigError: with all problems of the file."""

    speed = 1.0

    def __init__(self, file: Path, seed: int) -> None:
        try:
            self._bench = Bench(file, seed)
        except ValueError as error:
            raise SkipExecution(f"kind=virtual: {error}") from None
        if late := self._bench.start():
            raise ValueError(f"within 30 s of simulated time there is no answer from {', '.join(late)}")
        segments = self._bench.runtime.segments
        self._packets = NamedThings(
            "segment", {name: SegmentPackets(each) for name, each in segments.items()}
        )

    @property
    def now_s(self) -> float:
        return self._bench.now_ns / NS_PER_S

    def pass_time(self, seconds: float) -> None:
        self._bench.run(ms=seconds * NS_PER_S / NS_PER_MS)

    def open_port(self, port: str, baud: int | None) -> serial.Serial:
        opened: serial.Serial = self._bench.serial(port, baud)
        return opened

    def ask(self, operation: Operation, target: str, given: Mapping[str, Any]) -> Any:
        values = checked(operation.name, operation.parameters, given)
        return CARRIED_OUT[operation.name](self._bench, target, **values)

    def start_program(self, words: Sequence[str], mapped: Mapping[str, str], folder: Path) -> StartedProgram:
        return self._bench.program(words, mapped, cwd=folder)

    def packets(self, segment: str) -> list[str]:
        heard = self._packets[segment]
        texts, heard.texts = heard.texts, []
        return texts

    def close(self) -> None:
        self._bench.close()


def _do(bench: Bench, device: str, name: str, parameters: Mapping[str, Any]) -> dict[str, Any]:
    has_axis = bench.runtime.parts.axis_address(device)
    return (bench.axis(device) if has_axis else bench.device(device)).do(name, **parameters)


def _pin(bench: Bench, device: str, pin: str, level: int) -> None:
    name, axis = address_of(device)
    bench.device(name).pin(f"{axis}.{pin}" if axis else pin, level)


def _set(bench: Bench, device: str, field: str, value: float) -> None:
    bench.axis(device)  # refuses a wrong name
    runtime = bench.runtime
    twin, axis = runtime.parts.axes[runtime.parts.axis_address(device) or device]
    settable = twin.axes[axis].kind.settable
    if field not in settable:
        raise no_such("field to set", field, settable)
    if problem := setting_problem(runtime.faults, twin, field, value, twin.axes.short(axis)):
        raise VerbRefused("bad_parameter", problem)
    runtime.apply_input(device, SetField(field, value))


def _inject(bench: Bench, target: str, fault: str, parameters: Mapping[str, Any]) -> dict[str, int]:
    return {"number": bench.fault(fault, target, **parameters).number}


def _faults(bench: Bench, _: str) -> list[dict[str, Any]]:
    faults = bench.runtime.faults
    return [
        {"number": number, **asdict(fault), "begin_ns": faults.begin_ns[number]}
        for number, fault in faults.active.items()
    ]


def _clear(bench: Bench, _: str, number: float | str, on: str) -> dict[str, list[int]]:
    there = [
        each["number"] for each in _faults(bench, "") if not on or f"{each['target']}.".startswith(f"{on}.")
    ]
    chosen = [each for each in there if number in ("all", each)]
    if number != "all" and not chosen:
        raise VerbRefused("bad_parameter", f"there is no fault {number}; there are {there or 'none'}")
    for each in chosen:
        bench.runtime.clear_fault(each)
    return {"cleared": chosen}


CARRIED_OUT: Mapping[str, Callable[..., Any]] = {
    "state": lambda bench, device: bench.axis(device).snapshot().as_dict(),
    "reset": lambda bench, device: bench.device(device).reset(),
    "pin": _pin,
    "set": _set,
    "zero": lambda bench, device: bench.axis(device).zero(),
    "do": _do,
    "inject": _inject,
    "clear": _clear,
    "faults": _faults,
}
"""Operations that a bench in memory carries out, by name; called with the bench, the target, parameters."""
