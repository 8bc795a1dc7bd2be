"""The desk refuses in the same words at every door, and asks for the same roles."""

import json
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from desk_support import OPERATOR, VIEWER, Asking, Using, desk_in, refusal

from bridges.zenoh.command_handler import command_at
from bridges.zenoh.keys import KEYS, Key
from hil.compose.find import find_boards
from hil.operations.control_socket import ClaimedSocket, ControlServer
from hil.operations.table import OPERATIONS, TYPED_BYTES
from hil.vocab.verbs import CODES


@pytest.fixture
def using(tmp_path: Path) -> Using:
    """Runs what is awaited with the desk of a daemon that has started."""
    return desk_in(tmp_path)


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
    names = {"<device>": "m1", "<verb>": "enable", "<name>": "pKp", "<id>": "r", "<do>": "take"}
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
        assert why.startswith("there is no verb 'explode'; did you mean \"reload\"? there are list, status, ")

    using(use)
