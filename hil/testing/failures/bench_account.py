"""Account of where a bench in memory stands, for the report of a test that failed."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from hil.core import CoreAxis
from hil.core.axis_kind import ANGLE
from hil.sim.inputs import Clear, Inject
from hil.telemetry.recording import units_in
from hil.testing.failures.bench_replay import replay_bench
from hil.testing.failures.bench_traffic import READ, SHOWN, port_records, traffic_lines
from hil.vocab.address import owner_of
from hil.vocab.axis import CONTROL_MODES
from hil.vocab.faults import FAULT_KINDS, TIMING

if TYPE_CHECKING:
    from hil.testing.bench import Bench

_MODES = {letter: mode for mode, letter in CONTROL_MODES.items()}
Section = tuple[str, str]
"""Title and text of a section of a report."""


def bench_sections(bench: "Bench") -> Iterator[Section]:
    """State of the bench, the last of its traffic, and what others have to say (``more_sections``)."""
    name = bench.config.bench
    yield f"bench {name} at {bench.now_ns / 1e9:.6f} s", account(bench)
    yield f"traffic of {name}: the last {SHOWN} of each port and wire", _traffic(bench)
    for more in bench.more_sections:
        yield from more()


def _traffic(bench: "Bench") -> str:
    """The last of the traffic. A bench with wires is run again for it: nobody listened while the test ran."""
    records, notes = [*port_records(bench.inputs, bench.runtime)], list[str]()
    if bench.runtime.wires:
        again = replay_bench(bench.inputs, bench.now_ns, most=READ)
        records += again.wire_records
        if again.difference:
            notes = [f"a replay differs, and with it what wires carried: {again.difference}"]
    return "\n".join([*notes, *traffic_lines(records)]) or "nothing"


def account(bench: "Bench") -> str:
    """Faults in force, axes and notes, each in a line; axes that are alike share one."""
    runtime, last = bench.runtime, _last_faults(bench)
    alike: dict[str, list[str]] = {}
    for address in runtime.parts.axes:
        if (axis := runtime.parts.axis(address)).kind.has_motor:
            fault = last.get(address) or last.get(owner_of(address), "none")
            alike.setdefault(f"{axis_words(axis)}; last fault: {fault}", []).append(address)
    axes = [f"  {', '.join(addresses)}: {words}" for words, addresses in alike.items()]
    parts = {"faults in force": _faults(bench), "axes": axes, "notes": [*_notes(bench)]}
    return "\n".join(
        line
        for title, lines in parts.items()
        for line in ([f"{title}:", *lines] if lines else [f"{title}: none"])
    )


def axis_words(axis: CoreAxis) -> str:
    """State of an axis: its angle, the one that it should have, its mode and its loop."""
    seen = axis.snapshot()
    state, values = axis.kind.motion(seen), seen.as_dict()
    words = []
    if state.position_deg is not None:
        words.append(f"at {state.position_deg:.2f} deg")
    if state.commanded_deg is not None:
        unit = units_in(values).get("r", "deg")
        words.append(f"commanded {state.commanded_deg:.2f} {unit or 'counts'}")
    if axis.kind.course and axis.kind.course[-1] != ANGLE:
        words.append(f"shaft turned to {seen.position_deg:.2f} deg")
    if "mode" in values:
        letter = chr(int(seen.mode))
        words.append(f"mode {letter} ({_MODES[letter]})" if letter in _MODES else "no mode")
    if state.is_on is not None:
        words.append(f"{'loop' if 'loop_on' in values else 'drive'} {'on' if state.is_on else 'off'}")
    return ", ".join([*words, "moving" if state.is_moving else "still"])


def _faults(bench: "Bench") -> list[str]:
    faults = bench.runtime.faults
    rows = []
    for number, fault in faults.active.items():
        begin_ns = faults.begin_ns[number]
        when = "since" if begin_ns <= bench.now_ns else "from"
        given = _given(fault.kind, fault.parameters)
        rows.append(f"  {number} {fault.kind} on {fault.target}{given}, {when} {begin_ns / 1e9:.6f} s")
    return rows


def _given(kind: str, parameters: Mapping[str, float | str]) -> str:
    """Parameters that were given, and are not the usual ones."""
    usual = {each.name: each.default for each in (*FAULT_KINDS[kind].parameters, *TIMING)}
    given = [f"{name} {value}" for name, value in parameters.items() if value != usual.get(name)]
    return f" ({', '.join(given)})" if given else ""


def _last_faults(bench: "Bench") -> dict[str, str]:
    """The last fault that each target has had, in words."""
    began: dict[int, tuple[str, str]] = {}
    last: dict[str, int] = {}
    for each in bench.inputs.inputs:
        at = f"{each.at_ns / 1e9:.6f} s"
        if isinstance(each.input, Inject):
            began[each.input.number] = f"{each.input.kind} at {at}", ", over"
            last[each.device] = each.input.number
        elif isinstance(each.input, Clear) and each.input.number in began:
            began[each.input.number] = began[each.input.number][0], f", cleared at {at}"
    active = bench.runtime.faults.active
    ends = {number: ", in force" if number in active else end for number, (_, end) in began.items()}
    return {target: began[number][0] + ends[number] for target, number in last.items()}


def _notes(bench: "Bench") -> Iterator[str]:
    """Devices that have stopped, and what firmwares tell their operators."""
    for name, device in bench.runtime.devices.items():
        if device.failed:
            yield f"  {name} has stopped: {device.failed}"
        yield from (f"  {name}: {note}" for note in device.notes.values())
