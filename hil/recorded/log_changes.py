"""Changes to a recorded run: keys of its configuration, fields of its axes, faults."""

import json
from collections.abc import Iterator, Sequence
from contextlib import suppress
from copy import deepcopy
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

from hil.compose.build import TableFileError, start_sections
from hil.config import DeviceConfig
from hil.recorded.recorded_run import RecordedRun
from hil.recorded.time_words import parse_length, parse_time
from hil.sim.given_fault import fault_refusal
from hil.sim.input_log import InputLog
from hil.sim.inputs import Clear, Do, Inject, Input, Logged, Reset, SetField
from hil.sim.settable import setting_problem
from hil.vocab.faults import FaultRefused
from hil.vocab.near_words import did_you_mean, meant, nearest
from hil.vocab.time import SimTimeNs

OF_THE_BENCH = ("seed", "profile_path")
"""Keys of a whole bench on which a run on the virtual clock depends."""


class ChangeRefused(ValueError):
    """Error of a change that cannot be made: ``str(error)`` says which, and what can."""


@dataclass
class LogChanges:
    """Changed run of a log. ``fields``: those that were set, by axis and name, which differ of course;
    ``own``: inputs that were added."""

    log: InputLog
    fields: set[tuple[str, str]] = field(default_factory=set)
    own: list[Logged] = field(default_factory=list)
    is_changed: bool = False
    """True if something was asked to be changed."""


def changed(
    run: RecordedRun,
    settings: Sequence[str] = (),
    faults: Sequence[str] = (),
    without: Sequence[str] = (),
    at_ns: SimTimeNs | None = None,
) -> LogChanges:
    """Change a recorded run. ``run``: the run as it was, at time 0. ``settings``: each as ``m1.pKp=10``;
    ``faults``: added, each ``KIND TARGET name=value at=12.5s for=1s``; ``without``: faults to leave out, by
    number, by kind, or ``all``. ``at_ns``: when fields are set; None: from the start, and again after each
    power-up.

    Raises:
        ChangeRefused: a change names nothing, or its value cannot be.
    """
    log = replace(run.log, config=deepcopy(run.log.config), inputs=[*run.log.inputs])
    changes = LogChanges(log, is_changed=bool(settings or faults or without))
    for each in without:
        _leave_out(changes, each)
    for text in settings:
        name, equals, value = text.partition("=")
        if not equals or not name:
            raise ChangeRefused(f"{text!r} is no setting; write it as in m1.pKp=10")
        _set(run, changes, name.strip(), _value(value.strip()), at_ns)
    for text in faults:
        _add(changes, _fault(run, changes, text))
    return changes


def _value(text: str) -> Any:
    for read in (json.loads, float):
        with suppress(ValueError):
            return read(text)
    return text


# ---- settings ----


def _set(run: RecordedRun, changes: LogChanges, name: str, value: Any, at_ns: SimTimeNs | None) -> None:
    first, _, rest = name.partition(".")
    config, wires = run.config, run.config.bus_wires()
    if name in OF_THE_BENCH:
        is_path = name == "profile_path" and isinstance(value, str)
        path, value = [name], [str(Path(value).absolute())] if is_path else value
    elif first in wires and rest:
        key = next(key for key in config.bus_keys if first in config.wires_of(key))
        path = [key, first, *rest.split(".")]
    elif first in config.devices and rest:
        if (axis := run.runtime.parts.axis_address(name.rpartition(".")[0])) and (
            _set_field(run, changes, axis, name.rpartition(".")[2], value, at_ns)
        ):
            return
        path = ["devices", first, *_device_path(run, first, rest)]
    else:
        known = [*config.devices, *wires, *OF_THE_BENCH]
        example = f"{next(iter(config.devices))}.axis.inertia_kg_m2=0.0001"
        raise ChangeRefused(
            f"{name!r} names nothing of this run: {meant(first, known)}; write it as {example}"
        )
    if at_ns is not None:
        raise ChangeRefused(f"{name} is of the configuration, which holds from the start; leave --at out")
    if path[2:] == ["profile"] and value != config.devices[first].profile:
        _exchange_board(changes, first)
    _put(changes.log.config, path, value)
    if path[2:3] == ["flash"]:
        _start_memory(run, changes, first)


def _device_path(run: RecordedRun, name: str, rest: str) -> list[str]:
    parts, device = rest.split("."), run.config.devices[name]
    keys = list(type(device).model_fields)
    profile = run.catalogue.profiles[device.profile]
    if parts[0] in keys:
        return parts
    if parts[0] in profile.axes and len(parts) > 1:
        return ["axes", *parts]
    first = next(iter(profile.axes.values()), None)
    parameters = [f"axis.{each}" for each in (first.axis if first else ())]
    by_word = {each.rpartition(".")[2]: each for each in [*keys, *parameters, *_fields(run, name)]}
    if near := nearest(rest.rpartition(".")[2], by_word):
        raise ChangeRefused(f"{name} has no {rest!r}: {did_you_mean(f'{name}.{by_word[near]}')}")
    raise ChangeRefused(f"{name} has no {rest!r}; there are {', '.join(by_word.values())}")


