"""Commands ``hil can``."""

import time
from typing import Annotated, Any

import typer

from hil.vocab.dialogue import BoardRefusal
from hil.vocab.profile import AskBench

app = typer.Typer(
    name="can",
    help="CAN buses, and their CANopen nodes.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
_NODE = "hil"
"""Name of the node that sends, behind the bus's: no tap and no channel of a bench has it."""
_PATIENCE_S = 2.0
"""Time for which frames wait for their turn, and for an acknowledgement."""
_LOOK_S = 0.02


@app.callback(rich_help_panel="Wire")
def _commands() -> None:
    pass


@app.command()
def eds(
    device: Annotated[str, typer.Argument(help="An axis with a node on a CAN bus.", show_default=False)],
    ask: AskBench,
) -> tuple[Any, str]:
    """Print the electronic data sheet (EDS) of an axis's CANopen node, for the tools of masters.

    Example: hil can eds m1
    """
    answer = ask("eds", device=device.removesuffix(".canopen"))
    return answer, answer["text"].rstrip("\n")


@app.command()
def send(
    bus: Annotated[str, typer.Argument(help="A CAN bus.", show_default=False)],
    frames: Annotated[
        list[str],
        typer.Argument(
            help="Each as candump writes it: identifier, #, data; R for a remote frame.",
            metavar="FRAME...",
            show_default=False,
        ),
    ],
    ask: AskBench,
) -> tuple[Any, str]:
    """Send frames on a CAN bus, one after the other.

    They come from a node of their own, which leaves the bus behind the last. An identifier of 8 digits has
    29 bits. Exits with 1 if some were not sent within 2 s: another node has to acknowledge them.

    Example: hil can send can0 605#4000100000000000
    """
    node = ask("attach", bus=bus, node=_NODE)["node"]
    try:
        before = _sent(ask, bus, node)
        refused = ask("transmit", channel=node, frames=frames)["refused"]
        wanted, end_s = len(frames) - refused, time.monotonic() + _PATIENCE_S
        while (sent := _sent(ask, bus, node) - before) < wanted and time.monotonic() < end_s:
            time.sleep(_LOOK_S)
    finally:
        ask("detach", channel=node)
    if sent < len(frames):
        raise BoardRefusal(
            f"{node} has sent {max(sent, 0)} of {len(frames)} frames; does another node on {bus} acknowledge"
            f" them? `hil status` has its errors"
        )
    return {"node": node, "sent": sent}, f"{node} sent {sent} frame{'s' if sent > 1 else ''} on {bus}"


def _sent(ask: AskBench, bus: str, node: str) -> int:
    (row,) = (each for each in ask("buses") if each["bus"] == bus)
    return int(row["nodes"][node]["sent"])
