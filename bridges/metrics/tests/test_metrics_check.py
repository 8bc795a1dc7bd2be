"""Shipped check of bridges, passed by the metrics bridge."""

import pytest

from bridges.metrics.bridge import Options, make
from hil.testing import RecordingDesk, check_bridge
from hil.vocab.monitoring import Metric


def desk() -> RecordingDesk:
    metric = Metric("hil_ports", "gauge", "ports that are open")
    return RecordingDesk({"metrics": [(metric, [((), 2.0)])]})


@pytest.mark.long
def test_it_keeps_to_what_bridges_keep_to() -> None:
    options = Options(listen="127.0.0.1:0")
    check_bridge(lambda desk: make(options, desk), request=b"GET /metrics HTTP/1.1\r\n\r\n", desk=desk)
