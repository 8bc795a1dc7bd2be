"""Real boards in the daemon's answers, and verbs that go through their terminals."""

from typing import Any

from hil.compose import load_dialogues
from hil.config import DeviceConfig
from hil.live.board_end import BoardEnd
from hil.live.configured import Configured
from hil.live.joint import Joint
from hil.live.places import Places
from hil.live.runs.real_axes import RealAxes
from hil.vocab.dialogue import DialogueError

CANNOT = "the daemon sees its terminal, not its pins, shaft or encoder; type at it with `hil monitor`"


class NoDialogue(Exception):
    """A real board's terminal has nothing for a verb."""


def listed(real: Joint[BoardEnd], config: DeviceConfig) -> dict[str, Any]:
    """Its row of ``list``."""
    return {
        "device": real.label,
        "profile": config.profile,
        "hardware": "real",
        "port": config.port.kind,
        "address": real.port.address,
        "clients": real.port.stats().clients,
        "network": None,
        "failed": None,
        "at": config.at,
    }


def status(real: Joint[BoardEnd]) -> dict[str, Any]:
    """What ``status`` adds to the row."""
    client, board = real.port.stats(), real.end.line.stats()
    notes = [] if board.clients else [f"{real.end.line.address} is away, tried again each second"]
    if lost := board.unheard_bytes + board.dropped_bytes:
        notes.append(f"{lost} bytes for it were not sent")
    return {
        "connects": client.connects,
        "rx_bytes": client.rx_bytes,
        "tx_bytes": client.tx_bytes,
        "dropped_bytes": client.dropped_bytes + board.dropped_bytes,
        "unheard_bytes": client.unheard_bytes + board.unheard_bytes,
        "turned_away": client.turned_away,
        "backlog_bytes": real.port.backlog(),
        "overrun_bytes": 0,
        "note": "; ".join(notes) or None,
        "flash": "ok",
        "port_failure": real.failure,
        "snapshot": None,
        "board": {"connects": board.connects, "rx_bytes": board.rx_bytes, "tx_bytes": board.tx_bytes},
    }


async def carry_out(
    configured: Configured, places: Places, axes: RealAxes, device: str, verb: str
) -> dict[str, Any]:
    """A verb, by a dialogue of the board's profile.

    Raises:
        NoDialogue: the profile has none for it.
        DialogueError: the board is away, or does not answer as it should.
    """
    profile = configured.config.devices[device].profile
    if (dialogue := load_dialogues(profile).get(verb)) is None:
        raise NoDialogue(f"{device} is a real {profile}: its terminal has no {verb}; do it at the board")
    if places.boards()[device].end.is_held:
        raise DialogueError(f"{device}: a run has this board; cancel it, or wait for its end")
    await axes.carry_out(device, verb, dialogue())
    return {}
