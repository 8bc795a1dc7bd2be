"""What bridges may use of a daemon, without a bridge: the host of one that runs in this process."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest

from hil.compose import find_catalogue
from hil.config import parse
from hil.core.fields import PACKED_BYTES
from hil.daemon import Daemon
from hil.operations.bridge_host import Host
from hil.vocab.bridges import Source
from hil.vocab.verbs import Role, VerbRefused

PORT = {"port": "pty"}
CONFIG = json.dumps(
    {
        "bench": "h",
        "speed": 20,
        "devices": {
            "m1": {"profile": "mechaduino", "flash": {"table": "identity"}, "setpoints": {"timeout_ms": 50}},
            "s1": {"profile": "sac"},
            "s10": {"profile": "sac"},
            "real": {"profile": "mechaduino", "at": "/dev/null/nothing"},
        },
    }
)
ADMIN, VIEWER = Source("the tests", Role.ADMIN), Source("a guest", Role.VIEWER)


@pytest.fixture
def using(tmp_path: Path) -> Callable[[Callable[[Host], Awaitable[None]]], None]:
    """Runs what is awaited with the host of a daemon that has started."""

    def run(use: Callable[[Host], Awaitable[None]]) -> None:
        async def main() -> None:
            config = parse(CONFIG, "h.yaml", find_catalogue())
            daemon = Daemon(
                config, config_folder=tmp_path, runtime_base=tmp_path / "run", state_base=tmp_path / "state"
            )
            started = asyncio.Event()
            running = asyncio.create_task(daemon.run(lambda _: started.set()))
            starting = asyncio.create_task(started.wait())
            await asyncio.wait({running, starting}, return_when=asyncio.FIRST_COMPLETED, timeout=30)
            try:
                assert started.is_set()
                await use(daemon.host)
            finally:
                daemon.stop()
                await running

        asyncio.run(main())

    return run


Using = Callable[[Callable[[Host], Awaitable[None]]], None]


async def refusal(call: Callable[[], Any]) -> tuple[str, str]:
    async def made() -> None:
        answer = call()
        if asyncio.iscoroutine(answer):
            await answer

    with pytest.raises(VerbRefused) as refused:
        await made()
    return refused.value.code, str(refused.value)


async def until(condition: Callable[[], bool]) -> None:
    for _ in range(3000):
        if condition():
            return
        await asyncio.sleep(0.01)
    raise AssertionError("it did not come true")


def test_faults_of_a_device_are_not_those_of_one_with_a_longer_name(using: Using) -> None:
    async def use(host: Host) -> None:
        host.fault(ADMIN, "s1", {"fault": "shaft_jam"})
        other = host.fault(ADMIN, "s10", {"fault": "shaft_jam"})["number"]
        line = host.fault(ADMIN, "s10", {"fault": "byte_drop", "target": "s10.network", "rate": 0.5})[
            "number"
        ]
        assert (await refusal(lambda: host.fault(ADMIN, "s1", {"clear": other})))[0] == "bad_parameter"
        for wrong in (True, "1", [1], 1.5, None):
            got = await refusal(lambda wrong=wrong: host.fault(ADMIN, "s1", {"clear": wrong}))  # type: ignore[misc]
            assert got == ("bad_parameter", 'clear: write "all" or one of [1], and nothing beside it')
        assert host.fault(ADMIN, "s1", {"clear": 1.0}) == {"cleared": [1]}
        assert host.fault(ADMIN, "s1", {"clear": "all"}) == {"cleared": []}
        assert host.fault(ADMIN, "s10", {"clear": line}) == {"cleared": [line]}
        assert host.fault(ADMIN, "s10", {"clear": "all"}) == {"cleared": [other]}

    using(use)


def test_who_may_only_look_moves_nothing(using: Using) -> None:
    async def use(host: Host) -> None:
        for verb in host.devices["m1"].verbs:
            code, why = await refusal(lambda verb=verb: host.do(VIEWER, "m1", verb, {}))  # type: ignore[misc]
            assert (code, why) == ("forbidden", f"{verb} needs the role operator")

    using(use)


def test_a_real_board_says_what_it_cannot(using: Using) -> None:
    async def use(host: Host) -> None:
        for call in (
            lambda: host.state("real"),
            lambda: host.sample("real", 1_000_000),
            lambda: host.set_field(ADMIN, "real", "pKp", 1.0),
        ):
            code, why = await refusal(call)
            assert code == "cannot"
            assert why.startswith("real is a real board: the daemon sees its terminal")
        code, why = await refusal(lambda: host.do(ADMIN, "real", "move_abs", {"position_deg": 1}))
        assert (code, why) == (
            "no_verb",
            "real, a mechaduino, has no 'move_abs'; known are: disable, enable, type",
        )

    using(use)


def test_fields_that_are_set_and_those_that_are_not(using: Using) -> None:
    async def use(host: Host) -> None:
        assert host.set_field(ADMIN, "m1", "pKp", 12).answer == {"pKp": 12}
        assert host.state("m1")["pKp"] == 12.0
        for name, value, code in (
            ("pKp", float("nan"), "bad_parameter"),
            ("pKp", True, "bad_parameter"),
            ("pKp", "12", "bad_parameter"),
            ("diaagc", 0x8000, "bad_parameter"),
            ("errfl", -1, "bad_parameter"),
            ("load_torque_Nm", 99.0, "bad_parameter"),
            ("r", 5.0, "no_parameter"),
            ("pkp", 5.0, "no_parameter"),
        ):
            got = await refusal(lambda name=name, value=value: host.set_field(ADMIN, "m1", name, value))  # type: ignore[misc]
            assert got[0] == code
        assert (await refusal(lambda: host.set_field(ADMIN, "s1", "pKp", 5.0)))[0] == "no_parameter"
        assert (await refusal(lambda: host.set_field(ADMIN, "m9", "pKp", 5.0)))[0] == "no_device"

    using(use)


def test_a_calibration_is_over_when_the_board_is_at_its_menu_again(using: Using) -> None:
    async def use(host: Host) -> None:
        await until(lambda: host.state("m1")["at_ns"] > 4_500_000_000)
        done = await host.do(ADMIN, "m1", "calibrate", {})
        assert await host.wait_until_done("m1", done, 0.5) is None
        with pytest.raises(VerbRefused, match="its main program starts, or is in a routine") as refused:
            await host.do(ADMIN, "m1", "enable", {})
        assert refused.value.code == "not_now"
        await host.do(ADMIN, "m1", "reset", {})
        await until(lambda: host.state("m1")["at_ns"] > done.effective_at_ns + 6_000_000_000)

    using(use)


def test_a_move_that_another_ends_says_so(using: Using) -> None:
    async def use(host: Host) -> None:
        await until(lambda: host.state("m1")["at_ns"] > 4_500_000_000)
        await host.do(ADMIN, "m1", "enable", {})
        done = await host.do(ADMIN, "m1", "move_rel", {"angle_deg": 3600})
        await host.do(ADMIN, "m1", "stop", {"how": "prejudice"})
        assert await host.wait_until_done("m1", done, 60) == "interrupted"
        whole = await host.do(ADMIN, "m1", "move_rel", {"angle_deg": 5})
        assert await host.wait_until_done("m1", whole, 60) == "ended"
        assert len(host.packed("m1")) == PACKED_BYTES

    using(use)


def test_a_failed_board_says_so_to_every_verb_but_reset(using: Using) -> None:
    async def use(host: Host) -> None:
        await until(lambda: host.state("m1")["at_ns"] > 4_500_000_000)
        number = host.fault(ADMIN, "m1", {"fault": "node_brown_out"})["number"]
        for verb, given in (
            ("enable", {}),
            ("type", {"text": "x"}),
            ("pin", {"pin": "D3", "level": 1}),
            ("calibrate", {}),
        ):
            got = await refusal(lambda verb=verb, given=given: host.do(ADMIN, "m1", verb, given))  # type: ignore[misc]
            assert got[0] == "failed"
        host.fault(ADMIN, "m1", {"clear": number})
        assert (await host.do(ADMIN, "m1", "gains", {})).answer["pKp"] == 15.0

    using(use)


def test_metrics_while_a_reload_changes_devices(using: Using) -> None:
    """A scrape lets others run between any two values."""

    async def use(host: Host) -> None:
        daemon = host._daemon
        sessions, devices = daemon.places.uarts(), daemon.bench.devices
        for metric, values in host.metrics():
            session, device, found = sessions["s10"], devices["s10"], set()
            for labels, _ in values:
                found.update(labels[:1])
                sessions.pop("s10", None)
                devices.pop("s10", None)
            sessions["s10"], devices["s10"] = session, device
            if metric.name in ("hil_port_failed", "hil_device_failed"):
                assert {"m1", "s1", "s10"} <= found

    using(use)
