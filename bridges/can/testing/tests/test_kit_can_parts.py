"""CANopen nodes of boards with several axes, of boards that are joined to others, and what cannot be one."""

from pathlib import Path
from typing import Any

import pytest
from can_bench import M1

from hil.config import ConfigError
from hil.testing import Bench

BOARDS = str(Path(__file__).parents[4] / "tests/boards")
ARM: dict[str, Any] = {"profile": "arm", "port": "memory"}


def arms(nodes: dict[str, Any], **devices: Any) -> dict[str, Any]:
    boards = {"arm": ARM} | devices
    return {"bench": "t", "profile_path": [BOARDS], "devices": boards, "can": {"can0": {"nodes": nodes}}}


def test_two_axes_of_a_board_are_two_drives_with_a_memory_each() -> None:
    with Bench(
        arms({"arm": 1, "arm.elbow": {"id": 2, "switches": {"home": {"from_deg": 1, "to_deg": 2}}}})
    ) as bench:
        bus = bench.canbus()
        shoulder, elbow = bus.drives()
        assert [drive.axis for drive in (shoulder, elbow)] == ["arm", "arm.elbow"]
        bench.run(ms=20)
        for drive, value in ((shoulder, 111), (elbow, 222)):
            drive.write(0x6067, 0, value, 4)
            drive.write(0x1010, 1, int.from_bytes(b"save", "little"), 4)
        bench.device("arm").reset()
        bench.run(ms=20)
        assert [drive.read(0x6067) for drive in (shoulder, elbow)] == [111, 222]
        assert {"canopen", "canopen.elbow"} <= bench._runtime.devices["arm"].nvm.keys()
        assert bench.fault("bus_off", "arm.elbow.canopen").number == 1


def test_a_drive_s_name_is_the_address_of_its_axis_as_hil_writes_it() -> None:
    with Bench(arms({"arm.shoulder": 1})) as bench:
        assert list(bench._runtime.cards) == ["arm.canopen"]


@pytest.mark.parametrize(
    ("nodes", "devices", "said"),
    [
        ({"arm.wrist": 1}, {}, "arm has no axis 'wrist'; it has shoulder, elbow"),
        ({"p1": 1}, {"p1": {"profile": "pinger", "port": "memory"}}, "p1 has no axis"),
        ({"arm": 1, "arm.shoulder": 2}, {}, "arm has a node on can0 already"),
    ],
)
def test_what_is_no_axis_is_no_node(nodes: dict[str, Any], devices: dict[str, Any], said: str) -> None:
    with pytest.raises(ConfigError) as caught:
        Bench(arms(nodes, **devices))
    assert said in str(caught.value)


def test_a_board_on_a_bus_and_on_a_segment_joins_all_of_both() -> None:
    setup = {
        "bench": "t",
        "devices": {"m1": M1, "s1": {"profile": "sac"}, "s2": {"profile": "sac"}, "m2": M1},
        "segments": {"bus0": {"stations": ["s1", "s2"]}},
        "can": {"can0": {"nodes": {"m1": 1, "s1": 2}}, "can1": {"taps": {"a": {"port": "memory"}}}},
    }
    with Bench(setup) as bench:
        group_of = bench._runtime.parts.group_of
        assert group_of("m1") is group_of("s1") is group_of("s2") is group_of("can0") is group_of("bus0")
        assert len({id(group_of(name)) for name in ("m1", "m2", "can1")}) == 3
        assert bench.canbus().expect(0x702, within_ms=10)
