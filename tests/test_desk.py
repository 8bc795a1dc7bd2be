"""The desk: what is asked of a bench is carried out, and refused in the same words at every door."""

import asyncio
import gc
import json
import socket
from collections.abc import Awaitable, Callable
from inspect import isawaitable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from bridges.zenoh.command_handler import command_at
from bridges.zenoh.keys import KEYS, Key
from hil.compose.find import find_boards, find_catalogue
from hil.config import parse
from hil.core.fields import PACKED_BYTES
from hil.daemon import Daemon, Serving
from hil.operations.control_socket import ClaimedSocket, ControlServer
from hil.operations.table import OPERATIONS, TYPED_BYTES
from hil.vocab.desk_protocol import Desk, Done, Source, Watched
from hil.vocab.verbs import CODES, Role, VerbRefused

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
        "segments": {"bus0": {"stations": ["s1", "s10"], "taps": {"t": {"port": "pty"}}}},
    }
)
ADMIN, OPERATOR = Source("the tests", Role.ADMIN), Source("a hand", Role.OPERATOR)
VIEWER = Source("a guest", Role.VIEWER)


class Asking(NamedTuple):
    """A desk that is asked for something and waited for."""

    desk: Desk
    serving: Serving

    async def __call__(self, operation: str, target: str = "", source: Source = ADMIN, **given: Any) -> Any:
        answer = self.desk.ask(source, operation, target, given)
        return await answer if isawaitable(answer) else answer

    async def verb(self, device: str, name: str, source: Source = ADMIN, **parameters: Any) -> Done:
        done: Done = await self("do", device, source, name=name, parameters=parameters)
        return done

    async def wait(self, device: str, done: Done, at_most_s: float) -> bool:
        """Whether what was begun was ended by something else."""
        given = {name: done.answer[name] for name in ("ends_after_ns", "set_point") if name in done.answer}
        at_ns = done.effective_at_ns
        ended = await self("wait", device, effective_at_ns=at_ns, at_most_s=at_most_s, **given)
        return bool(ended["interrupted"])

    async def until_ready(self, device: str, at_ns: int = 4_500_000_000) -> None:
        for _ in range(3000):
            if (await self("state", device))["at_ns"] > at_ns:
                return
            await asyncio.sleep(0.01)
        raise AssertionError("simulated time does not go on")


Using = Callable[[Callable[[Asking], Awaitable[None]]], None]


@pytest.fixture
def using(tmp_path: Path) -> Using:
    """Runs what is awaited with the desk of a daemon that has started."""

    def run(use: Callable[[Asking], Awaitable[None]]) -> None:
        async def main() -> None:
            config = parse(CONFIG, "h.yaml", find_catalogue())
            daemon = Daemon(
                config, config_folder=tmp_path, runtime_base=tmp_path / "run", state_base=tmp_path / "state"
            )
            started: asyncio.Future[Serving] = asyncio.get_running_loop().create_future()
            running = asyncio.create_task(daemon.run(started.set_result))
            await asyncio.wait({running, started}, return_when=asyncio.FIRST_COMPLETED, timeout=30)
            try:
                assert started.done()
                serving = started.result()
                await use(Asking(serving.desk, serving))
            finally:
                daemon.stop()
                await running

        asyncio.run(main())

    return run


async def refusal(asking: Awaitable[Any]) -> tuple[str, str]:
    with pytest.raises(VerbRefused) as refused:
        await asking
    return refused.value.code, str(refused.value)


# ---- one desk, many doors ----


class Wrong(NamedTuple):
    """A request that is refused: as the desk, and as zenoh's keys (``key``, ``payload``) have it."""

    operation: str
    target: str
    given: dict[str, Any]
    key: str
    payload: Any
    code: str


def verb(device: str, name: str, parameters: dict[str, Any], code: str) -> Wrong:
    given = {"name": name, "parameters": parameters}
    return Wrong("do", device, given, f"axis/{device}/cmd/{name}", parameters, code)


def field(device: str, name: str, value: Any, code: str) -> Wrong:
    given = {"field": name, "value": value}
    return Wrong("set", device, given, f"axis/{device}/param/{name}", value, code)


