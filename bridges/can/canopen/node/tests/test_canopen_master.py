"""A node under the master of the ``canopen`` library: SDO, PDO, EMCY, NMT, LSS, EDS."""

import io
from typing import Any

import canopen
import canopen.lss
import pytest
from canopen.objectdictionary.eds import import_eds
from canopen_rig import IDENTITY, NODE, Rig

from bridges.can.canopen.node.application import Access, DataType
from bridges.can.canopen.node.eds import eds_text
from bridges.can.canopen.node.object_dictionary import key_of
from bridges.can.frames.can_frame import CanFrame

SIZES = (0, 1, 4, 5, 7, 8, 14, 888, 889, 890, 2000, 4096)
SILENCE_S = 0.001
"""Time that the library waits: what the node answers is there when it begins to."""


class Master(canopen.Network):
    """The library's network with a node on it, and nothing that waits."""

    def __init__(self, rig: Rig) -> None:
        super().__init__()
        self.rig = rig
        rig.listeners.append(self._hear)
        self.lss.RESPONSE_TIMEOUT = SILENCE_S
        rig.take()

    def send_message(self, can_id: int, data: Any, remote: bool = False) -> None:
        self.rig.node.hear(CanFrame(can_id, b"" if remote else bytes(data), False, remote), self.rig.now_ns)

    def _hear(self, frame: CanFrame) -> None:
        self.notify(frame.id, bytearray(frame.data), self.rig.now_ns / 1e9)


@pytest.fixture
def rig() -> Rig:
    return Rig()


@pytest.fixture
def remote(rig: Rig) -> canopen.RemoteNode:
    """The node as the master sees it, by its EDS."""
    text = eds_text(rig.node.dictionary, IDENTITY, "stub.eds")
    node: canopen.RemoteNode = Master(rig).add_node(NODE, import_eds(io.StringIO(text), NODE))
    node.sdo.RESPONSE_TIMEOUT = SILENCE_S
    return node


def indexes_in(found: canopen.ObjectDictionary) -> set[int]:
    """Indexes that a file has, without its dummies."""
    return {index for index in found if index >= 0x1000}


def test_the_reader_of_eds_finds_the_table(rig: Rig, remote: canopen.RemoteNode) -> None:
    found = remote.object_dictionary
    entries = rig.node.dictionary.entries.values()
    assert indexes_in(found) == {entry.index for entry in entries}
    for entry in entries:
        variable = found.get_variable(entry.index, entry.subindex)
        assert variable is not None, entry
        assert variable.name == entry.name
        assert variable.data_type == entry.data_type
        assert variable.readable == (entry.access is not Access.WO)
        assert variable.writable == (entry.access in (Access.WO, Access.RW))
        assert variable.pdo_mappable == bool(entry.mapping)
        if not isinstance(entry.default, bytes | float):
            assert variable.default == entry.default + NODE * entry.adds_node_id
            assert (variable.min, variable.max) == (entry.low, entry.high)
    assert found.device_information.product_name == "stub"
    assert found.device_information.nr_of_RXPDO == found.device_information.nr_of_TXPDO == 4


def test_all_that_can_be_read_is_what_the_node_has(rig: Rig, remote: canopen.RemoteNode) -> None:
    for entry in rig.node.dictionary.entries.values():
        if entry.access is Access.WO or entry.is_live or entry.index == 0x1021:
            continue
        variable = remote.sdo.get_variable(entry.index, entry.subindex)
        value = rig.node.dictionary.values[key_of(entry.index, entry.subindex)]
        if entry.data_type in (DataType.VISIBLE_STRING, DataType.DOMAIN):
            assert variable.data == value
        else:
            assert variable.raw == value, entry


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("is_forced", [False, True])
def test_sdo_in_one_frame_and_by_segments(remote: canopen.RemoteNode, size: int, is_forced: bool) -> None:
    data = bytes(i * 7 & 0xFF for i in range(size))
    remote.sdo.download(0x2001, 0, data, force_segment=is_forced)
    assert remote.sdo.upload(0x2001, 0) == data


