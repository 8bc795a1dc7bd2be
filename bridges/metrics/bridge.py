"""The metrics bridge's options, and how it is made. A configuration is checked without the rest of it."""

from typing import TYPE_CHECKING

from bridges.metrics.metrics_options import Options

if TYPE_CHECKING:
    from hil.vocab.bridge_protocol import Bridge
    from hil.vocab.desk_protocol import Desk

__all__ = ["Options", "make", "reference"]


def make(options: Options, desk: "Desk") -> "Bridge":
    from bridges.metrics.metrics_bridge import MetricsBridge

    return MetricsBridge(options, desk)


def reference() -> str:
    """Part of the reference about what is served; the table of metrics is the daemon's."""
    from bridges.metrics.metrics_bridge import reference as part

    return part()
