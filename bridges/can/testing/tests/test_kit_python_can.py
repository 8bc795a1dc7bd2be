"""python-can's interface to a bus of the kit, in simulated time."""

import can
import pytest

from bridges.can.testing.can_faces import CanBusFace
from hil.vocab.time import NS_PER_MS


def vendor_request(node: int) -> can.Message:
    return can.Message(
        arbitration_id=0x600 + node, data=bytes.fromhex("4018100100000000"), is_extended_id=False
    )


def test_a_drive_answers_and_time_is_simulated(canbus) -> None:  # type: ignore[no-untyped-def]
    here: CanBusFace = canbus(2)
    here.bench.run(ms=10)
    with here.python_can() as bus:
        bus.send(vendor_request(2))
        began_ns = here.bench.now_ns
        answer = bus.recv(1)
        assert answer is not None
        assert (answer.arbitration_id, bytes(answer.data[:4])) == (0x582, bytes.fromhex("43181001"))
        assert began_ns < answer.timestamp * 1e9 <= here.bench.now_ns < began_ns + 3 * NS_PER_MS
        assert bus.recv(0) is None
        before_ns = here.bench.now_ns
        assert bus.recv(0.25) is None
        assert here.bench.now_ns == before_ns + 250 * NS_PER_MS


def test_filters_and_what_cannot_be_sent(canbus) -> None:  # type: ignore[no-untyped-def]
    here: CanBusFace = canbus()
    with here.python_can() as bus, here.python_can("other") as other:
        bus.set_filters([{"can_id": 0x200, "can_mask": 0x7FF, "extended": False}])
        for number in (0x100, 0x200, 0x300):
            other.send(can.Message(arbitration_id=number, is_extended_id=False))
        assert [message.arbitration_id for message in iter(lambda: bus.recv(0.01), None)] == [0x200]
        for wrong in (can.Message(is_fd=True), can.Message(is_error_frame=True)):
            with pytest.raises(can.CanOperationError, match="classic CAN alone"):
                bus.send(wrong)
        with pytest.raises(can.CanOperationError, match="with 11 bits it is 0 to 0x7ff"):
            bus.send(can.Message(arbitration_id=0x800, is_extended_id=False))
    assert here.state("can0.other") == "off", "it has left the bus"


def test_it_is_the_same_again(canbus) -> None:  # type: ignore[no-untyped-def]
    def heard() -> list[tuple[float, int, bytes]]:
        here: CanBusFace = canbus(3)
        with here.python_can() as bus:
            for node in (3, 1, 2):
                bus.send(vendor_request(node))
            rows = iter(lambda: bus.recv(0.02), None)
            return [(row.timestamp, row.arbitration_id, bytes(row.data)) for row in rows]

    first = heard()
    assert [row[1] for row in first if row[1] >= 0x580 and row[1] < 0x600] == [0x583, 0x581, 0x582]
    assert heard() == first


def test_the_canopen_library_with_its_thread(canbus) -> None:  # type: ignore[no-untyped-def]
    import canopen

    here: CanBusFace = canbus()
    with here.python_can() as bus:
        network = canopen.Network(bus=bus)
        network.connect()
        try:
            node = network.add_node(1, canopen.ObjectDictionary())
            assert len(node.sdo.upload(0x1018, 1)) == 4
        finally:
            network.notifier.stop()
