"""Real boards in the daemon's answers, and verbs that go through their terminals."""

from typing import TYPE_CHECKING, Any

from hil.compose import load_dialogues
from hil.config import DeviceConfig
from hil.live.pass_through import PassThrough
from hil.vocab.dialogue import DialogueError

if TYPE_CHECKING:
    from hil.daemon import Daemon

CANNOT = "the daemon sees its terminal, not its pins, shaft or encoder; type at it with `hil monitor`"


class NoDialogue(Exception):
    """A real board's terminal has nothing for a verb."""


def listed(real: PassThrough, config: DeviceConfig) -> dict[str, Any]:
    """Its row of ``list``."""
    return {
        "device": real.name,
        "profile": config.profile,
        "hardware": "real",
        "port": config.port.kind,
        "address": real.client.address,
        "clients": real.client.stats().clients,
        "network": None,
        "failed": None,
        "at": config.at,
    }


def status(real: PassThrough) -> dict[str, Any]:
    """What ``status`` adds to the row."""
    client, board = real.client.stats(), real.board.stats()
    notes = [] if board.clients else [f"{real.board.address} is away, tried again each second"]
    if lost := board.unheard_bytes + board.dropped_bytes:
        notes.append(f"{lost} bytes for it were not sent")
    return {
        "connects": client.connects,
        "rx_bytes": client.rx_bytes,
        "tx_bytes": client.tx_bytes,
        "dropped_bytes": client.dropped_bytes + board.dropped_bytes,
        "unheard_bytes": client.unheard_bytes + board.unheard_bytes,
        "turned_away": client.turned_away,
        "backlog_bytes": real.client.backlog(),
        "overrun_bytes": 0,
        "note": "; ".join(notes) or None,
        "flash": "ok",
        "port_failure": real.failures.get("board"),
        "snapshot": None,
        "board": {"connects": board.connects, "rx_bytes": board.rx_bytes, "tx_bytes": board.tx_bytes},
    }


async def carry_out(daemon: "Daemon", device: str, verb: str) -> dict[str, Any]:
    """A verb, by a dialogue of the board's profile.

    Raises:
        NoDialogue: the profile has none for it.
        DialogueError: the board is away, or does not answer as it should.
    """
    profile = daemon.config.devices[device].profile
    if (dialogue := load_dialogues(profile).get(verb)) is None:
        raise NoDialogue(f"{device} is a real {profile}: its terminal has no {verb}; do it at the board")
    if daemon.real[device].is_held:
        raise DialogueError(f"{device}: a run has this board; cancel it, or wait for its end")
    await daemon.real_axes.carry_out(device, verb, dialogue())
    return {}
