"""Bench that a command line means by the names on it, where several run and none is chosen."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hil.cli.framework.command_answers import chosen, names

if TYPE_CHECKING:
    from hil.net.benches_here import Here

_PATIENCE_S = 2.0


def bench_of_names(benches: "list[Here]", *, is_named: bool = False) -> "tuple[Here | None, str]":
    """Find the one bench of several that has all the parts that the command line names, and say which on the
    standard error; else None, and why none is chosen. ``is_named``: the command line names all of them by
    one name, and none is chosen."""
    from hil.net.control_client import ControlError

    several = f"several benches are running ({', '.join(each.name for each in benches)})"
    wanted = tuple(dict.fromkeys(each.partition(".")[0] for each in names if "/" not in each))
    if not wanted or is_named:
        return None, f"{several}: choose one with --bench"
    if known := [each for each in benches if each.folder in chosen]:
        return known[0], ""
    try:
        having = [each for each in benches if parts_of(each).issuperset(wanted)]
    except ControlError:  # one that does not answer may have them, too
        return None, f"{several}: choose one with --bench"
    if len(having) == 1:
        from hil.host.journal import say

        alike = [each for each in benches if each.name == having[0].name]
        of = having[0].name if len(alike) == 1 else str(having[0].folder)
        say(f"hil: {', '.join(wanted)}: on bench {of}", sys.stderr)
        chosen[:] = [having[0].folder]
        return having[0], ""
    if having:
        of = " and ".join(each.name for each in having)
        return None, f"{several}: choose one with --bench; {of} have {', '.join(wanted)}"
    return None, f"{several}, and none has {', '.join(wanted)}: choose one with --bench"


def parts_of(bench: "Here") -> set[str]:
    """Names of a bench's devices, lines and buses.

    Raises:
        ControlError: it does not answer.
    """
    from hil.net.control_client import ask

    rows = ask(bench.socket, "fault_places", timeout_s=_PATIENCE_S)
    return {row["place"].partition(".")[0] for row in rows}


def with_meaning(socket: Path, name: str, why: str) -> str:
    """Refusal of a name that no device has, with what has it, or what is meant; as it is if nothing is.
    ``name``: empty: those of the command line."""
    from hil.net.control_client import ControlError, ask

    try:
        status = ask(socket, "status", timeout_s=_PATIENCE_S)
    except ControlError:
        return why
    devices = [row["device"] for row in status["devices"]]
    meanings = (
        _meaning(each, status, devices) for each in ([name] if name else names) if each not in devices
    )
    said = next(filter(None, meanings), "")
    return f"{why.partition('; ')[0]}; {said}" if said else why


def _meaning(name: str, status: dict[str, Any], devices: list[str]) -> str:
    """Words for what a name is in a bench that is no device's, with what is done with it."""
    owner = name.partition(".")[0]
    if at := [row["device"] for row in status["devices"] if row.get("address") == name]:
        return f"this is the port of {at[0]}; write {at[0]}"
    if name.startswith("/dev/") or "://" in name:
        return "a bench reaches a real board by `port: {kind: serial, url: ...}`: `hil docs real-boards`"
    if "," in name and set(name.split(",")) <= set(devices):
        return f"write names apart, as in {name.replace(',', ' ')}"
    if name == "all" and names == [name]:
        alone = "`hil stop` alone stops all" if "stop" in sys.argv else "write one device"
        return f"{alone}; there are {', '.join(devices)}"
    if name in (row["bus"] for row in status["buses"]):
        return f"it is a CAN bus: `hil capture {name}`, `hil can send {name} FRAME`"
    if name in (row["segment"] for row in status["segments"]):
        return f"it is a segment, a wire: `hil capture {name}` shows what passes there"
    if name in (row["tap"] for row in status["taps"]):
        return f"it is a tap of {owner}: `hil capture {name}`, `hil line send {name} NODE COMMAND`"
    if "." in name and owner in devices:
        return f"write {owner}, the device alone"
    typed = [word for word in sys.argv if word in devices]
    return f"the device comes first, as in {typed[0]} {name}" if typed and names == [name] else ""


def is_bench(word: str) -> bool:
    """True if a bench of this name runs here."""
    import os

    from hil.net.benches_here import find

    return any(each.name == word for each in find(None, os.environ).benches)