def fault(target: str, kind: str, parameters: dict[str, Any], code: str) -> Wrong:
    given, key = {"fault": kind, "parameters": parameters}, f"axis/{target}/fault"
    return Wrong("inject", target, given, key, {"fault": kind} | parameters, code)


WRONG = (
    verb("m9", "reset", {}, "no_device"),
    verb("m9", "pin", {"pin": "D3", "level": 1}, "no_device"),
    verb("m1", "pin", {"pin": "D9", "level": 1}, "bad_parameter"),
    verb("m1", "pin", {"pin": "D3", "level": 2}, "bad_parameter"),
    verb("m1", "pin", {"pin": "D3", "level": 0.5}, "bad_parameter"),
    verb("m1", "pin", {"pin": "D3"}, "bad_parameter"),
    verb("m1", "pin", {"pin": "D3", "level": True, "more": 1}, "bad_parameter"),
    verb("real", "pin", {"pin": "D3", "level": 1}, "cannot"),
    verb("s1", "reset", {"hard": 1}, "bad_parameter"),
    verb("m1", "type", {"text": r"\q"}, "bad_parameter"),
    verb("m1", "type", {"text": "€"}, "bad_parameter"),
    verb("m1", "type", {"text": "x" * (TYPED_BYTES + 1)}, "bad_parameter"),
    verb("m1", "jump", {}, "no_verb"),
    verb("real", "move_abs", {"position_deg": 1}, "no_verb"),
    verb("m1", "move_abs", {"position_deg": "far", "how": 1}, "bad_parameter"),
    verb("m1", "move_abs", {"position_deg": 90}, "not_now"),
    field("m9", "pKp", 1, "no_device"),
    field("m1", "r", 1, "no_parameter"),
    field("m1", "pkp", 1, "no_parameter"),
    field("s1", "pKp", 1, "no_parameter"),
    field("m1", "diaagc", 0x8000, "bad_parameter"),
    field("m1", "load_torque_Nm", 99.0, "bad_parameter"),
    field("real", "pKp", 1, "cannot"),
    fault("m1", "shaft_jm", {}, "bad_parameter"),
    fault("m9", "shaft_jam", {}, "bad_parameter"),
    fault("m1", "shaft_jam", {"rate": 1}, "bad_parameter"),
    Wrong("inject", "m1", {"parameters": {}}, "axis/m1/fault", {}, "bad_parameter"),
    Wrong("clear", "", {"number": 9, "on": "m1"}, "axis/m1/fault", {"clear": 9}, "bad_parameter"),
    Wrong("clear", "", {"number": "9", "on": "bus0"}, "segment/bus0/fault", {"clear": "9"}, "bad_parameter"),
    Wrong("cancel_run", "r9", {"how": "grace"}, "run/r9/cancel", {}, "no_run"),
    Wrong("cancel_run", "r9", {"how": "soon"}, "run/r9/cancel", {"how": "soon"}, "bad_parameter"),
    Wrong("run", "", {"text": "run: r\n"}, "run/submit", "run: r\n", "bad_run"),
)


async def at_socket(server: ControlServer, wrong: Wrong, operation: str, given: dict[str, Any]) -> Any:
    argument = OPERATIONS[operation].target.argument
    request = {"verb": operation, **given} | ({argument: wrong.target} if argument else {})
    answer = await server.answer(json.dumps(request).encode())
    if answer["ok"]:  # a text's problems
        return "bad_run", answer["result"]["problems"]
    return answer["code"], answer["error"]


