"""Faults in the daemon: on twins and segments, and on real boards' lines, under one count of numbers."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from hil.config.explain import suggestion
from hil.sim.bench import BenchRuntime
from hil.sim.faults.fitting import fault_places
from hil.sim.given_fault import fault_refusal
from hil.vocab.device import Device, DeviceFaults
from hil.vocab.faults import FAULT_KINDS, PORT, TIMING, Fault, FaultRefused
from hil.vocab.time import SimTimeNs


class FaultRegistry:
    """Faults of one bench; byte faults can be on the real lines of its ``devices``, too."""

    def __init__(self, bench: BenchRuntime, devices: Mapping[str, Device]) -> None:
        self._bench, self._devices = bench, devices
        self._active: dict[int, tuple[Fault, DeviceFaults, SimTimeNs]] = {}
        """Faults of real lines, each with the line and the time of the injection."""

    def inject(self, kind: str, target: str, parameters: Mapping[str, object]) -> int:
        """Inject a fault; answers its number.

        Raises:
            FaultRefused: there is no such kind or place, or a parameter does not do.
        """
        if kind not in FAULT_KINDS:
            raise FaultRefused(f"there is no fault {kind!r}; {suggestion(kind, FAULT_KINDS)}")
        device = self._devices.get(target)
        if (line := device.faults if device else None) is None:
            self._bench.faults.place(target)
        fault = fault_refusal(kind, target, parameters)
        if line is None:
            return self._bench.inject(fault)
        if FAULT_KINDS[kind].target != PORT or any(fault.number(each.name) for each in TIMING):
            raise FaultRefused(f"{target} is a real board: what it can have is a byte fault, from now on")
        number = self._bench.faults.new_number()
        line.inject(number, fault)
        self._active[number] = fault, line, self._bench.now_ns
        return number

    def places(self) -> list[dict[str, Any]]:
        """List the places where faults can be, each with the kinds that fit it."""
        of_lines = [kind.name for kind in FAULT_KINDS.values() if kind.target == PORT]
        boards = [name for name, device in self._devices.items() if device.faults is not None]
        return [
            *({**place._asdict(), "kinds": list(place.kinds)} for place in fault_places(self._bench.parts)),
            *({"place": name, "sort": "board", "of": "", "wire": "", "kinds": of_lines} for name in boards),
        ]

    def clear(self, number: int) -> None:
        """Take a fault away. Raises FaultRefused: there is none of this number."""
        if found := self._active.pop(number, None):
            found[1].clear(number)
        else:
            self._bench.clear_fault(number)

    def forget(self, device: str) -> None:
        """Remove the faults of a real board's line when the board goes or is exchanged."""
        self._active = {number: of for number, of in self._active.items() if of[0].target != device}

    def listed(self) -> list[dict[str, Any]]:
        """List all active faults with the times at which they begin; those of real lines with the number of
        bytes that each has changed."""
        of_twins = self._bench.faults
        rows: list[dict[str, Any]] = [
            {"number": number, **asdict(fault), "begin_ns": of_twins.begin_ns[number]}
            for number, fault in of_twins.active.items()
        ]
        for number, (fault, line, begin_ns) in self._active.items():
            told = {"begin_ns": begin_ns, "changed_bytes": line.changed_bytes(number)}
            rows.append({"number": number, **asdict(fault), **told})
        return rows
