"""CANopen drives of a running bench, by the ``canopen`` library over slcan on a pty."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import canopen
import pytest
from canopen.profiles.p402 import BaseNode402
from e2e_support import Place, Server, config, until

BUS: dict[str, Any] = {
    "bit_rate": 1_000_000,
    "nodes": {"m1": {"id": 5, "switches": {"home": {"from_deg": 40, "to_deg": 60}}}, "s1": 6},
    "taps": {"slcan0": {}},
}
DEVICES = {"m1": {}, "s1": {"profile": "sac", "flash": {}}}


@pytest.fixture(scope="module")
def place() -> Iterator[Place]:
    with Place() as place:
        yield place


@pytest.fixture(scope="module")
def server(place: Place) -> Server:
    bench = config(speed=1, devices=DEVICES, can={"can0": BUS})
    return place.serve(bench, "--log", str(place.folder / "inputs.log")).ready()


@pytest.fixture(scope="module")
def network(place: Place, server: Server) -> Iterator[canopen.Network]:
    network = canopen.Network()
    path = str(place.runtime / "t" / "can0.slcan0")
    network.connect(interface="slcan", channel=path, bitrate=1_000_000, sleep_after_open=0)
    try:
        yield network
    finally:
        network.disconnect()


@pytest.fixture(scope="module")
def eds(place: Place, server: Server) -> Path:
    path = place.folder / "m1.eds"
    path.write_text(place.hil("can", "eds", "m1", "--runtime-dir", str(place.runtime)))
    return path


@pytest.fixture(scope="module")
def drive(network: canopen.Network, eds: Path) -> BaseNode402:
    node = BaseNode402(5, str(eds))
    network.add_node(node)
    node.sdo.RESPONSE_TIMEOUT = 5
    return node


def test_the_master_finds_the_nodes(network: canopen.Network) -> None:
    network.scanner.reset()
    network.scanner.search(8)
    until(lambda: sorted(network.scanner.nodes) == [5, 6], "both nodes")


def test_objects_by_the_names_of_the_eds(drive: BaseNode402) -> None:
    assert drive.sdo[0x1008].raw == "simulated mechaduino"
    assert drive.sdo[0x1018][1].raw == 0
    assert drive.sdo[0x6502].raw & 0x81 == 0x81
    drive.sdo[0x6065].raw = 20_000
    assert drive.sdo[0x6065].raw == 20_000
    with pytest.raises(canopen.SdoAbortedError) as caught:
        drive.sdo[0x6041].raw = 1
    assert caught.value.code == 0x06010002


def test_p402_homes_and_moves_the_drive(server: Server, drive: BaseNode402) -> None:
    drive.nmt.state = "OPERATIONAL"
    drive.load_configuration()
    drive.setup_402_state_machine()
    for state in ("READY TO SWITCH ON", "SWITCHED ON", "OPERATION ENABLED"):
        drive.state = state
    drive.sdo[0x6098].raw = 24
    drive.sdo[0x6099][1].raw = 180_000
    drive.sdo[0x6099][2].raw = 18_000
    drive.sdo[0x609A].raw = 1_800_000
    assert drive.homing(timeout=20), "homed"
    drive.op_mode = "PROFILED POSITION"
    drive.sdo[0x6081].raw = 360_000
    drive.sdo[0x6083].raw = drive.sdo[0x6084].raw = 3_600_000
    drive.sdo[0x607A].raw = 90_000
    drive.controlword = 0x0F
    drive.controlword = 0x1F
    until(lambda: abs(drive.sdo[0x6064].raw - 90_000) < 500, "the target")
    assert abs(server.ask("state", device="m1")["position_deg"] - 130) < 1


def test_heartbeat_and_boot_up_are_seen(server: Server, network: canopen.Network, drive: BaseNode402) -> None:
    drive.sdo[0x1017].raw = 50
    assert drive.nmt.wait_for_heartbeat(5) == "OPERATIONAL"
    states: list[int] = []
    drive.nmt.add_heartbeat_callback(states.append)
    server.ask("reset", device="m1")
    until(lambda: 0 in states, "the boot-up")


def test_blocks_of_the_stored_data_sheet(drive: BaseNode402, eds: Path) -> None:
    with drive.sdo.open(0x1021, 0, "rb", block_transfer=True) as file:
        text = file.read().decode()
    assert text.replace("\r\n", "\n").splitlines()[20:] == eds.read_text().splitlines()[20:]


def test_parameters_are_kept_in_the_board_s_memory_over_a_restart(eds: Path) -> None:
    with Place() as place:
        for value in (0, 777):
            server = place.serve(
                config(speed=1, devices={"m1": {}}, can={"can0": BUS | {"nodes": {"m1": 5}}})
            )
            network = canopen.Network()
            path = str(place.runtime / "t" / "can0.slcan0")
            network.connect(interface="slcan", channel=path, bitrate=1_000_000, sleep_after_open=0)
            node = network.add_node(5, str(eds))
            node.sdo.RESPONSE_TIMEOUT = 5
            if value:
                assert node.sdo[0x6067].raw == value
            else:
                node.sdo[0x6067].raw = 777
                node.store()
            network.disconnect()
            server.stop()


def test_the_log_is_the_same_again(place: Place, server: Server, network: canopen.Network) -> None:
    """Last of this file: the daemon ends."""
    network.disconnect()
    server.stop()
    replayed = place.hil("replay", str(place.folder / "inputs.log"), timeout_s=60)
    assert "identical" in replayed, replayed
