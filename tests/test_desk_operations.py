"""Operations at the desk: carried out, watched, and ended as they begin."""

import asyncio
import gc
import json
import socket
from pathlib import Path
from typing import Any

import pytest
from desk_support import ADMIN, CONFIG, VIEWER, Asking, Using, desk_in, refusal

from hil.core.fields import PACKED_BYTES
from hil.operations.table import TYPED_BYTES
from hil.vocab.desk_protocol import Watched
from hil.vocab.verbs import VerbRefused


@pytest.fixture
def using(tmp_path: Path) -> Using:
    """Runs what is awaited with the desk of a daemon that has started."""
    return desk_in(tmp_path)


def test_an_input_pin_can_be_driven_whatever_the_firmware_does(using: Using) -> None:
    async def use(ask: Asking) -> None:
        await ask("inject", "m1", fault="node_brown_out", parameters={})
        assert ask.serving.live.sim.devices["m1"].failed
        assert (await ask("pin", "m1", pin="D3", level=1)).answer == {}
        assert (await ask.verb("m1", "pin", pin="D3", level=0)).answer == {}

    using(use)


def test_a_failed_board_says_so_to_every_verb_but_reset_and_pin(using: Using) -> None:
    async def use(ask: Asking) -> None:
        await ask.until_ready("m1")
        number = (await ask("inject", "m1", fault="node_brown_out", parameters={}))["number"]
        for name, given in (("enable", {}), ("type", {"text": "x"}), ("calibrate", {})):
            assert (await refusal(ask.verb("m1", name, **given)))[0] == "failed"
        assert await refusal(ask("send", "m1", data="78")) == await refusal(ask("type", "m1", text="x"))
        await ask("clear", number=number)
        assert (await ask.verb("m1", "gains")).answer["pKp"] == 15.0

    using(use)


def test_what_is_typed_as_text_and_as_digits_has_one_limit(using: Using) -> None:
    async def use(ask: Asking) -> None:
        await ask.until_ready("m1")
        assert (await refusal(ask("type", "m1", text="x" * (TYPED_BYTES + 1))))[0] == "bad_parameter"
        assert (await refusal(ask("send", "m1", data="78" * (TYPED_BYTES + 1))))[0] == "bad_parameter"
        assert (await ask("send", "s1.network", data="04" * TYPED_BYTES)).answer == {}
        code, why = await refusal(ask("send", "m1.network", data="04"))
        assert (code, why) == ("no_device", "m1 has no serial interface 'network'; it has main")

    using(use)


def test_texts_of_a_board_are_read_by_its_profile(using: Using) -> None:
    async def use(ask: Asking) -> None:
        speed = {"reader": "vd", "text": "150\t2000"}
        assert await ask("read_text", "s1", VIEWER, **speed) == {"rpm": 150, "period_us": 2000}
        assert await ask("read_text", "s1", reader="vd", text="?") == "this is no speed: '?'"
        long = await ask("read_text", "s1", reader="queue", text="1,2\n" * 10_000, file="q.txt")
        assert long.startswith("q.txt:1:1: 2 numbers; a row has 12")
        for device in ("m1", "real"):
            told = await refusal(ask("read_text", device, **speed))
            assert told == ("bad_parameter", "a mechaduino has no reader 'vd'; there are none")

    using(use)


def test_faults_of_a_device_are_not_those_of_one_with_a_longer_name(using: Using) -> None:
    async def use(ask: Asking) -> None:
        async def begun(target: str, fault: str = "shaft_jam", **parameters: Any) -> int:
            return int((await ask("inject", target, fault=fault, parameters=parameters))["number"])

        one, other = await begun("s1"), await begun("s10")
        line = await begun("s10.network", "byte_drop", rate=0.5)
        told = await refusal(ask("clear", number=other, on="s1"))
        assert told == ("bad_parameter", f"there is no fault {other} on s1; there are {one}")
        for wrong in (True, "1", [1], None):
            assert (await refusal(ask("clear", number=wrong, on="s1")))[0] == "bad_parameter"
        assert await ask("clear", number=float(one), on="s1") == {"cleared": [one]}
        assert await ask("clear", number="all", on="s1") == {"cleared": []}
        assert await ask("clear", number=line, on="s10") == {"cleared": [line]}
        assert await ask("clear", number="all") == {"cleared": [other]}

    using(use)


