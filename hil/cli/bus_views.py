"""Tables of CAN buses in ``hil status``."""

from collections.abc import Iterator
from typing import Any

from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

_OF_NODES = ("id", "state", "sent", "heard", "TEC", "REC", "errors", "drive")


def bus_tables(rows: list[dict[str, Any]]) -> Iterator[RenderableType]:
    """Make the table of buses, and that of the controllers on them."""
    buses, nodes = Table(box=None), Table(box=None)
    for column in ("bus", "bit/s", "load", "frames", "errors"):
        buses.add_column(column, justify="left" if column in ("bus", "errors") else "right")
    for column in ("node", *_OF_NODES):
        is_text = column in ("node", "state", "drive")
        nodes.add_column(column, justify="left" if is_text else "right", overflow="fold")
    for row in rows:
        load = f"{row['load_percent']:.1f}%"
        buses.add_row(row["bus"], str(row["bit_rate"]), load, str(row["frames"]), _errors(row["errors"]))
        for name, node in row["nodes"].items():
            drive = row["drives"].get(name, {})
            counts = [str(node[key]) for key in ("sent", "heard", "transmit_errors", "receive_errors")]
            nodes.add_row(
                name, str(drive.get("id", "")), node["state"], *counts, str(sum(node["errors"].values())),
                Text(str(drive.get("state", ""))),
            )  # fmt: skip
    yield buses
    yield nodes


def _errors(errors: dict[str, int]) -> str:
    return ", ".join(f"{count} {kind}" for kind, count in errors.items()) or "none"
