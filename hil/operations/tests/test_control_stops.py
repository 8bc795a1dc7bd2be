"""Stops at the control socket: they wait for nobody, and what they overtake is refused."""

import asyncio
import json
from pathlib import Path
from typing import Any

from hil.net.fair_share import IN_A_PASS
from hil.operations.control_socket import ClaimedSocket, ControlServer
from hil.operations.table import OPERATIONS
from hil.testing.checks.recording_desk import RecordingDesk
from hil.vocab.verbs import Verb


def request(device: str, verb: str) -> bytes:
    return json.dumps({"verb": "do", "device": device, "name": verb, "parameters": {}}).encode()


def test_a_verb_that_waits_does_not_move_what_was_stopped_meanwhile(tmp_path: Path) -> None:
    desk = RecordingDesk(operations=OPERATIONS)
    desk.devices["m1"].verbs["stop"] = Verb("stop", "stop")
    asked = [*[request("m1", "wave")] * (IN_A_PASS + 3), request("m2", "wave"), request("m1", "stop")]

    async def main() -> list[dict[str, Any]]:
        claimed = ClaimedSocket(tmp_path / "control.sock", "b")
        server = ControlServer(desk, claimed)
        try:
            return await asyncio.wait_for(asyncio.gather(*map(server.answer, asked)), 30)
        finally:
            await server.close()
            claimed.release()

    *moves, of_other, stop = asyncio.run(main())
    assert [answer["ok"] for answer in moves] == [True] * IN_A_PASS + [False] * 3
    assert {answer["code"] for answer in moves[IN_A_PASS:]} == {"not_now"}
    assert of_other["ok"]
    assert stop["ok"]
    assert desk.done == [("m1", "wave")] * IN_A_PASS + [("m1", "stop"), ("m2", "wave")]
