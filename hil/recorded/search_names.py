"""Names of what a search can compare: fields of axes, counters of wires, and what happens at a moment."""

from collections.abc import Collection, Iterator
from typing import NamedTuple

from hil.net.condition import Condition, ConditionError
from hil.recorded.recorded_fields import RunField
from hil.recorded.recorded_run import RecordedRun
from hil.sim.bench import BenchRuntime
from hil.sim.bench_parts import BenchParts
from hil.vocab.address import address_of
from hil.vocab.near_words import meant
from hil.vocab.wire import Wire

SENT, RECEIVED = "sent", "received"
"""Streams of bytes: what a board sends, and what a client sends to it."""
FAULT, VERB, INPUT = "fault", "verb", "input"
"""Texts of inputs: kind of a fault that begins, name of a verb, kind of the input as the log has it."""
ITEM_TEXTS = ("text", "data", "error", "kind", "from", "to")
"""Texts of a packet or frame, as `hil decode --json` names them."""
ITEM_NUMBERS = ("from", "to", "can_id")
"""Numbers of a packet or frame, as `hil decode --json` names them."""


class SearchName(NamedTuple):
    """Name of something in a run: an owner, as ``m1`` or ``bus0``, and what of it."""

    owner: str
    leaf: str

    def __str__(self) -> str:
        return f"{self.owner}.{self.leaf}"


class SearchNames(NamedTuple):
    """Names of a condition. ``fields`` and ``counters`` are numbers that last, ``events`` numbers and texts
    of moments."""

    fields: dict[str, RunField]
    counters: dict[str, SearchName]
    events: dict[str, SearchName]


def read_names(run: RecordedRun, condition: Condition) -> SearchNames:
    """Find what the names of a condition are in a run.

    Raises:
        ConditionError: there is none of this name.
    """
    names = SearchNames({}, {}, {})
    for text in condition.fields:
        name = _found(run.runtime, text)
        if _is_field(run.runtime.parts, name):
            names.fields[text] = RunField(*name)
        elif name.owner in run.runtime.wires and name.leaf in wire_counters(run.runtime.wires[name.owner]):
            names.counters[text] = name
        elif name.owner in run.runtime.wires and name.leaf in ITEM_NUMBERS:
            names.events[text] = name
        else:
            raise ConditionError(f'{text} is a text: write words in quotes, as in `{text} has "..."`')
    for test in condition.tests:
        name = _found(run.runtime, test.name)
        if name.leaf not in _texts(run.runtime, name.owner):
            raise ConditionError(f"{test.name} is a number: compare it with one, as in `{test.name} > 5`")
        names.events[test.name] = name
    return names


def wire_counters(wire: Wire) -> dict[str, float]:
    """Counters of a wire; ``errors`` are all together."""
    told = wire.counters(1)
    numbers = {key: value for key, value in told.items() if isinstance(value, int | float)}
    return numbers | {"errors": sum(told["errors"].values())}


def _found(runtime: BenchRuntime, text: str) -> SearchName:
    of, _, leaf = text.rpartition(".")
    owner = runtime.parts.axis_address(of) or _owner(runtime, of)
    if owner is None:
        known = [*dict.fromkeys(_owners(runtime))]
        example = f"{known[0]}.{leaf}" if known else "m1.e"
        if not of:
            raise ConditionError(
                f"{text!r} does not say of what: write it as in {example}; {meant(text, known)}"
            )
        raise ConditionError(f"there is no {of!r}; {meant(of, known)}")
    leaves = [*dict.fromkeys(_leaves(runtime, owner))]
    if leaf not in leaves:
        raise ConditionError(f"{owner} has no {leaf!r}; {meant(leaf, leaves)}")
    return SearchName(owner, leaf)


def _owner(runtime: BenchRuntime, text: str) -> str | None:
    if text in _owners(runtime):
        return text
    name, part = address_of(text)  # the first serial interface has its device's address
    uarts = runtime.devices[name].uarts if name in runtime.devices else {}
    return runtime.devices[name].uarts.label(name, part) if part in uarts else None


def _owners(runtime: BenchRuntime) -> Iterator[str]:
    yield from runtime.parts.axes
    yield from runtime.devices
    yield from _ports(runtime.parts)
    yield from runtime.wires
    yield from runtime.taps
    yield from runtime.cards


def _ports(parts: BenchParts) -> Iterator[str]:
    for name, device in parts.devices.items():
        yield from (device.uarts.label(name, uart) for uart in device.uarts)


def _is_field(parts: BenchParts, name: SearchName) -> bool:
    if name.owner not in parts.axes:
        return False
    device, axis = parts.axes[name.owner]
    return name.leaf in device.axes[axis].kind.fields


def _texts(runtime: BenchRuntime, owner: str) -> Collection[str]:
    """Texts that an owner has."""
    texts = [FAULT, INPUT]
    if owner in runtime.devices or owner in runtime.parts.axes:
        texts.append(VERB)
    if owner in runtime.cards or owner in _ports(runtime.parts):
        texts.append(SENT)
    if owner in runtime.taps or owner in _ports(runtime.parts):
        texts.append(RECEIVED)
    return [*texts, *(ITEM_TEXTS if owner in runtime.wires else ())]


def _leaves(runtime: BenchRuntime, owner: str) -> Iterator[str]:
    """Names of all that an owner has."""
    if owner in runtime.parts.axes:
        device, axis = runtime.parts.axes[owner]
        yield from (name for name in device.axes[axis].kind.fields if name != "at_ns")
    if wire := runtime.wires.get(owner):
        yield from wire_counters(wire)
        yield from ITEM_NUMBERS if wire.frames else ITEM_NUMBERS[:-1]
    yield from _texts(runtime, owner)
