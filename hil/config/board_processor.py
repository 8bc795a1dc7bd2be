"""Processor of a kind of board, as ``profile.yaml`` describes it: chip, clock, voltages, fuses, pins by the
board's names."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from hil.config.document import Document, Finding, KeyPath
from hil.config.explain import StrictModel, no_such, shown
from hil.core.axis_kind import CLOCK_IN, CLOCK_OUT
from hil.core.kinds import PROCESSOR_LAWS
from hil.vocab.axis_plan import ProcessorPlan
from hil.vocab.problem import Problem

PROCESSOR = "processor"
CHIPS = ("atmega328p",)
MOST_HZ, LEAST_V, MOST_V = 20_000_000, 1.8, 5.5
"""Operating range. Source: DS40002061, chapter 29."""
USUAL_BAUD = 115_200
PADS = {
    f"P{port}{bit}": first + bit
    for port, first, bits in (("D", 0, 8), ("B", 8, 6), ("C", 14, 6))
    for bit in range(bits)
}
PADS |= {"ADC6": 20, "ADC7": 21}
"""Numbers of the chip's pins by the data sheet's names; the last two are the converter's alone."""
_ELSEWHERE = {
    **dict.fromkeys(("PB6", "PB7"), "the clock is there; leave this pin out"),
    "PC6": "it is RESET, which is no pin here; leave it out",
    **{f"ADC{channel}": f"write PC{channel}, which is the same pin" for channel in range(6)},
}
_PIN_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,31}")
_TAKEN = {
    "vcc": "a voltage of the processor",
    "levels": "a field of all pins",
    CLOCK_IN: "a clock's input",
    CLOCK_OUT: "a clock's output",
}
"""Names, in small letters, that mean something else already."""
_SPEEDS = ((1.8, 4e6), (2.7, 10e6), (4.5, 20e6))
"""Corners of the safe operating area: the maximum frequency at a supply, straight lines in between. Source:
DS40002061, chapter 29, speed grades."""

_Fuse = Annotated[int, Field(ge=0, le=0xFF)]


class FusesInfo(StrictModel):
    """Fuses of a processor; a Uno's unless it says others."""

    low: _Fuse = 0xFF
    high: _Fuse = 0xDE
    extended: _Fuse = 0xFD


class ProcessorInfo(StrictModel):
    """Processor that runs a user's program. Its serial interface, at PD0 and PD1, is the board's first."""

    chip: Literal["atmega328p"]
    clock_Hz: int = Field(default=16_000_000, ge=1, le=MOST_HZ)
    """Frequency of its crystal or oscillator, before the division by fuse CKDIV8 or register CLKPR."""
    supply_V: float = Field(default=5.0, ge=LEAST_V, le=MOST_V)
    aref_V: float | None = Field(default=None, ge=1.0, le=MOST_V)
    """Voltage at AREF; None: that of the supply, and follows it."""
    bootloader_baud: int | None = Field(default=USUAL_BAUD, ge=300, le=2_000_000)
    """Speed at which a tool that uploads is answered over the first serial interface, as optiboot does; None:
    the board has no bootloader."""
    fuses: FusesInfo = FusesInfo.model_construct(low=0xFF, high=0xDE, extended=0xFD)
    pins: Mapping[str, str] = Field(default={})
    """Names of the chip's pins, as in PB5, by the board's names; empty: the names are a Uno's."""

    @cached_property
    def plan(self) -> ProcessorPlan:
        """Plan that the core sets it up with."""
        fuses = (self.fuses.low, self.fuses.high, self.fuses.extended)
        aref_V = self.supply_V if self.aref_V is None else self.aref_V
        pins = tuple((name, PADS[pad]) for name, pad in self.pins.items())
        return ProcessorPlan(self.clock_Hz, self.supply_V, aref_V, fuses, pins)


def _mapping(value: Any) -> Any:
    return {"chip": value} if isinstance(value, str) else value


