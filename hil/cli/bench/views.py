"""Tables of ``hil list``, ``hil status`` and ``hil doctor``."""

import dataclasses
import json
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import typer

from hil.cli.framework.command_answers import pasteable
from hil.cli.framework.shown_view import Grid, Line, ShownView, line
from hil.cli.framework.shown_words import echo_words, fixed, reached_at, shown_number
from hil.cli.runs.run_reports import run_line
from hil.net.axis_states import MOTION_STATES, shown_state
from hil.vocab.axis import CONTROL_MODES

if TYPE_CHECKING:
    from hil.host.doctor import Diagnosis
    from hil.vocab.wire import WireInfo, WireView

RUNS = 5
"""Maximum number of runs that the status has."""
MOTION = ("shaft\ndeg", "board\ndeg", "rpm", "mode")
"""Columns of an axis in the status: the angle of its shaft, and the one that its board counts itself."""
_LATER = ("dropped", "out", "in", "clients", "board\ndeg")
"""Columns of the status that a narrow terminal has below the rows, the first ones first."""
_LETTERS = {letter: f"{letter} ({word})" for word, letter in CONTROL_MODES.items()}
_ANGLES = {
    "yw": "position_deg: the shaft's angle, from the encoder's count 0 or `hil zero`\n"
    "r, y, yw: the board's own angles, by its calibration",
    "pulses": "position_deg: the shaft's angle, from start_deg or `hil zero`\n"
    "commanded_deg: the angle that the board has the shaft turn to, from the same zero",
    "steps_taken": "position_deg: the shaft's angle, from start_deg or `hil zero`\n"
    "commanded_deg: the angle that the coils pull it to, from the same zero",
    "enabled": "position_deg, commanded_deg: the drive's own angles, as it tells them",
}
"""Meanings of angles, by a field that only such axes have."""
_WORDS: dict[str, Callable[[int], str]] = {
    "mode": lambda code: _LETTERS.get(chr(code), "none"),
    "motion_state": lambda code: MOTION_STATES[code],
}
"""Words for the values of fields that are codes."""
_NO_WIRES = {"devices", "faults", "lag", "runs", "switches", "wake_latency"}
"""Lists of a status that are of no wires."""
_BAR = "▁▂▃▄▅▆▇█"
_HEALTH_STYLE = {"ok": "green", "late": "yellow"}
_VERDICT_STYLE = {"ok": "green", "note": "yellow", "problem": "bold red"}


def device_table(listed: dict[str, Any]) -> ShownView:
    head = line(f"bench {listed['bench']} (process {listed['pid']})", "italic")
    columns = ("device", "profile", "port", "address", "clients")
    rows = list[tuple[str, ...]]()
    for row in listed["devices"]:
        profile = f"{row['profile']} {row['hardware']}"
        clients = str(row["clients"]) if row["address"] else ""
        rows.append((row["device"], profile, row["port"] or "none", row["address"] or "", clients))
        for name, port in row["ports"].items():
            rows.append((name, "", port["kind"], port["address"], str(port["clients"])))
    for row in listed["taps"]:
        rows.append((row["tap"], "tap", row["kind"], row["port"], str(row["clients"])))
    for row in listed["nodes"]:
        rows.append((row["node"], f"node {row['id']} on {row['bus']}", "", "", ""))
    stopped = [(row["device"], [f"stopped: {row['failed']}"]) for row in listed["devices"] if row["failed"]]
    return ShownView(head, Grid(columns, columns, rows, later=("profile", "clients")), *_remarks(stopped))