def test_a_zero_of_the_angle_that_is_told(using: Using) -> None:
    async def use(ask: Asking) -> None:
        await ask.until_ready("m1")
        before = (await ask("state", "m1"))["position_deg"]
        done = await ask("zero", "m1")
        assert done.answer == {"was_deg": before, "board_deg": None}, "off, it counts nothing"
        assert (await ask("state", "m1"))["position_deg"] == 0
        assert (await ask.verb("m1", "zero")).answer["was_deg"] == 0, "by this door, too"
        await ask.verb("m1", "enable")
        done = await ask("zero", "m1.axis")
        assert done.answer["board_deg"] == pytest.approx(before, abs=3)
        assert (await ask("set", "m1", field="position_deg", value=90)).answer == {"position_deg": 90}
        assert (await ask("state", "m1"))["position_deg"] == pytest.approx(90, abs=3)
        assert (await refusal(ask("set", "m1", field="position_deg", value=2e6)))[0] == "bad_parameter"
        assert (await refusal(ask("zero", "real")))[0] == "cannot"
        await ask.until_ready("s1")
        await ask.verb("s1", "velocity", velocity_rpm=60)
        assert await refusal(ask("zero", "s1")) == (
            "not_now",
            "position_deg: its motions end at angles; wait until it stands",
        )

    using(use)


def test_the_status_says_when_a_load_drags_a_shaft(using: Using) -> None:
    async def use(ask: Asking) -> None:
        async def note(name: str) -> str | None:
            rows = {row["device"]: row for row in (await ask("status"))["devices"]}
            said: str | None = rows[name]["note"]
            return said

        await ask("set", "m1", field="load_torque_Nm", value=0.495)
        assert await note("m1") is None, "what it holds"
        await ask("inject", "m1", fault="shaft_load", parameters={"torque_Nm": 4.4})
        limit = "the load of 4.895 Nm is more than the motor holds (0.495 Nm); the shaft turns at 10000 rpm"
        while await note("m1") != f"{limit}, the limit of its model":
            await asyncio.sleep(0.01)
        assert (await ask("state", "m1"))["velocity_rpm"] == 10_000
        assert await note("s1") is None
        await ask("clear", number="all")
        await ask("set", "m1", field="load_torque_Nm", value=0)
        while await note("m1"):
            await asyncio.sleep(0.01)

    using(use)


def test_a_real_board_says_what_it_cannot(using: Using) -> None:
    async def use(ask: Asking) -> None:
        told = [await refusal(ask(name, "real")) for name in ("state", "packed")]
        told.append(await refusal(ask("set", "real", field="pKp", value=1.0)))
        with pytest.raises(VerbRefused) as refused:
            ask.desk.watch(VIEWER, Watched.SAMPLES, "real", print, interval_ns=1_000_000)
        assert {*told, (refused.value.code, str(refused.value))} == {told[0]}
        assert told[0][0] == "cannot"
        assert told[0][1].startswith("real is a real board: the daemon sees its terminal")
        code, why = await refusal(ask.verb("real", "move_abs", position_deg=1))
        assert (code, why) == (
            "no_verb",
            "real, a mechaduino, has no 'move_abs'; known are: disable, enable, type",
        )

    using(use)


def test_fields_that_are_set_and_those_that_are_not(using: Using) -> None:
    async def use(ask: Asking) -> None:
        assert (await ask("set", "m1", field="pKp", value=12)).answer == {"pKp": 12}
        assert (await ask("state", "m1"))["pKp"] == 12.0
        for value in (float("nan"), True, "12", None, [1]):
            assert (await refusal(ask("set", "m1", field="pKp", value=value)))[0] == "bad_parameter"
        assert (await refusal(ask("set", "m1", field="errfl", value=-1)))[0] == "bad_parameter"

    using(use)


def test_a_calibration_is_over_when_the_board_is_at_its_menu_again(using: Using) -> None:
    async def use(ask: Asking) -> None:
        await ask.until_ready("m1")
        done = await ask.verb("m1", "calibrate")
        code, why = await refusal(ask.wait("m1", done, 0.5))
        assert (code, why) == ("not_now", "it has not ended after 0.5 s; ask for its state")
        code, why = await refusal(ask.verb("m1", "enable"))
        assert (code, "it calibrates itself" in why) == ("not_now", True)
        await ask("reset", "m1")
        await ask.until_ready("m1", done.effective_at_ns + 6_000_000_000)

    using(use)


def test_a_move_that_another_ends_says_so(using: Using) -> None:
    async def use(ask: Asking) -> None:
        await ask.until_ready("m1")
        await ask.verb("m1", "enable")
        done = await ask.verb("m1", "move_rel", angle_deg=3600)
        await ask.verb("m1", "stop", how="prejudice")
        assert await ask.wait("m1", done, 60)
        whole = await ask.verb("m1", "move_rel", angle_deg=5)
        assert not await ask.wait("m1", whole, 60)
        assert len(await ask("packed", "m1")) == PACKED_BYTES

    using(use)


# ---- looking on ----


