"""Rates of the zenoh bridge that do not divide each other, nor a second."""

import json
import struct
from itertools import pairwise

import zenoh
from e2e_support import Place, config, free_port, until


def test_thirty_a_second_beside_ten(place: Place) -> None:
    port = free_port()
    options = {"listen": [f"tcp/127.0.0.1:{port}"], "packed_hz": 30, "state_hz": 10}
    server = place.serve(config(bridges={"zenoh": options}, bench="t")).ready()
    settings = zenoh.Config.from_json5(
        json.dumps(
            {
                "mode": "client",
                "connect": {"endpoints": [f"tcp/127.0.0.1:{port}"]},
                "scouting": {"multicast": {"enabled": False}},
            }
        )
    )
    packed: list[int] = []
    states: list[int] = []

    def on_packed(sample: zenoh.Sample) -> None:
        packed.append(struct.unpack_from("<q", sample.payload.to_bytes())[0])

    def on_state(sample: zenoh.Sample) -> None:
        states.append(json.loads(sample.payload.to_string())["at_ns"])

    with zenoh.open(settings) as session:
        first = session.declare_subscriber("hil/t/axis/m1/state/packed", on_packed)
        second = session.declare_subscriber("hil/t/axis/m1/state", on_state)
        until(lambda: len(packed) > 60 and len(states) > 20, "states")
        first.undeclare()
        second.undeclare()
    assert all(at_ns == round(at_ns * 30 / 10**9) * 10**9 // 30 for at_ns in packed)
    assert all(at_ns % 10**8 == 0 for at_ns in states)
    steps = [round((later - earlier) * 30 / 10**9) for earlier, later in pairwise(packed)]
    assert steps.count(1) > 0.9 * len(steps), "zenoh drops some where this machine has other work"
    status = server.ask("status")
    assert status["bridges"]["zenoh"]["dropped"] == 0
