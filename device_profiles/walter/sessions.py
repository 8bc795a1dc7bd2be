"""Recorded sessions with Walter's Cortex: how the reference writes them."""

from collections.abc import Mapping, Sequence
from typing import Any

from device_profiles.walter.arm_parts import LIGHTS_ADDRESS, LIGHTS_BUS, PARTS, SERVOS, STEPPERS
from device_profiles.walter.cortex_commands import OWN_WORDS
from hil.vocab.recorded_session import SessionPlan, SessionRefused, TimedText

_NO_TIME = {"baud": None, "bauds": {"logger": None, "servo": None, "printer": None}}
"""Bytes take no time in the reference."""
_KNOWN = "absent BUS ADDRESS, joint NUMBER DEG, servo_absent, knob COUNTS"


def session_plan(session: Mapping[str, Any]) -> SessionPlan | None:
    """Plan of a session of the reference; None: it is of something else.

    Raises:
        SessionRefused: it is of another mode, or its surroundings are unknown.
    """
    if not {"harness", "exchanges", "end_ms"} <= session.keys():
        return None
    if (mode := session.get("mode", "full")) != "full":
        raise SessionRefused(f"mode {mode!r}: sessions of the whole controller can be played, mode 'full'")
    device, faults = surroundings(session["harness"])
    exchanges: Sequence[Mapping[str, Any]] = session["exchanges"]
    inputs = [(float(each["t_ms"]), str(each["send"])) for each in exchanges]
    first_ms = inputs[0][0] if inputs else float(session["end_ms"])
    return SessionPlan(
        device=device,
        faults=faults,
        inputs=inputs,
        end_ms=float(session["end_ms"]),
        timelines={"": _timeline(session)},
        texts={"logger": session.get("log") or "", "printer": session.get("printer") or ""},
        texts_from_ms=first_ms,
        is_own_words=lambda line: line in OWN_WORDS,
    )


def _timeline(session: Mapping[str, Any]) -> list[TimedText]:
    if "timeline" in session:
        return [(float(at_ms), str(text)) for at_ms, text in session["timeline"]]
    replies = [
        (float(each["t_reply_first"]), str(each["reply"]))
        for each in session["exchanges"]
        if each.get("reply")
    ]
    return [(0.0, str(session.get("boot_output", ""))), *replies]


def surroundings(harness: Sequence[str]) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Device of a configuration, and faults, that are what a session's surroundings say.

    Raises:
        SessionRefused: they say something unknown.
    """
    axes: dict[str, dict[str, Any]] = {}
    faults: list[dict[str, Any]] = []
    for each in harness:
        words = str(each).split()
        try:
            match words:
                case ["servo_absent"]:
                    faults += [_silent(part.name) for part in SERVOS]
                case ["absent", bus, address]:
                    faults += _absent(int(bus, 16), int(address, 16), axes)
                case ["joint", number, deg]:
                    axes.setdefault(PARTS[int(number)].name, {})["axis"] = {"start_deg": float(deg)}
                case ["knob", counts]:
                    axes.setdefault(PARTS[0].name, {}).setdefault("registers", {})["knob_counts"] = int(
                        counts
                    )
                case _:
                    raise SessionRefused(f"harness {each!r} is unknown; known are: {_KNOWN}")
        except (ValueError, IndexError) as error:
            if isinstance(error, SessionRefused):
                raise
            raise SessionRefused(f"harness {each!r} cannot be read; known are: {_KNOWN}") from None
    return {"profile": "walter", **_NO_TIME, "axes": axes}, faults


def _silent(name: str) -> dict[str, Any]:
    return {"fault": "bus_no_answer", "target": f"d.{name}"}


def _absent(bus: int, address: int, axes: dict[str, dict[str, Any]]) -> list[dict[str, Any]]:
    if (bus, address) == (LIGHTS_BUS, LIGHTS_ADDRESS):
        axes.setdefault(PARTS[0].name, {}).setdefault("registers", {})["has_lights"] = 0
        return []
    found = [part.name for part in STEPPERS if (part.i2c_bus, part.i2c_address) == (bus, address)]
    if not found:
        raise SessionRefused(f"there is nothing at address 0x{address:02X} of bus {bus}")
    return [_silent(name) for name in found]
