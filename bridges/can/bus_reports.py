"""Reports on CAN buses: metrics, kinds of problems, tables of ``hil status``."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from hil.vocab.metrics import Metric
from hil.vocab.wire import Report, WireInfo, WireMetric, WireView, counted, errors_of, one_of

_OF_NODES = ("id", "state", "sent", "heard", "TEC", "REC", "errors", "drive")
_COUNTS = ("sent", "heard", "transmit_errors", "receive_errors")


def _tables(reports: Sequence[Report]) -> Iterable[WireView]:
    """Table of buses, and that of the controllers on them."""
    buses, nodes = list[Sequence[str]](), list[Sequence[str]]()
    for each in reports:
        load = f"{each['load_percent']:.1f}%"
        frames, errors = str(each["frames"]), counted(each["errors"])
        buses.append((each["bus"], str(each["bit_rate"]), load, frames, errors))
        for name, node in each["nodes"].items():
            drive, wrong = each["drives"].get(name, {}), str(sum(node["errors"].values()))
            counts = [str(node[key]) for key in _COUNTS]
            state = str(drive.get("state", ""))
            nodes.append((name, str(drive.get("id", "")), node["state"], *counts, wrong, state))
    yield WireView(("bus", "bit/s", "load", "frames", "errors"), ("bus", "errors"), buses)
    yield WireView(("node", *_OF_NODES), ("node", "state", "drive"), nodes)


def _of_nodes(name: str, kind: Any, about: str, read: Callable[[Report], float]) -> WireMetric:
    return WireMetric(
        Metric(name, kind, about, ("node",)),
        lambda _, told: [((node,), read(counters)) for node, counters in told["nodes"].items()],
    )


REPORTS = WireInfo("buses", "bus", _tables, (
    one_of("hil_can_frames_total", "counter", "frames on a CAN bus", "bus", lambda told: told["frames"]),
    errors_of("hil_can_errors_total", "errors on a CAN bus", "bus"),
    one_of("hil_can_load_ratio", "gauge", "share of the time that the bus was busy", "bus",
           lambda told: told["load_percent"] / 100),
    _of_nodes("hil_can_node_sent_total", "counter", "frames of a node or a tap", lambda of: of["sent"]),
    _of_nodes("hil_can_node_transmit_errors", "gauge", "its transmit error counter",
              lambda of: of["transmit_errors"]),
    _of_nodes("hil_can_node_receive_errors", "gauge", "its receive error counter",
              lambda of: of["receive_errors"]),
    _of_nodes("hil_can_node_bus_off", "gauge", "1 if it is bus-off",
              lambda of: int(of["state"] == "bus-off")),
), (("bus", "a client has opened a tap of a CAN bus with a wrong bit rate"),))  # fmt: skip
