"""Addresses of real CANopen drives."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridges.can.bus_kind import BUS
from bridges.can.drives.can_drive_address import (
    EXAMPLES,
    CanDriveAddress,
    CanPlace,
    can_drive_address,
)
from hil.config.real_places import kind_at
from hil.wire.address_keys import AddressRefused

assert BUS.drives
CAN = BUS.drives


@pytest.mark.parametrize(
    ("text", "place", "node", "said"),
    [
        ("can+socketcan://can0?node=5", CanPlace("socketcan", "can0"), 5, "can0, node 5"),
        (
            "can+slcan:///dev/ttyACM0?bitrate=500000&node=127",
            CanPlace("slcan", "/dev/ttyACM0", 500_000, 115_200),
            127,
            "/dev/ttyACM0, node 127",
        ),
        (
            "can+slcan://box:2000?baud=9600&bitrate=10000&node=1",
            CanPlace("slcan", "socket://box:2000", 10_000, 9600),
            1,
            "socket://box:2000, node 1",
        ),
        (
            "can+udp_multicast://239.74.163.2?node=7",
            CanPlace("udp_multicast", "239.74.163.2", port=43113),
            7,
            "239.74.163.2:43113, node 7",
        ),
        (
            "can+udp_multicast://[ff15::1]:5000?node=7",
            CanPlace("udp_multicast", "ff15::1", port=5000),
            7,
            "ff15::1:5000, node 7",
        ),
    ],
)
def test_addresses_are_read(text: str, place: CanPlace, node: int, said: str) -> None:
    address = can_drive_address(text)
    assert address == CanDriveAddress(place, node)
    assert str(address) == said


def test_examples_can_be_used_and_a_master_is_a_node() -> None:
    for text in EXAMPLES.values():
        assert can_drive_address(text).master is None
        assert can_drive_address(f"{text}&master=127").master == 127


@pytest.mark.parametrize(
    ("text", "why", "remedy"),
    [
        ("can+pcan://PCAN_USBBUS1?node=5", "there is no scheme 'can+pcan'", "write can+socketcan://can0"),
        ("can://can0?node=5", "there is no scheme 'can'", "write"),
        ("can+socketcan://can0", "no node is given", "write can+socketcan://can0?node=1"),
        ("can+socketcan://can0?node=0", "'0' is for all nodes at once", "write 1 to 127"),
        ("can+socketcan://can0?node=128", "'128' is no node", "write 1 to 127"),
        ("can+socketcan://can0?node=5&node=6", "node is there twice", "leave one of them out"),
        (
            "can+socketcan://can0?node=5&unit=6",
            "there is no 'unit' in this address",
            "known are: node",
        ),
        ("can+socketcan://can0?node", "not of the form key=value", "write can+socketcan"),
        ("can+socketcan://?node=5", "there is no name of a CAN interface", "`ip link`"),
        ("can+socketcan://a/b?node=5", "there is no name of a CAN interface", "`ip link`"),
        (
            "can+socketcan://can0?node=5&bitrate=1",
            "a bit rate is not set by this address",
            "ip link set",
        ),
        ("can+socketcan://can0?node=5&master=5", "node 5 is the drive", "write another master"),
        ("can+socketcan://can0?node=5&master=0", "'0' is for all nodes", "write 1 to 127"),
        ("can+slcan:///dev/ttyACM0?node=5", "no bit rate is given", "&bitrate=1000000"),
        (
            "can+slcan:///dev/ttyACM0?node=5&bitrate=83300",
            "'83300' is no bit rate",
            "one of 10000",
        ),
        ("can+slcan:///dev/ttyACM0?node=5&bitrate=1000000&baud=1", "'1' is no speed", "write 300 to"),
        ("can+slcan://ttyACM0?node=5&bitrate=1000000", "there is no path of a serial port", "three slashes"),
        ("can+slcan://box:70000?node=5&bitrate=1000000", "'70000' is no port", "write 1 to 65535"),
        ("can+udp_multicast://10.0.0.1?node=5", "no address of a multicast group", "239.255.255.255"),
        ("can+udp_multicast://239.1.1.256?node=5", "no address of a multicast group", "239.255.255.255"),
        ("can+udp_multicast://239.1.1.1:0?node=5", "'0' is no port", "43113"),
        ("can+udp_multicast://239.1.1.1?node=5&bitrate=5", "a bit rate is not set", "leave it out"),
    ],
)
def test_what_cannot_be_used_is_refused_with_its_remedy(text: str, why: str, remedy: str) -> None:
    assert kind_at(text, [CAN])
    with pytest.raises(AddressRefused) as error:
        can_drive_address(text)
    assert why in str(error.value)
    assert remedy in error.value.remedy


@given(st.sampled_from(list(EXAMPLES)), st.text(max_size=40))
def test_no_text_does_more_than_be_refused(scheme: str, rest: str) -> None:
    try:
        can_drive_address(f"{scheme}://{rest}")
    except AddressRefused as error:
        assert error.remedy  # noqa: PT017


def test_other_addresses_are_others() -> None:
    for text in ("/dev/ttyACM0", "modbus+tcp://h?unit=1", "canal+x://x", "can0", "socket://h:1"):
        assert not kind_at(text, [CAN])