ProcessorKey = Annotated[ProcessorInfo | None, BeforeValidator(_mapping)]
"""Key of a ``profile.yaml``: the chip alone, which is a Uno's then, or a mapping."""


def with_processors_axis(value: Any) -> Any:
    """Complete a profile's mapping with what a processor brings: the axis of its pins, and a serial
    interface."""
    if not isinstance(value, dict) or value.get(PROCESSOR) is None:
        return value
    usual: dict[str, Any] = {} if value.get("axes") else {"law": PROCESSOR_LAWS[0]}
    return usual | {"uarts": {"main": {"baud": USUAL_BAUD}}} | value


def processor_findings(
    info: ProcessorInfo, law: str | None, bauds: Mapping[str, int | None]
) -> Iterator[Finding]:
    """Findings about a processor, beside those of the model. ``law``: of the board's only axis; ``bauds``:
    speeds of its serial interfaces by name."""
    if law not in PROCESSOR_LAWS:
        remedy = "leave law and axes out: the axis of such a board is its pins; a motor is another device"
        yield Finding((PROCESSOR,), "the processor's pins are no axis here", remedy, True)
    if info.aref_V is not None and info.aref_V > info.supply_V:
        message = f"{info.aref_V:g} V at AREF are more than the supply's {info.supply_V:g} V"
        yield Finding((PROCESSOR, "aref_V"), message, "write at most the supply's voltage")
    for name, baud in list(bauds.items())[:1]:
        if baud is None:
            message = "the processor's serial interface needs a speed, for when its program has set none"
            yield Finding(("uarts", name), message, f"write {{baud: {info.bootloader_baud or 9600}}}", True)
    yield from _pin_findings(info.pins)


def _pin_findings(pins: Mapping[str, str]) -> Iterator[Finding]:
    names: dict[str, str] = {}
    pads: dict[str, str] = {}
    for name, pad in pins.items():
        path: KeyPath = (PROCESSOR, "pins", name)
        if not _PIN_NAME.fullmatch(name):
            remedy = "write a letter, and up to 31 more of letters, digits and _"
            yield Finding(path, f"{shown(name)} is no name of a pin", remedy, True)
        elif what := _TAKEN.get(name.lower()):
            yield Finding(path, f"{name} is the name of {what} already", "give the pin another", True)
        elif (like := names.setdefault(name.lower(), name)) != name:
            message = f"{name} and {like} differ only by capital letters"
            yield Finding(path, message, "give the pin another name", True)
        if pad not in PADS:
            finding = no_such(path, "pin of an ATmega328P", pad, PADS)
            yield replace(finding, remedy=_ELSEWHERE.get(pad.upper(), finding.remedy))
        elif (other := pads.setdefault(pad, name)) != name:
            yield Finding(path, f"{pad} is the pin {other} already", "a pin of the chip has one name")


def processor_warnings(info: ProcessorInfo, document: Document) -> tuple[Problem, ...]:
    """Warnings about a processor that can run like this on the bench, and might not on the desk."""
    most_Hz = _fastest_Hz(info.supply_V)
    if info.clock_Hz <= most_Hz:
        return ()
    message = (
        f"{info.clock_Hz / 1e6:g} MHz at {info.supply_V:g} V are outside of the chip's safe operating area:"
        f" {most_Hz / 1e6:.3g} MHz at most"
    )
    remedy = "a warning; lower clock_Hz, or raise supply_V"
    return tuple(document.error([Finding((PROCESSOR, "clock_Hz"), message, remedy)]).problems)


def _fastest_Hz(supply_V: float) -> float:
    """Maximum frequency at a supply."""
    for (low_V, low_Hz), (high_V, high_Hz) in pairwise(_SPEEDS):
        if supply_V <= high_V:
            return low_Hz + (high_Hz - low_Hz) * (supply_V - low_V) / (high_V - low_V)
    return _SPEEDS[-1][1]