def test_what_is_watched_comes_until_it_is_closed(using: Using) -> None:
    async def use(ask: Asking) -> None:
        samples: list[bytes] = []
        passing: list[tuple[str, bytes]] = []
        watch = ask.desk.watch(VIEWER, Watched.SAMPLES, "m1", samples.append, interval_ns=1_000_000)
        port = ask.desk.watch(VIEWER, Watched.BYTES, "s1", lambda *told: passing.append(told))
        runs: list[str] = []
        run = ask.desk.watch(VIEWER, Watched.RUNS, "", lambda progress: runs.append(progress["state"]))
        await ask.until_ready("m1")
        watch.flush()
        assert {len(packed) for packed in samples} == {PACKED_BYTES}
        await ask("type", "s1", text=r"vd\r")
        await ask("run", text="run: r\naxes: {s1: {}}\nsteps: [{dwell_s: 0.01}]\n")
        for _ in range(1000):
            if passing and "done" in runs:
                break
            await asyncio.sleep(0.01)
        assert {towards for towards, _ in passing} == {"client"}
        assert runs[-1] == "done"
        for each in (watch, port, run):
            each.close()
        assert [*ask.desk.describe().ports] == ["m1", "s1", "s10", "bus0.t", "real"]
        with pytest.raises(VerbRefused, match="there is no port 's9'; there are bus0, m1, ") as refused:
            ask.desk.watch(VIEWER, Watched.BYTES, "s9", print)
        assert refused.value.code == "no_place"

    using(use)


def test_metrics_while_a_reload_changes_devices(using: Using) -> None:
    """A scrape lets others run between any two values."""

    async def use(ask: Asking) -> None:
        places, devices = ask.serving.live.places, ask.serving.live.sim.devices
        for metric, values in await ask("metrics"):
            place, device, found = places["s10"], devices["s10"], set()
            for labels, _ in values:
                found.update(labels[:1])
                places.pop("s10", None)
                devices.pop("s10", None)
            places["s10"], devices["s10"] = place, device
            if metric.name in ("hil_port_failed", "hil_device_failed"):
                assert {"m1", "s1", "s10"} <= found

    using(use)


# ---- what comes and goes at once ----


def test_a_run_that_is_cancelled_as_it_is_submitted_never_begins(using: Using) -> None:
    async def use(asking: Asking) -> None:
        await asking.until_ready("m1")
        await asking.verb("m1", "enable")
        text = "run: r\naxes: {m1: {}}\nsteps: [{move: {m1: 90}}]\n"
        asking.desk.ask(ADMIN, "run", "", {"text": text})  # both in one turn of the event loop
        asking.desk.ask(ADMIN, "cancel_run", "r", {"how": "grace"})
        (state,) = await asking("runs", "r")
        assert state["state"] == "cancelled"
        gc.collect()

    using(use)


def test_a_capture_whose_client_has_hung_up_already_ends(using: Using, tmp_path: Path) -> None:
    async def use(asking: Asking) -> None:
        listeners = asking.serving.live.places["m1"].listeners
        path = tmp_path / "run" / "h" / "control.sock"
        for _ in range(20):
            with socket.socket(socket.AF_UNIX) as client:
                client.connect(str(path))
                client.sendall(b'{"verb": "capture", "ports": ["m1"]}\n')
        await asking.until_ready("m1")  # some time after
        for _ in range(1000):
            if not listeners:
                return
            await asyncio.sleep(0.01)
        raise AssertionError(f"{len(listeners)} listeners are left")

    using(use)


def test_a_capture_names_framing_speed_and_format_of_each_source(tmp_path: Path) -> None:
    async def use(ask: Asking) -> None:
        ports = ["bus0", "bus0.t", "plc", "plc.master", "m1.modbus", "can0", "s1", "s2", "s2.network", "m1"]
        capture, end = await ask("capture", ports=ports)
        end()
        framings = [(each.description, each.baud) for each in capture.sources]
        on_plc = ("modbus_rtu 8E1", 9600)
        terminal = ("raw", 0)
        assert framings[:5] == [("sac", 38400), ("sac", 38400), on_plc, on_plc, on_plc]
        assert framings[5:] == [("", 500_000), terminal, terminal, ("sac", 38400), terminal]
        assert [each.name for each in capture.sources if each.is_can] == ["can0"]

    config = json.loads(CONFIG)
    config["devices"]["s2"] = {"profile": "sac", "network": {"kind": "pty"}}
    config["segments"]["plc"] = {
        "modbus": {"units": {"m1": 1}},
        "baud": 9600,
        "format": "8E1",
        "taps": {"master": {"port": "pty"}},
    }
    config["can"] = {"can0": {"bit_rate": 500_000}}
    desk_in(tmp_path, json.dumps(config))(use)