def test_what_is_refused_is_refused_in_the_same_words_at_every_door(using: Using, tmp_path: Path) -> None:
    async def use(ask: Asking) -> None:
        claimed = ClaimedSocket(tmp_path / "test.sock", "h")
        server = ControlServer(ask.desk, claimed)
        for wrong in WRONG:
            told = await refusal(ask(wrong.operation, wrong.target, **wrong.given))
            assert told[0] == wrong.code, told
            assert told[0] in CODES
            assert await at_socket(server, wrong, wrong.operation, wrong.given) == told
            if wrong.operation == "do" and (name := wrong.given["name"]) in OPERATIONS and name != "run":
                assert await at_socket(server, wrong, name, wrong.given["parameters"]) == told
            is_text = isinstance(wrong.payload, str)
            payload = wrong.payload.encode() if is_text else json.dumps(wrong.payload).encode()
            reader = command_at(wrong.key, True)
            assert reader
            operation, target, given = reader(payload)
            assert await refusal(ask(operation, target, **given)) == told
        await server.close()
        claimed.release()

    using(use)


def test_each_operation_asks_for_its_role(using: Using) -> None:
    async def use(ask: Asking) -> None:
        for operation in OPERATIONS.values():
            for source in (VIEWER, OPERATOR):
                if source.role < operation.role:
                    needed = operation.role.name.lower()
                    why = f"{operation.name} needs the role {needed}"
                    assert await refusal(ask(operation.name, "m1", source)) == ("forbidden", why)
        for name in ask.desk.describe().devices["m1"].verbs:
            told = await refusal(ask.verb("m1", name, VIEWER))
            assert told == ("forbidden", f"{name} needs the role operator")

    using(use)


@pytest.mark.parametrize("key", [key for key in KEYS if "command" in key.way], ids=lambda key: key.pattern)
def test_a_key_asks_for_the_role_of_its_operation(key: Key) -> None:
    names = {"<device>": "m1", "<verb>": "enable", "<name>": "pKp", "<id>": "r"}
    path = key.pattern
    for placeholder, name in names.items():
        path = path.replace(placeholder, name)
    payloads = {"axis/m1/param/pKp": b"1", "run/submit": b"run: r"}
    reader = command_at(path, True)
    assert reader
    asked = reader(payloads.get(path, b"{}"))
    verbs = find_boards()["mechaduino"].table
    role = verbs["enable"].role if asked.operation == "do" else OPERATIONS[asked.operation].role
    assert key.role == role


def test_what_is_not_in_the_table_is_not_asked(using: Using) -> None:
    async def use(ask: Asking) -> None:
        code, why = await refusal(ask("explode"))
        assert code == "no_verb"
        assert why.startswith("there is no verb 'explode'; verbs are list, status, ")

    using(use)


# ---- operations ----


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


def test_faults_of_a_device_are_not_those_of_one_with_a_longer_name(using: Using) -> None:
    async def use(ask: Asking) -> None:
        async def begun(target: str, fault: str = "shaft_jam", **parameters: Any) -> int:
            return int((await ask("inject", target, fault=fault, parameters=parameters))["number"])

        one, other = await begun("s1"), await begun("s10")
        line = await begun("s10.network", "byte_drop", rate=0.5)
        told = await refusal(ask("clear", number=other, on="s1"))
        assert told == ("bad_parameter", f"there is no fault {other} on s1; there are: {one}")
        for wrong in (True, "1", [1], None):
            assert (await refusal(ask("clear", number=wrong, on="s1")))[0] == "bad_parameter"
        assert await ask("clear", number=float(one), on="s1") == {"cleared": [one]}
        assert await ask("clear", number="all", on="s1") == {"cleared": []}
        assert await ask("clear", number=line, on="s10") == {"cleared": [line]}
        assert await ask("clear", number="all") == {"cleared": [other]}

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
        assert (code, "its main program starts, or is in a routine" in why) == ("not_now", True)
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
        watch.take()
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
        assert ask.desk.describe().ports == ["m1", "s1", "s10", "bus0.t", "real"]
        with pytest.raises(VerbRefused, match="there is no port 's9'; there are bus0, m1, ") as refused:
            ask.desk.watch(VIEWER, Watched.BYTES, "s9", print)
        assert refused.value.code == "no_place"

    using(use)


def test_metrics_while_a_reload_changes_devices(using: Using) -> None:
    """A scrape lets others run between any two values."""

    async def use(ask: Asking) -> None:
        places, devices = ask.serving.live.places.uarts, ask.serving.live.sim.devices
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