@pytest.mark.parametrize("size", SIZES[1:])
@pytest.mark.parametrize("has_crc", [False, True])
def test_sdo_by_blocks(rig: Rig, remote: canopen.RemoteNode, size: int, has_crc: bool) -> None:
    data = bytes(i * 7 & 0xFF for i in range(size))
    with remote.sdo.open(
        0x2001, mode="wb", size=size, block_transfer=True, request_crc_support=has_crc
    ) as out:
        out.write(data)
    assert rig.node.value(0x2001, 0) == data
    with remote.sdo.open(0x2001, mode="rb", block_transfer=True, request_crc_support=has_crc) as source:
        assert source.read() == data


def test_the_eds_is_in_the_node(rig: Rig) -> None:
    master = Master(rig)
    remote = master.add_node(NODE, upload_eds=True)
    assert indexes_in(remote.object_dictionary) == {
        entry.index for entry in rig.node.dictionary.entries.values()
    }


@pytest.mark.parametrize(
    ("index", "subindex", "data", "code"),
    [
        (0x1999, 0, b"\0", 0x0602_0000),
        (0x2002, 9, b"\0", 0x0609_0011),
        (0x1000, 0, bytes(4), 0x0601_0002),
        (0x2003, 0, bytes(4), 0x0607_0012),
        (0x2003, 0, bytes(1), 0x0607_0013),
        (0x2003, 0, b"\xff\x7f", 0x0609_0031),
        (0x2003, 0, b"\x00\x80", 0x0609_0032),
        (0x2006, 0, b"\x0d", 0x0800_0021),
        (0x2000, 0, bytes(4097), 0x0607_0012),
    ],
)
def test_aborts(remote: canopen.RemoteNode, index: int, subindex: int, data: bytes, code: int) -> None:
    with pytest.raises(canopen.SdoAbortedError) as caught:
        remote.sdo.download(index, subindex, data)
    assert caught.value.code == code


def test_pdos_are_mapped_sent_and_taken(rig: Rig, remote: canopen.RemoteNode) -> None:
    remote.tpdo.read()
    remote.rpdo.read()
    assert [variable.name for variable in remote.tpdo[1]] == ["Ticks", "Torque"]
    assert [variable.name for variable in remote.rpdo[1]] == ["Position", "Torque"]
    remote.tpdo[2].clear()
    remote.tpdo[2].add_variable(0x2009)
    remote.tpdo[2].add_variable(0x2002, 1)
    remote.tpdo[2].trans_type = 1
    remote.tpdo[2].enabled = True
    remote.tpdo[2].save()
    remote.rpdo[3].clear()
    remote.rpdo[3].add_variable(0x2007)
    remote.rpdo[3].add_variable(0x0005, length=8)
    remote.rpdo[3].add_variable(0x2002, 2)
    remote.rpdo[3].trans_type = 255
    remote.rpdo[3].enabled = True
    remote.rpdo[3].save()
    remote.nmt.state = "OPERATIONAL"
    remote.rpdo[1]["Position"].raw = -123456
    remote.rpdo[1]["Torque"].raw = 12
    remote.rpdo[1].transmit()
    remote.rpdo[3]["Ratio"].raw = 0.25
    remote.rpdo[3][2].raw = 77
    remote.rpdo[3].transmit()
    assert rig.node.value(0x2007, 0) == 0.25
    assert rig.node.value(0x2002, 2) == 77
    remote.network.sync.transmit()
    assert remote.tpdo[2]["Position"].raw == -123456
    assert remote.tpdo[2][1].raw == 0
    rig.run(7)
    rig.application.services.changed(0x2005, 0)
    rig.run(8)
    assert (remote.tpdo[1]["Ticks"].raw, remote.tpdo[1]["Torque"].raw) == (7, 12)


def test_emergencies(rig: Rig, remote: canopen.RemoteNode) -> None:
    rig.application.services.emergency(0x2310, 0x02, b"abcde")
    rig.run(1)
    (error,) = remote.emcy.active
    assert (error.code, error.register, error.data) == (0x2310, 0x03, b"abcde")
    assert remote.sdo[0x1001].raw == 0x03
    assert remote.sdo[0x1003][1].raw == 0x6261_2310
    rig.application.services.emergency(0, 0x02)
    rig.run(2)
    assert remote.emcy.active == []
    assert [each.register for each in remote.emcy.log] == [3, 0]


