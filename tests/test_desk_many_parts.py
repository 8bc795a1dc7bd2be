"""The desk of a bench with a board of two axes and three serial interfaces, one without axes, and two without
serial interfaces: what is asked at each address is carried out there."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest
from desk_support import ADMIN, Asking, refusal

from hil.compose.find import find_catalogue
from hil.compose.replay import replay
from hil.config import parse
from hil.core.fields import PACKED_BYTES
from hil.daemon import Daemon, Serving
from hil.net.answers import misfit
from hil.vocab.desk_protocol import Watched

BOARDS = str(Path(__file__).with_name("boards"))
ARM: dict[str, Any] = {"profile": "arm", "ports": {"logger": "pty"}}
CONFIG: dict[str, Any] = {
    "bench": "h",
    "speed": 5,
    "profile_path": [BOARDS],
    "devices": {"arm": ARM, "p1": {"profile": "pinger"}},
}
WIRE = {"segments": {"bus0": {"stations": ["arm.bus"], "taps": {"m": {"port": "pty"}}}}}


def serve(
    folder: Path, config: dict[str, Any], use: Callable[[Asking], Awaitable[None]], **more: Any
) -> None:
    """Run what is awaited with the desk of a daemon that has started."""

    async def main() -> None:
        file = folder / "h.yaml"
        file.write_text(json.dumps(config))
        daemon = Daemon(
            parse(file.read_text(), str(file), find_catalogue()),
            config_folder=folder,
            config_file=file,
            runtime_base=folder / "run",
            state_base=folder / "state",
            **more,
        )
        started: asyncio.Future[Serving] = asyncio.get_running_loop().create_future()
        running = asyncio.create_task(daemon.run(started.set_result))
        await asyncio.wait({running, started}, return_when=asyncio.FIRST_COMPLETED, timeout=30)
        try:
            assert started.done()
            await use(Asking(started.result().desk, started.result()))
        finally:
            daemon.stop()
            await running

    asyncio.run(main())


async def until(condition: Callable[[], Awaitable[Any]], what: str) -> None:
    for _ in range(1000):
        if await condition():
            return
        await asyncio.sleep(0.01)
    raise AssertionError(f"waited for {what}")


def test_each_axis_is_asked_and_set_by_its_address(tmp_path: Path) -> None:
    async def use(ask: Asking) -> None:
        assert list(ask.desk.describe().devices) == ["arm", "arm.elbow", "p1"]
        assert [row["axes"] for row in (await ask("list"))["devices"]] == [["arm", "arm.elbow"], []]
        await ask.until_ready("arm", 500_000_000)
        done = await ask.verb("arm.elbow", "position", position_deg=60.0)
        assert done.answer == {"set_point": 60.0}
        assert (await ask.verb("arm.shoulder", "position", position_deg=20.0)).answer == {"set_point": 20.0}

        async def stands() -> bool:
            found = [(await ask("state", axis))["position_deg"] for axis in ("arm", "arm.elbow")]
            return found == [pytest.approx(20, abs=1), pytest.approx(60, abs=1)]

        await until(stands, "both axes")
        await ask("set", "arm.elbow", field="load_torque_Nm", value=0.01)
        await ask("pin", "arm.elbow", pin="D3", level=1)
        loads = [(await ask("state", axis))["load_torque_Nm"] for axis in ("arm", "arm.elbow")]
        assert loads == [0.0, 0.01]
        assert len(await ask("packed", "arm.elbow")) == PACKED_BYTES
        watch = await ask("watch", "arm.elbow", signals=["r", "yw"], interval_ns=1_000_000)
        rows: list[list[float]] = []

        async def sampled() -> bool:
            rows.extend((await ask("samples", watch=watch["watch"]))["rows"])
            return len(rows) > 10

        await until(sampled, "samples")
        assert {row[1] for row in rows} == {60.0}
        assert {each["verb"] for each in await ask("verbs", "arm.elbow")} == {
            "position",
            "stop",
            "pin",
            "zero",
        }
        row = next(row for row in (await ask("status"))["devices"] if row["device"] == "arm")
        assert row["snapshots"]["arm.elbow"]["position_deg"] == pytest.approx(60, abs=1)

    serve(tmp_path, CONFIG, use)


def test_what_is_not_there_is_refused(tmp_path: Path) -> None:
    async def use(ask: Asking) -> None:
        for operation, target, given, code in (
            ("state", "arm.wrist", {}, "no_device"),
            ("state", "arm.logger", {}, "no_device"),
            ("state", "arm.", {}, "no_device"),
            ("state", "p1", {}, "cannot"),
            ("pin", "p1", {"pin": "D0", "level": 1}, "cannot"),
            ("reset", "arm.elbow", {}, "no_device"),
            ("type", "arm.wrist", {"text": "x"}, "no_device"),
            ("do", "arm.elbow", {"name": "jump", "parameters": {}}, "no_verb"),
            ("inject", "p1", {"fault": "shaft_jam", "parameters": {}}, "bad_parameter"),
            ("inject", "arm.wrist", {"fault": "shaft_jam", "parameters": {}}, "bad_parameter"),
            ("capture", "", {"ports": ["arm.bus"]}, "no_place"),
        ):
            assert (await refusal(ask(operation, target, **given)))[0] == code, (operation, target)
        row = next(row for row in (await ask("status"))["devices"] if row["device"] == "p1")
        assert (row["snapshot"], row["snapshots"], row["axes"]) == (None, {}, [])

    serve(tmp_path, CONFIG, use)


def test_bytes_at_each_interface_runs_and_faults_and_the_log_of_all(tmp_path: Path) -> None:
    log = tmp_path / "run.log"

    async def use(ask: Asking) -> None:
        heard: dict[str, bytes] = {"arm": b"", "arm.logger": b"", "p1": b""}
        for place in heard:

            def note(towards: str, data: bytes, place: str = place) -> None:
                if towards == "client":
                    heard[place] += data

            ask.desk.watch(ADMIN, Watched.BYTES, place, note)
        packets: list[Any] = []
        ask.desk.watch(ADMIN, Watched.PACKETS, "bus0", packets.append)
        await ask("type", "arm", text="s")
        await ask("type", "arm.logger", text="x")
        await ask("send", "p1", data="00")
        await ask("play", "bus0.m", bursts=[[0, b"#".hex()]])

        async def answered() -> bool:
            return bool(heard["arm.logger"] and heard["p1"] and any(b"=1;" in each.data for each in packets))

        await until(answered, "the answers")
        assert heard["arm"].endswith(b"\r\n")
        assert heard["arm.logger"] == b"1: s\r\n"
        run = {
            "run": "r",
            "axes": {"arm": {}, "arm.elbow": {}},
            "steps": [{"line": {"arm": 20, "arm.elbow": 70}}],
        }
        await ask("run", text=json.dumps(run))

        async def is_over() -> bool:
            (progress,) = await ask("runs", "r")
            assert progress["state"] in ("queued", "running", "done"), progress
            return bool(progress["state"] == "done")

        await until(is_over, "the run")
        numbers = [
            (await ask("inject", target, fault=kind, parameters=given))["number"]
            for target, kind, given in (
                ("arm.elbow", "shaft_jam", {}),
                ("arm", "encoder_slip", {"counts": 3}),
                ("arm.logger", "byte_drop", {"rate": 1}),
                ("arm.bus", "wire_cut", {}),
            )
        ]
        assert [each["target"] for each in await ask("faults")] == [
            "arm.elbow",
            "arm",
            "arm.logger",
            "arm.bus",
        ]
        assert (await ask("clear", number="all", on="arm"))["cleared"] == numbers
        await ask("reset", "arm")

    serve(tmp_path, CONFIG | WIRE, use, input_log=log)
    assert '"device":"arm.elbow","input":"follow"' in log.read_text()
    assert replay(log).difference() is None


def test_a_reload_exchanges_all_parts_of_a_board(tmp_path: Path) -> None:
    async def use(ask: Asking) -> None:
        samples: list[bytes] = []
        watch = ask.desk.watch(ADMIN, Watched.SAMPLES, "arm.elbow", samples.append, interval_ns=1_000_000)
        file = tmp_path / "h.yaml"
        new = {"arm": ARM | {"axes": {"elbow": {"axis": {"start_deg": 10}}}}, "p1": {"profile": "pinger"}}
        file.write_text(json.dumps(CONFIG | {"devices": new}))
        done = await ask("reload")
        assert (done["kept"], done["restarted"]) == (["p1"], ["arm"])
        assert (await ask("state", "arm.elbow"))["position_deg"] < 20

        async def sampled() -> bool:
            watch.flush()
            return len(samples) > 10

        await until(sampled, "samples of the new axis")
        more = {"arm": ARM | {"ports": {"logger": "pty", "bus": "pty"}}}
        file.write_text(json.dumps(CONFIG | {"devices": more}))
        assert (await ask("reload"))["removed"] == ["p1"]
        assert list((await ask("list"))["devices"][0]["ports"]) == ["arm.logger", "arm.bus"]
        assert (await refusal(ask("state", "p1")))[0] == "no_device"

    serve(tmp_path, CONFIG, use)


MUTE: dict[str, Any] = {"d1": {"profile": "drive"}, "b1": {"profile": "brick"}}


def rows(listed: Any) -> dict[str, Any]:
    return {row["device"]: row for row in listed["devices"]}


def test_boards_without_serial_interfaces_are_asked_and_listed(tmp_path: Path) -> None:
    log = tmp_path / "run.log"

    async def use(ask: Asking) -> None:
        assert [*ask.desk.describe().ports] == ["p1"]
        listed, status = rows(await ask("list")), rows(await ask("status"))
        for name, axes in (("d1", ["d1"]), ("b1", [])):
            for row in (listed[name], status[name]):
                of_port = [row[key] for key in ("port", "address", "clients", "network", "ports", "axes")]
                assert of_port == [None, None, 0, None, {}, axes]
            assert (status[name]["rx_bytes"], status[name]["port_failure"]) == (0, None)
        assert misfit("list", await ask("list")) == misfit("status", await ask("status")) == ""
        assert {each["verb"] for each in await ask("verbs", "d1")} == {
            *("position", "stop", "reset", "pin", "zero")
        }
        assert {each["verb"] for each in await ask("verbs", "b1")} == {"reset"}
        assert (await ask.verb("d1", "position", position_deg=60.0)).answer == {"set_point": 60.0}
        await ask("pin", "d1", pin="D3", level=1)
        await ask("reset", "b1")
        run = {"run": "r", "axes": {"d1": {}}, "steps": [{"move": {"d1": 20}}]}
        await ask("run", text=json.dumps(run))

        async def is_over() -> bool:
            (progress,) = await ask("runs", "r")
            assert progress["state"] in ("queued", "running", "done"), progress
            return bool(progress["state"] == "done")

        await until(is_over, "the run")
        for operation, target, given, said in (
            ("type", "d1", {"text": "x"}, ("no_device", "d1 has no serial interface")),
            ("send", "b1", {"data": "00"}, ("no_device", "b1 has no serial interface")),
            ("do", "d1", {"name": "type", "parameters": {"text": "x"}}, ("no_device", "d1 has no serial")),
            ("capture", "", {"ports": ["d1"]}, ("no_place", "d1 has no serial port; ports and segments")),
            (
                "inject",
                "d1",
                {"fault": "host_close", "parameters": {}},
                ("bad_parameter", "host_close: d1 is no port of"),
            ),
            ("state", "b1", {}, ("cannot", "b1, a brick, has no axis")),
        ):
            code, why = await refusal(ask(operation, target, **given))
            assert (code, why[: len(said[1])]) == said
        await ask("inject", "d1", fault="shaft_jam", parameters={})
        metrics = [values for _, values in ask.serving.desk.ask(ADMIN, "metrics", "", {})]
        assert metrics

    more = {"p1": {"profile": "pinger"}}
    serve(tmp_path, CONFIG | {"devices": MUTE | more}, use, input_log=log)
    assert replay(log).difference() is None


def test_a_bench_of_boards_without_serial_interfaces_alone(tmp_path: Path) -> None:
    async def use(ask: Asking) -> None:
        assert [*ask.desk.describe().ports] == []
        _, why = await refusal(ask("capture", "", ports=["b1"]))
        assert why == "b1 has no serial port; ports and segments are none"

    serve(tmp_path, CONFIG | {"devices": MUTE}, use)


def test_a_reload_takes_and_gives_boards_their_serial_interfaces(tmp_path: Path) -> None:
    async def use(ask: Asking) -> None:
        async def become(devices: Any) -> Any:
            (tmp_path / "h.yaml").write_text(json.dumps(CONFIG | {"devices": devices}))
            return await ask("reload")

        pinger = {"profile": "pinger"}
        assert (await become({"p1": pinger} | MUTE))["added"] == ["d1", "b1"]
        assert (await ask("state", "d1"))["position_deg"] > 30
        # One gets a port, the other loses all of its own.
        assert (await become({"p1": {"profile": "drive"}, "d1": ARM, "b1": MUTE["b1"]}))["kept"] == ["b1"]
        assert [*ask.desk.describe().ports] == ["d1", "d1.logger"]
        assert (await become({"p1": pinger} | MUTE))["restarted"] == ["p1", "d1"]
        assert [*ask.desk.describe().ports] == ["p1"]
        assert (await become({"p1": pinger}))["removed"] == ["d1", "b1"]
        slow = {"arm": ARM | {"bauds": {"logger": 9600}}, "p1": pinger}
        assert (await become(slow))["added"] == ["arm"]
        address = rows(await ask("list"))["arm"]["ports"]["arm.logger"]["address"]
        assert (await become({"arm": ARM, "p1": pinger}))["restarted"] == ["arm"]
        assert rows(await ask("list"))["arm"]["ports"]["arm.logger"]["address"] == address
        assert ask.serving.live.sim.devices["arm"].uarts["logger"].baud == 115200

    serve(tmp_path, CONFIG | {"devices": {"p1": {"profile": "pinger"}}}, use)
