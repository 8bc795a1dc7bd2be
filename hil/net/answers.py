"""Forms of the answers of operations in JSON, as far as commands read them. ``hil.operations.table`` takes
its forms from here: a command in a shell waits for this module, and not for what answers.

A form is a type (``float`` takes an int, too; neither is a bool), a value, a list with the form of its items,
a dict with forms by key (``str``: of all values), or a tuple of forms of which one has to fit. Other keys may
be there.
"""

from typing import Any

from hil.net.axis_states import SHOWN_STATES
from hil.vocab.monitoring import EVENT_KINDS

_MAYBE_TEXT, _MAYBE_NUMBER = (str, None), (float, None)
_SHOWN = 60
_TOO_LARGE = 2**80
_ROW: dict[str, Any] = {
    "device": str,
    "profile": str,
    "hardware": str,
    "port": _MAYBE_TEXT,
    "greeting": str,
    "address": _MAYBE_TEXT,
    "clients": int,
    "network": _MAYBE_TEXT,
    "ports": {str: {"kind": str, "address": str, "clients": int}},
    "axes": [str],
    "failed": _MAYBE_TEXT,
}
_LIST: dict[str, Any] = {
    "bench": str,
    "pid": int,
    "devices": [({**_ROW, "network": None}, _ROW | {"network": str, "network_clients": int})],
    "taps": [{"tap": str, "kind": str, "port": str, "clients": int}],
    "nodes": [{"node": str, "id": int, "bus": str}],
}
_SHOT: Any = (None, *(state.form for state in SHOWN_STATES.values()))
_FAULT: dict[str, Any] = {"number": int, "kind": str, "target": str, "parameters": dict, "begin_ns": int}
_PROBLEM: dict[str, Any] = {"kind": str, "about": str, "what": str, "remedy": str}
_SEGMENT: dict[str, Any] = {
    "segment": str,
    "stations": dict,
    "load": float,
    "packets": int,
    "collisions": int,
    "errors": {str: int},
    "nodes": {
        str: dict.fromkeys(("unit", "requests", "answers", "exceptions"), int) | {"refusal": _MAYBE_TEXT}
    },
    "notes": [str],
}
_BUS: dict[str, Any] = {
    "bus": str,
    "bit_rate": int,
    "load_percent": float,
    "frames": int,
    "errors": {str: int},
    "nodes": {
        str: dict.fromkeys(("sent", "heard", "transmit_errors", "receive_errors"), int)
        | {"state": str, "errors": {str: int}}
    },
    "drives": {str: {"id": int, "state": str}},
    "notes": [str],
}
_BRIDGE: dict[str, Any] = {
    "root": str,
    "listen": [str],
    "connect": [str],
    "links": int,
    "commands": int,
    "rejected": int,
    "dropped": int,
    "insecure": (True, False),
}
_LEASE: dict[str, Any] = {
    "lease": (
        None,
        {"user": str, "why": str, "doors": [str], "closed": [str], "undelivered": {str: int}}
        | {"since_wall_ns": int, "until_wall_ns": int, "left_s": float},
    )
}
_STATUS: dict[str, Any] = (
    _LIST
    | {
        "devices": [
            _ROW
            | dict.fromkeys(("rx_bytes", "tx_bytes", "dropped_bytes", "overrun_bytes"), int)
            | {
                "note": _MAYBE_TEXT,
                "port_failure": _MAYBE_TEXT,
                "flash": str,
                "snapshot": _SHOT,
                "snapshots": {str: _SHOT},
            }
        ],
        "health": {"state": str, "late_ms": float, "problems": [_PROBLEM]},
        "bridges": {str: _BRIDGE},
        "echoes": {str: {"state": str, "bytes": int, "collisions": int}},
        "segments": [_SEGMENT],
        "buses": [_BUS],
        "switches": [{"switch": str, "axis": str, "to": _MAYBE_TEXT, "is_active": (True, False)}],
        "faults": [_FAULT],
        "runs": [
            {"run": str, "state": str, "step": int, "steps": int}
            | {"why": _MAYBE_TEXT, "left_s": _MAYBE_NUMBER}
        ],
        "recording": {
            "forked_from": _MAYBE_TEXT,
            "path": _MAYBE_TEXT,
            "problem": _MAYBE_TEXT,
            "before": (None, {"path": str, "end": str, "show": str}),
        },
        "is_paused": (True, False),
        "rt_line": str,
        "speed": float,
        "wake_latency": [int],
        "lag": [int],
    }
    | _LEASE
    | dict.fromkeys(("rate_hz", "sim_ns", "elapsed_ns", "ticks", "missed", "overruns"), int)
)
ABSENT = object()
"""Form of a key that is not there."""
_AT: dict[str, Any] = {"effective_at_ns": int}
_RUN: dict[str, Any] = {
    "run": str,
    "state": ("queued", "running", "done", "failed", "cancelled"),
    "step": int,
    "steps": int,
    "submissions": int,
    "planned_end_ns": _MAYBE_NUMBER,
    "why": _MAYBE_TEXT,
    "axes": {
        str: {"target_deg": float, "at_end": (None, "stands", "moves", "off", "failed", "unknown")}
        | dict.fromkeys(("commanded_deg", "position_deg", "error_max_deg", "error_rms_deg"), _MAYBE_NUMBER)
    },
    "benches": {str: {"state": str, "clock_offset_ns": float, "clock_error_ns": float}},
}
_FIGURES = {"lines": int, "duration_s": float, "feed_mm": float, "rapid_mm": float}
_PLAN: dict[str, Any] = {
    "duration_s": float,
    "is_exact": (True, False),
    "axes": {str: {"at_s": [float], "position_deg": [float]}},
    "steps": [[(float, str)]],
    "steps_left_out": int,
}
_PROBLEMS: dict[str, Any] = {"problems": str}
_PAST: dict[str, Any] = {
    "end_ns": int,
    "ready_ns": int,
    "is_growing": (True, False),
    "problem": str,
    "begun": _MAYBE_TEXT,
    "speed": float,
    "revision": int,
}
_MARK: dict[str, Any] = {"lane": str, "from_ns": int, "to_ns": _MAYBE_NUMBER, "of": str, "text": str}
_EVENT: dict[str, Any] = (
    {"kind": tuple(EVENT_KINDS)}
    | dict.fromkeys(("number", "revision", "at_ns", "to_ns", "count"), int)
    | dict.fromkeys(("of", "who", "text"), str)
)
_DICTS = (
    *(
        "reset",
        "pin",
        "set",
        "type",
        "send",
        "unwatch",
        "capture",
        "play",
        "detach",
        "stop",
        "count",
        "debug",
    ),
)
FORMS: dict[str, Any] = dict.fromkeys(_DICTS, dict) | {
    "attach": _AT | {"node": str, "free": int},
    "transmit": _AT | {"refused": int, "free": int},
    "load_program": _AT | {"program": str},
    "processor": {
        **dict.fromkeys(("device", "program", "flash", "data"), str),
        **dict.fromkeys(("crystal_Hz", "cycles", "pc", "stack_lowest"), int),
        **dict.fromkeys(("is_running", "is_halted"), (True, False)),
        "pins": {
            str: {
                "level": int,
                "is_output": (True, False),
                "has_pull_up": (True, False),
                "duty": _MAYBE_NUMBER,
                "wired": [str],
            }
        },
        "symbols": [[(str, int)]],
    },
    "counted": {"cycles": int, "rows": [[int]], "laps": [int]},
    "zero": _AT | {"was_deg": float, "board_deg": _MAYBE_NUMBER},
    "list": _LIST,
    "status": _STATUS,
    "read_text": (str, dict),
    "registers": {
        "device": str,
        "profile": str,
        "version": int,
        "crc": int,
        "notes": [str],
        "rows": [
            dict.fromkeys(("table", "type", "name", "unit", "about"), str)
            | {"address": int, "registers": int, "is_writable": (True, False)}
        ],
    },
    "eds": {"node": str, "text": str},
    "wait": {"interrupted": (True, False)},
    "health": {"state": str},
    "state": {str: (float, None)},
    "drive": _AT | {"length_ns": int},
    "watch": {"watch": int, "signals": [str]},
    "samples": {"rows": [[float]], "lost": int},
    "inject": {"number": int},
    "clear": dict,
    "faults": [_FAULT],
    "fault_places": [{"place": str, "sort": str, "of": str, "wire": str, "kinds": [str]}],
    "do": {str: (str, float, True, False, None, list, dict)},
    "verbs": [{"verb": str, "about": str, "parameters": {str: str}, "texts": [str]}],
    "run": (
        _RUN,
        _PROBLEMS,
        {"run": str, "steps": int, "state": ABSENT, "plan": ABSENT},
        {"run": str, "steps": int, "state": ABSENT, "plan": _PLAN},
    ),
    "runs": [_RUN],
    "drawing": (
        {"problems": [str], "of": ("machine", "program")},
        {
            "problems": [str],
            "remarks": [str],
            "machine": str,
            "figures": _FIGURES,
            "axes": [
                {"letter": str, "axis": str, "deg_per_unit": float, "zero_deg": float, "range": [float]}
            ],
            "path": {"places": [float], "count": int},
            "runs": [{"text": str, "duration_s": float, "timeline": [[float]]}],
        },
        {"problems": [str], "remarks": [str], "machine": str, "figures": _FIGURES, "path": ABSENT},
    ),
    "past": (_PAST | {"marks": [_MARK]}, _PAST | {"marks": ABSENT}),
    "past_state": {
        "at_ns": int,
        "axes": {str: {str: _MAYBE_NUMBER}},
        "failed": {str: str},
        "faults": [_FAULT],
    },
    "past_samples": {
        "at_ns": int,
        "from_ns": int,
        "interval_ns": int,
        "series": [{"axis": str, "fields": [str], "is_summed": (True, False), "rows": int, "data": str}],
    },
    "past_bytes": {"at_ns": int, "items": [{"at_s": float, "to": ("board", "client"), "hex": str}]},
    "past_packets": {"at_ns": int, "items": [dict], "left_out": int},
    "past_find": {"found_ns": _MAYBE_NUMBER, "looked_from_ns": int, "looked_to_ns": int, "end_ns": int},
    "cancel_run": _RUN,
    "pace_run": _RUN,
    "about": {
        **dict.fromkeys(("bench", "version", "host", "config_digest"), str),
        "protocol": int,
        "labels": {str: str},
        "devices": {str: {"profile": str, "axes": [str], "is_real": (True, False)}},
        "lease": (None, {"user": str, "why": str, "since_wall_ns": int, "until_wall_ns": int}),
        "health": {"state": str, "problems": [_PROBLEM], "problems_left_out": int},
        "runs": [{"run": str, "state": str, "step": int, "steps": int, "why": _MAYBE_TEXT}],
        "commanders": [{"who": str, "what": str, "of": str, "wall_ns": int}],
        "metrics": str,
        "recording": _MAYBE_TEXT,
    },
    "benches": [
        (
            {"bench": str, "why": str},
            {"bench": str, "why": None, "version": str, "clock_offset_ns": float, "clock_error_ns": float},
        )
    ],
    "segments": [_SEGMENT],
    "buses": [_BUS],
    "halt": {"stopped": [str], "runs": [str], "refused": {str: str}},
    "stop_site": {
        "benches": [
            {
                "bench": str,
                "state": ("confirmed", "refused", "silent"),
                "why": _MAYBE_TEXT,
                "took_s": _MAYBE_NUMBER,
                "stopped": [str],
                "runs": [str],
                "refused": {str: str},
            }
        ]
    },
    "events": {"events": [_EVENT], "left_out": int, "revision": int},
    **dict.fromkeys(("lease", "take_lease", "renew_lease", "give_lease", "break_lease"), _LEASE),
    "pause": {"sim_ns": int},
    "resume": {"sim_ns": int},
    "reload": (_PROBLEMS, {key: [str] for key in ("removed", "restarted", "added", "kept")}),
}