def test_network_management(rig: Rig, remote: canopen.RemoteNode) -> None:
    remote.sdo[0x1017].raw = 100
    remote.nmt.state = "OPERATIONAL"
    states = []
    remote.nmt.add_heartbeat_callback(states.append)
    rig.run(350)
    assert states == [5, 5, 5]
    remote.nmt.state = "STOPPED"
    rig.run(450)
    assert (states[3:], remote.nmt.state) == ([4], "STOPPED")
    remote.nmt.state = "RESET"
    assert states[4:] == [0]
    assert remote.nmt.state == "PRE-OPERATIONAL"
    assert remote.sdo[0x1017].raw == 0


def test_parameters_are_stored(rig: Rig, remote: canopen.RemoteNode) -> None:
    remote.sdo["Torque"].raw = 33
    remote.sdo["Text"].data = b"kept without power"
    remote.sdo["Gains"][2].raw = 44
    remote.store()
    assert Rig(kept=rig.kept).node.value(0x2003, 0) == 33
    remote.sdo["Torque"].raw = 34
    remote.nmt.state = "RESET"
    assert remote.sdo["Torque"].raw == 33
    assert remote.sdo["Text"].data == b"kept without power"
    remote.restore()
    assert remote.sdo["Torque"].raw == 33
    remote.nmt.state = "RESET"
    assert (remote.sdo["Torque"].raw, remote.sdo["Gains"][2].raw) == (0, 1)


def test_configuration_is_loaded(rig: Rig, remote: canopen.RemoteNode) -> None:
    remote.object_dictionary[0x2003].value = 55
    remote.object_dictionary[0x2002][3].value = 66
    remote.load_configuration()
    assert (rig.node.value(0x2003, 0), rig.node.value(0x2002, 3)) == (55, 66)


# ---- LSS ----


@pytest.fixture
def unnamed(monkeypatch: pytest.MonkeyPatch) -> Rig:
    """Node without an id."""
    monkeypatch.setattr(canopen.lss.time, "sleep", lambda _: None)
    rig = Rig(node_id=255)
    assert rig.take() == []
    return rig


def test_lss_fast_scan_finds_and_names_it(unnamed: Rig) -> None:
    lss = Master(unnamed).lss
    assert lss.fast_scan() == (True, list(IDENTITY[:4]))
    lss.configure_node_id(42)
    lss.configure_bit_timing(3)
    lss.store_configuration()
    assert lss.inquire_node_id() == 255
    lss.send_switch_state_global(lss.WAITING_STATE)
    assert unnamed.take()[-1] == "72A#00"
    again = Rig(node_id=255, kept=unnamed.kept)
    assert again.take() == ["72A#00"]
    assert again.bit_rates == [250_000]
    assert lss.fast_scan() == (False, None)


def test_lss_selects_by_identity(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(canopen.lss.time, "sleep", lambda _: None)
    lss = Master(rig).lss
    vendor, product, revision, serial = IDENTITY[:4]
    with pytest.raises(canopen.lss.LssError):
        lss.send_switch_state_selective(vendor, product, revision, serial + 1)
    assert lss.send_switch_state_selective(vendor, product, revision, serial)
    assert [lss.inquire_lss_address(command) for command in range(0x5A, 0x5E)] == list(IDENTITY[:4])
    assert lss.inquire_node_id() == NODE
    with pytest.raises(canopen.lss.LssError, match="1"):
        lss.configure_node_id(128)
    rig.memory_fails = True
    with pytest.raises(canopen.lss.LssError, match="2"):
        lss.store_configuration()
    lss.configure_bit_timing(4)
    lss.activate_bit_timing(20)
    rig.run(19)
    assert rig.bit_rates == []
    rig.run(40)
    assert rig.bit_rates == [125_000]


def test_lss_identifies(rig: Rig, unnamed: Rig) -> None:
    vendor, product, revision, serial = IDENTITY[:4]
    lss = Master(rig).lss
    lss.send_identify_remote_slave(vendor, product, revision, revision, serial - 1, serial + 1)
    assert rig.take() == ["7E4#4F00000000000000"]
    lss.send_identify_remote_slave(vendor, product, revision, revision, serial + 1, serial + 2)
    lss.send_identify_non_configured_remote_slave()
    assert rig.take() == []
    Master(unnamed).lss.send_identify_non_configured_remote_slave()
    assert unnamed.take() == ["7E4#5000000000000000"]
