"""The key ``about``: asked for, and told when it changes."""

import json
from typing import Any

from bridges.zenoh.access import access_control
from bridges.zenoh.users import User
from hil.net.answers import misfit
from hil.testing import Bench
from hil.vocab.bridge_protocol import PROTOCOL_VERSION
from hil.vocab.verbs import Role

CONFIG = {
    "bench": "mill",
    "labels": {"rig": "press"},
    "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}, "s1": {"profile": "sac"}},
    "bridges": {"zenoh": {}},
}


MILL = User("mill", Role.OPERATOR, "x", is_bench=True)


def content(sample: Any) -> dict[str, Any]:
    told: dict[str, Any] = json.loads(sample.payload.to_string())
    return told


def test_a_query_of_all_benches_is_answered_under_the_own_name() -> None:
    b = Bench(CONFIG)
    b.start()
    with b.zenoh() as session:
        (reply,) = session.get("hil/*/about")
        told = content(reply.ok)
        assert str(reply.ok.key_expr) == "hil/mill/about"
    assert misfit("about", told) == ""
    assert told["labels"] == {"rig": "press"}
    assert told["protocol"] == PROTOCOL_VERSION
    assert told["devices"] == {
        "m1": {"profile": "mechaduino", "axes": ["m1"], "is_real": False},
        "s1": {"profile": "sac", "axes": ["s1"], "is_real": False},
    }
    assert told["lease"] is None
    assert told["health"]["state"] == "ok"


def test_it_is_told_again_when_somebody_commands() -> None:
    b = Bench(CONFIG)
    b.start()
    with b.zenoh() as session:
        heard = session.declare_subscriber("hil/*/about")
        assert content(heard.recv())["commanders"] == []
        session.put("hil/mill/axis/m1/cmd/enable", "{}")
        told = content(heard.recv())
        assert [each["who"] for each in told["commanders"]] == ["zenoh"]
        b.run(3000)
        assert heard.try_recv() is None


def test_users_and_benches_of_a_router_may_ask_all_at_once() -> None:
    known = [*(User(n, r, "x") for n, r in (("vera", Role.VIEWER), ("otto", Role.OPERATOR))), MILL]
    own_door = access_control(known[:1], "mill")
    assert any("hil/*/about" in rule["key_exprs"] for rule in own_door["rules"])
    made = access_control(known, "*")
    rules = {rule["id"]: rule for rule in made["rules"]}

    def may(name: str, flow: str) -> set[str]:
        ids = [n for policy in made["policies"] if name in policy["subjects"] for n in policy["rules"]]
        asked = [rules[n] for n in ids if "query" in rules[n]["messages"] and flow in rules[n]["flows"]]
        return {key for rule in asked for key in rule["key_exprs"]}

    assert "hil/*/about" in may("vera", "ingress")
    assert "hil/*/halt" not in may("vera", "ingress")
    assert {"hil/*/about", "hil/*/halt"} <= may("otto", "ingress")
    assert {"hil/*/about", "hil/*/halt"} <= may("mill", "egress")
    assert "hil/*/halt" in may("mill", "ingress")  # for who stops the site at its page
    assert "hil/*/about" not in may("mill", "ingress")