def status_view(status: dict[str, Any]) -> ShownView:
    ticks, missed = status["ticks"], status["missed"]
    told = (
        f"{status['rt_line']}\n"
        f"wakes at {status['rate_hz']} Hz: {ticks} ticks + {missed} missed in "
        f"{status['elapsed_ns'] / 1e9:.3f} s, {status['overruns']} over budget\n"
        f"wake latency  {_histogram(status['wake_latency'])}\n"
        f"firmware lag  {_histogram(status['lag'])}"
    )
    pace = (
        "paused; `hil resume` lets it go on" if status.get("is_paused") else f"at speed {status['speed']:g}"
    )
    times = f"  process {status['pid']}  simulated {status['sim_ns'] / 1e9:.3f} s {pasteable(pace)}"
    head = [
        Line([(f"bench {status['bench']}", "bold"), (times, "")], wraps=True),
        *(line(*each, wraps=True) for each in (*_health(status["health"]), *_lease(status), (told, ""))),
    ]
    if recording := list(_recording(status.get("recording") or {})):
        head.append(Line([(recording[0][0].removeprefix("\n"), recording[0][1]), *recording[1:]]))
    columns = ("device", "clients", "in", "out", "dropped", *MOTION, "state")
    rows = list[tuple[str, ...]]()
    for row in status["devices"]:
        shot = row["snapshot"]
        of_port = ("clients", "rx_bytes", "tx_bytes", "dropped_bytes")
        counts = [str(row[name]) if row["address"] else "-" for name in of_port]
        state = "see below" if _state(row) else "ok"
        is_real = row["hardware"] == "real"
        moves = _motion(shot) if shot else ("-", "-", "-", "real" if is_real else "-")
        rows.append((row["device"], *counts, *moves, "stopped" if row["failed"] else state))
        for name, other in row["snapshots"].items():
            rows.append((name, "", "", "", "", *_motion(other), ""))
    remarks = [(row["device"], _state(row)) for row in status["devices"]]
    wires: list[Line | Grid] = [] if status["segments"] else [line("")]
    for info, reports in _wires(status):
        wires += map(_wire_table, info.tables(reports))
        remarks += [(row[info.label], row["notes"]) for row in reports]
    remarks += [(row["target"], [f"fault {row['number']}: {row['kind']}"]) for row in status["faults"]]
    under_way = [line(f"run {run_line(row)}") for row in status["runs"][:RUNS]]
    if (more := len(status["runs"]) - RUNS) > 0:
        under_way.append(line(pasteable(f"and {more} more runs wait; see `hil run list`")))
    doors = [
        line(f"{kind}: {_bridge_line(row)}", "red" if row["insecure"] else "", wraps=True)
        for kind, row in status["bridges"].items()
    ]
    drives = [
        line(f"{row['device']}: {_drive_line(row['drive'])}", wraps=True)
        for row in status["devices"]
        if "drive" in row
    ]
    switches = [line(_switch_line(row), wraps=True) for row in status["switches"]]
    own = [line(_own_fields(row), wraps=True) for row in status["devices"] if row.get("fields")]
    adapters = [line(f"{name}: {echo_words(echo)}", wraps=True) for name, echo in status["echoes"].items()]
    table = Grid(columns, ("device", "state"), rows, gap=1, later=_LATER)
    below = (*wires, *switches, *own, *drives, *adapters, *under_way, *doors, *_remarks(remarks))
    return ShownView(*head, line(""), table, *below)


def _health(health: dict[str, Any]) -> Iterator[tuple[str, str]]:
    late = f": answers are right, and at most {health['late_ms']:.0f} ms late in the last minute"
    said = f"health: {health['state']}{late if health['state'] == 'late' else ''}"
    yield said, _HEALTH_STYLE.get(health["state"], "bold red")
    for problem in health["problems"]:
        about = f"{problem['about']}: " if problem["about"] else ""
        yield f"  {about}{problem['what']}; {problem['remedy']}", "red"


def _lease(status: dict[str, Any]) -> Iterator[tuple[str, str]]:
    if status.get("lease"):
        from hil.cli.bench.lease_commands import said

        for text in pasteable(said(status)).splitlines():
            yield f"lease: {text}", "yellow"


def _recording(row: dict[str, Any]) -> Iterator[tuple[str, str]]:
    if row.get("forked_from"):
        yield f"\na fork of      {pasteable(row['forked_from'])}", ""
    if row.get("path") or row.get("problem"):
        path = pasteable(row["path"] or "none")
        yield f"\nrecording     {path}", ""
        if row["problem"]:
            yield f"; {row['problem']}", "red"
    if before := row.get("before"):
        yield f"\nthe run before {before['end']}; to see its end: {pasteable(before['show'])}", "red"


def _bridge_line(row: dict[str, Any]) -> str:
    counts = f"{row['links']} links, {row['commands']} commands, {row['rejected']} rejected"
    if row["dropped"]:
        counts += f", {row['dropped']} dropped"
    warning = (
        f"; INSECURE: {row.get('risk', 'every program that can reach it may do everything')}"
        if row["insecure"]
        else ""
    )
    return f"{reached_at(row)}: {counts}{warning}"


def _switch_line(row: dict[str, Any]) -> str:
    wired = f", wired to {row['to']}" if row["to"] else ""
    return f"switch {row['switch']}: {'active' if row['is_active'] else 'not active'}{wired}"


def _own_fields(row: dict[str, Any]) -> str:
    return f"{row['device']}: {', '.join(f'{name} {value:.6g}' for name, value in row['fields'].items())}"


def _drive_line(drive: dict[str, Any]) -> str:
    age_ms, p50_ms, p99_ms = (drive[key] for key in ("age_ms", "round_trip_p50_ms", "round_trip_p99_ms"))
    age = "nothing was read yet" if age_ms is None else f"read {age_ms:.0f} ms ago"
    trips = "" if p50_ms is None else f", round trip p50 {p50_ms:.1f} ms, p99 {p99_ms:.1f} ms"
    counts = f"{drive['polls']} polls, {drive['time_outs']} time-outs, {drive['exceptions']} exceptions"
    who = ", ".join(f"{name} {value}" for name, value in drive["identity"].items())
    return f"{drive['state']}, {age}{trips}; {counts}, {drive['reconnects']} reconnects{who and '; '}{who}"


