"""The log that a bench keeps of itself has what nodes of a test send on a CAN bus."""

import io

import can

from bridges.can.testing.can_faces import CanBusFace
from hil.sim.inputs import Frames
from hil.testing import replay


def test_frames_of_a_test_replay(canbus) -> None:  # type: ignore[no-untyped-def]
    here: CanBusFace = canbus(2)
    here.bench.run(ms=10)
    here.send(0x000, bytes((1, 0)))
    here.send(0x080, at_ms=13.5)
    drive, other = here.drives()
    drive.boot()
    other.boot()
    drive.await_ready()
    drive.enable()
    with here.python_can() as bus:
        bus.send(
            can.Message(arbitration_id=0x602, data=bytes.fromhex("4018100100000000"), is_extended_id=False)
        )
        assert bus.recv(1)
    text = io.StringIO()
    here.bench.inputs.write_to(text)
    frames = [logged for logged in here.bench.inputs.inputs if isinstance(logged.input, Frames)]
    assert {logged.device for logged in frames} == {"can0.tester", "can0.python-can"}
    assert 13_500_000 in [logged.at_ns for logged in frames]
    replayed = replay(text.getvalue().splitlines(keepends=True))
    assert replayed.difference() is None
    assert len(replayed.sent["m1"]) > 10, "what its CAN card sent, too"