def misfit(verb: str, result: Any) -> str:
    """Reason why an answer does not have its form, or empty; a verb that is not known may answer anything."""
    return _misfit(FORMS[verb], result, "result") if verb in FORMS else ""


def _misfit(form: Any, value: Any, where: str) -> str:
    if isinstance(form, tuple):
        found = [_misfit(each, value, where) for each in form]
        return "" if "" in found else max(found, key=len)
    if isinstance(form, list):
        if not isinstance(value, list):
            return f"{where} is {_shown(value)}"
        return next(
            filter(None, (_misfit(form[0], each, f"{where}[{i}]") for i, each in enumerate(value))), ""
        )
    if isinstance(form, dict):
        return _misfit_object(form, value, where)
    if isinstance(form, type):
        kinds = (int, float) if form is float else form
        fits = isinstance(value, kinds) and not isinstance(value, bool)
        if fits and isinstance(value, int | float):
            fits = abs(value) < _TOO_LARGE  # nor is NaN
        return "" if fits else f"{where} is {_shown(value)}"
    return "" if type(value) is type(form) and value == form else f"{where} is {_shown(value)}"


def _misfit_object(form: dict[Any, Any], value: Any, where: str) -> str:
    if not isinstance(value, dict):
        return f"{where} is {_shown(value)}"
    if str in form:
        return next(
            filter(
                None, (_misfit(form[str], each, f"{where}.{key[:_SHOWN]}") for key, each in value.items())
            ),
            "",
        )
    for key, each in form.items():
        if each is ABSENT:
            if key in value:
                return f"{where} has {key}"
            continue
        if key not in value:
            return f"{where} has no {key}"
        if why := _misfit(each, value[key], f"{where}.{key}"):
            return why
    return ""


def _shown(value: Any) -> str:
    text = repr(value) if not isinstance(value, list | dict) else f"a {type(value).__name__}"
    return text if len(text) <= _SHOWN else text[:_SHOWN] + "..."