def _fields(run: RecordedRun, device: str) -> Iterator[str]:
    twin = run.runtime.devices.get(device)
    for axis in twin.axes.values() if twin else ():
        yield from axis.kind.settable


def _put(config: dict[str, Any], path: Sequence[str], value: Any) -> None:
    at: Any = config
    for part, following in pairwise(path):
        if not isinstance(at.get(part), dict):
            if at.get(part) is not None:
                raise ChangeRefused(f"{'.'.join(path)}: {part} has no {following!r}")
            at[part] = {}
        at = at[part]
    at[path[-1]] = value


def _exchange_board(changes: LogChanges, name: str) -> None:
    """Let another board begin with the defaults of its profile, and an empty memory."""
    for key in ("hardware", "baud"):
        changes.log.config["devices"][name].pop(key, None)
    changes.log = replace(changes.log, memories=changes.log.memories | {name: {}})


def _start_memory(run: RecordedRun, changes: LogChanges, name: str) -> None:
    """Give a device the memory that its configuration asks for now."""
    board = run.catalogue.boards[run.config.devices[name].profile]
    flash = changes.log.config["devices"][name]["flash"]
    try:
        wanted = DeviceConfig.model_construct(flash=type(run.config.devices[name].flash)(**flash))
        stored = run.log.memories.get(name, {})
        sections = start_sections(wanted, board, stored, Path())
    except (TableFileError, ValueError) as error:
        raise ChangeRefused(f"{name}.flash: {error}") from None
    memories = changes.log.memories | {name: sections}
    changes.log = replace(changes.log, memories=memories)


def _set_field(
    run: RecordedRun, changes: LogChanges, address: str, name: str, value: Any, at_ns: SimTimeNs | None
) -> bool:
    """Set a field of an axis; answers whether there is one of this name that can be set."""
    device, part = run.runtime.parts.axes[address]
    if (
        name not in device.axes[part].kind.settable
        or name in type(run.config.devices[device.name]).model_fields
    ):
        return False
    if problem := setting_problem(run.runtime.faults, device, name, value, part):
        raise ChangeRefused(f"{address}.{problem}")
    changes.fields.add((address, name))
    given = SetField(name, float(value))
    if at_ns is not None:
        _add(changes, Logged(at_ns, address, given))
        return True
    ups = [each.at_ns for each in changes.log.inputs if each.device == device.name and _powers_up(each.input)]
    for at in (SimTimeNs(0), *ups):
        _add(changes, Logged(at, address, given))
    return True


def _powers_up(given: Input) -> bool:
    return isinstance(given, Reset) or (isinstance(given, Do) and given.verb == "reset")


# ---- faults ----


def _leave_out(changes: LogChanges, text: str) -> None:
    injected = [each.input for each in changes.log.inputs if isinstance(each.input, Inject)]
    numbers = {each.number for each in injected if text in ("all", str(each.number), each.kind)}
    if not numbers:
        there = ", ".join(f"{each.number} {each.kind}" for each in injected) or "none"
        raise ChangeRefused(f"no fault of this run is {text!r}; there are: {there}")
    kept = [
        (each, line)
        for each, line in zip(changes.log.inputs, changes.log.lines, strict=True)
        if not (isinstance(each.input, Inject | Clear) and each.input.number in numbers)
    ]
    changes.log = replace(changes.log, inputs=[each for each, _ in kept], lines=[line for _, line in kept])


def _fault(run: RecordedRun, changes: LogChanges, text: str) -> Logged:
    kind, *more = text.split()
    if not more or "=" in more[0]:
        raise ChangeRefused(f"{text!r} is no fault; write it as in 'byte_drop m1 rate=0.5 at=12.5s for=1s'")
    target, given, at_ns = more[0], dict[str, Any](), SimTimeNs(0)
    for each in more[1:]:
        name, equals, value = each.partition("=")
        if not equals:
            raise ChangeRefused(f"{each!r} is no parameter; write it as in rate=0.01")
        if name == "at":
            at_ns = parse_time(value, run.end_ns)
        elif name == "for":
            given["for_s"] = parse_length(value) / 1e9
        else:
            given[name] = _value(value)
    try:
        fault = fault_refusal(kind, target, given)
        run.runtime.faults.check(fault, with_others=True)
    except FaultRefused as error:
        raise ChangeRefused(str(error)) from None
    numbers = [each.input.number for each in changes.log.inputs if isinstance(each.input, Inject)]
    return Logged(at_ns, target, Inject(max(numbers, default=0) + 1, kind, tuple(fault.parameters.items())))


def _add(changes: LogChanges, added: Logged) -> None:
    """Put an input behind those of its time, before later ones."""
    log = changes.log
    at = next((i for i, each in enumerate(log.inputs) if each.at_ns > added.at_ns), len(log.inputs))
    line = log.lines[at - 1] if at else 1
    inputs = [*log.inputs[:at], added, *log.inputs[at:]]
    changes.log = replace(log, inputs=inputs, lines=[*log.lines[:at], line, *log.lines[at:]])
    changes.own.append(added)