def _wires(status: dict[str, Any]) -> Iterator[tuple["WireInfo", list[dict[str, Any]]]]:
    """Reports on wires, by kind. Buses are looked for only if a wire is there: that is a third of a start."""
    if any(rows and isinstance(rows, list) for key, rows in status.items() if key not in _NO_WIRES):
        from hil.discovery.named_kinds import find_wire_infos

        yield from ((told, rows) for told in find_wire_infos().values() if (rows := status.get(told.key)))


def _wire_table(told: "WireView") -> Grid:
    return Grid(told.columns, told.texts, told.rows)


def _motion(shot: dict[str, Any]) -> tuple[str, str, str, str]:
    state = shown_state(shot)
    angles = (fixed(state.shaft_deg(shot), 2), fixed(state.board_deg(shot), 2))
    return *angles, fixed(shot.get("velocity_rpm"), 1), state.word(shot)


def doctor_view(findings: list["Diagnosis"]) -> ShownView:
    """View of ``hil doctor``: the findings, then costs and remedies; commands in them stay whole."""
    columns = ("verdict", "what", "found")
    rows = [(finding.verdict, finding.name, finding.found) for finding in findings]
    remarks = list[Line]()
    for finding in (each for each in findings if each.cost):
        said = [("\n" + finding.name, _VERDICT_STYLE[finding.verdict]), (f": {finding.cost}", "")]
        remarks.append(Line(said, wraps=True))
        remarks += [line(f"  {finding.remedy}", wraps=True)] if finding.remedy else []
    return ShownView(Grid(columns, columns, rows, prose=("found",)), *remarks)


def _remarks(devices: list[tuple[str, list[str]]]) -> list[Line]:
    """Whole sentences about devices, which a column would break up."""
    return [line(f"{device}: {said}", "red", wraps=True) for device, texts in devices for said in texts]


def _state(row: dict[str, Any]) -> list[str]:
    said = [f"stopped: {row['failed']}"] if row["failed"] else []
    said += [row["port_failure"]] if row["port_failure"] else []
    said += [f"flash: {row['flash']}"] if row["flash"] != "ok" else []
    said += [row["note"]] if row["note"] else []
    said += [f"{row['overrun_bytes']} bytes lost to overruns"] if row["overrun_bytes"] else []
    return said


def _histogram(buckets: list[int]) -> str:
    """Format counts by powers of two of nanoseconds, with the median, the 99th percentile and the largest."""
    total = sum(buckets)
    if not total:
        return "-"
    used = [i for i, count in enumerate(buckets) if count]
    peak = max(buckets)
    shown = buckets[used[0] : used[-1] + 1]
    bars = "".join(_BAR[-(-7 * count // peak)] if count else " " for count in shown)
    return (
        f"{duration(used[0] - 1)} {bars} {duration(used[-1])}"
        f"  p50 < {duration(percentile(buckets, 0.5))}, p99 < {duration(percentile(buckets, 0.99))}"
    )


def percentile(buckets: list[int], part: float) -> int:
    """Bucket of a histogram in which a part of the counts has been passed."""
    limit, seen = sum(buckets) * part, 0
    for index, count in enumerate(buckets):
        seen += count
        if seen >= limit:
            return index
    return len(buckets) - 1


def duration(power: int) -> str:
    """Format the upper bound of a bucket: a power of two of nanoseconds."""
    ns = float(2 ** max(power, 0))
    for unit in ("ns", "us", "ms"):
        if ns < 1000:
            return f"{ns:.3g} {unit}"
        ns /= 1000
    return f"{ns:.3g} s"


def field_lines(fields: dict[str, float | None]) -> Iterator[str]:
    """Lines of an axis's fields in columns: name, value, and the unit if the name does not end in it."""
    from hil.core.fields import FIELDS

    width = max(map(len, fields), default=0)
    for name, value in fields.items():
        field = FIELDS.get(name)
        said = shown_number(value, is_short=field is not None and field.type == "f32")
        if word := _WORDS.get(name) if value is not None else None:
            said = word(int(value or 0))
        unit = field.unit if field and not name.endswith(f"_{field.unit}") else ""
        yield f"{name:{width}}  {said} {unit}".rstrip()
    yield from ("\n" + said for field, said in _ANGLES.items() if field in fields)


def fields_view(axes: dict[str, dict[str, float | None]]) -> ShownView:
    """Show the fields of axes by their names; several have a heading each."""
    lines: list[str] = []
    for name, fields in axes.items():
        lines += [*([""] if lines else []), f"{name}:"] if len(axes) > 1 else []
        lines += field_lines(fields)
    return ShownView(line("\n".join(lines), wraps=True))


def tell_findings(findings: "list[Diagnosis]", as_json: bool) -> None:
    """Print the findings of a doctor, in their order. Raises Exit with 1: something is a problem."""
    from hil.host.doctor import healthy

    if as_json:
        typer.echo(json.dumps([dataclasses.asdict(finding) for finding in findings]))
    else:
        doctor_view(findings).print()
    if not healthy(findings):
        raise typer.Exit(1)
