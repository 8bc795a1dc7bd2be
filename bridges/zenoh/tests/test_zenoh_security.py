"""Users, signatures and what zenoh is told; without a network."""

import json
from pathlib import Path
from typing import Any

import pytest
import zenoh

from bridges.zenoh import gate as signatures
from bridges.zenoh.gate import FRESH_NS, Gate, Rejected
from bridges.zenoh.keys import COMMAND, KEYS
from bridges.zenoh.options import Options, TlsOptions
from bridges.zenoh.users import SecurityError, User, read_users
from bridges.zenoh.zenoh_config import access_control, client_config, is_loopback, made, session_config
from hil.net.signature import signed
from hil.vocab.verbs import Role

NOW_NS = 1_795_254_243_000_000_000
KEY = "hil/b/axis/m1/cmd/move_to"
PAYLOAD = b'{"position_deg": 90}'
NONCE = "00112233445566778899aabbccddeeff"
VIC = User("vic", Role.VIEWER, "the-viewers-password")
OPA = User("opa", Role.OPERATOR, "the-operators-password")
ADA = User("ada", Role.ADMIN, "the-admins-password")
USERS = [VIC, OPA, ADA]


def users_file(folder: Path, text: str, mode: int = 0o600) -> Path:
    path = folder / "users"
    path.write_text(text)
    path.chmod(mode)
    return path


# ---- the users' file ----


def test_a_users_file(tmp_path: Path) -> None:
    text = "# the team\n\nvic:viewer:the-viewers-password\nada:admin:with:colons:and # hash\n"
    assert read_users(users_file(tmp_path, text)) == [VIC, User("ada", Role.ADMIN, "with:colons:and # hash")]


def test_a_secret_is_not_in_what_a_user_prints_as() -> None:
    assert OPA.secret not in repr(OPA)


def test_all_wrong_lines_are_named(tmp_path: Path) -> None:
    lines = [
        "vic:viewer:the-viewers-password",
        "opa",
        "op a:operator:the-operators-password",
        "opa:boss:the-operators-password",
        "opa:operator:short",
        "vic:admin:another-password",
        "eve:admin:the-viewers-password",
    ]
    path = users_file(tmp_path, "\n".join(lines))
    with pytest.raises(SecurityError) as caught:
        read_users(path)
    problems = str(caught.value).splitlines()
    assert [problem.split(":")[1] for problem in problems] == ["2", "3", "4", "5", "6", "7"]
    wanted = ("name:role:password", "no name", "viewer, operator, admin", "12", "twice", "as another user")
    for problem, words in zip(problems, wanted, strict=True):
        assert words in problem


@pytest.mark.parametrize("mode", [0o640, 0o604, 0o660])
def test_a_file_that_others_can_read_is_refused(tmp_path: Path, mode: int) -> None:
    path = users_file(tmp_path, "vic:viewer:the-viewers-password\n", mode)
    with pytest.raises(SecurityError, match="chmod 600"):
        read_users(path)


def test_an_empty_and_a_missing_file_are_refused(tmp_path: Path) -> None:
    with pytest.raises(SecurityError, match="no user"):
        read_users(users_file(tmp_path, "# nobody yet\n"))
    with pytest.raises(SecurityError, match="hil zenoh keys"):
        read_users(tmp_path / "none")
    users = users_file(tmp_path, "")
    users.write_bytes(b"# b\xff\n")
    with pytest.raises(SecurityError, match=r"users:1:4: the byte 0xff is not UTF-8 text"):
        read_users(users)


# ---- signatures ----


def attachment(user: User = OPA, at_ns: int = NOW_NS, nonce: str = NONCE, secret: str | None = None) -> bytes:
    return signed(user.name, secret or user.secret, KEY, PAYLOAD, at_ns, nonce)


def test_the_gate_knows_who_signed() -> None:
    gate = Gate(USERS)
    assert gate.check(attachment(), KEY, PAYLOAD, NOW_NS) == OPA
    assert gate.check(attachment(VIC), KEY, PAYLOAD, NOW_NS) == VIC


@pytest.mark.parametrize(
    ("given", "key", "payload"),
    [
        (attachment(), "hil/b/axis/m2/cmd/move_to", PAYLOAD),
        (attachment(), KEY, PAYLOAD + b" "),
        (attachment(secret="another-password"), KEY, PAYLOAD),
        (attachment(User("eve", Role.ADMIN, "")), KEY, PAYLOAD),
        (attachment(User("eve", Role.ADMIN, "")).replace(b"eve", b"opa"), KEY, PAYLOAD),
        (attachment().replace(b'"opa"', b'"ada"'), KEY, PAYLOAD),
        (attachment().replace(str(NOW_NS).encode(), str(NOW_NS + 1).encode()), KEY, PAYLOAD),
        (attachment().replace(b"0011", b"1100"), KEY, PAYLOAD),
    ],
    ids=["key", "payload", "password", "unknown", "no-password", "other-user", "time", "nonce"],
)
def test_what_was_changed_is_refused(given: bytes, key: str, payload: bytes) -> None:
    with pytest.raises(Rejected, match="wrong: check user, password, key and payload"):
        Gate(USERS).check(given, key, payload, NOW_NS)


def test_a_line_feed_in_a_key_cannot_move_the_fields() -> None:
    key, payload = f"{KEY}\n{NOW_NS}\n{NONCE}", b"x"
    given = signed("opa", OPA.secret, KEY, f"{NOW_NS}\n{NONCE}\n".encode() + payload, NOW_NS, NONCE)
    with pytest.raises(Rejected):
        Gate(USERS).check(given, key, payload, NOW_NS)


@pytest.mark.parametrize(
    "given",
    [
        None,
        b"",
        b"{",
        b"[]",
        b"\xff\xfe",
        b"[" * 1024,
        attachment() + b" " * 4096,
        attachment().replace(NONCE.encode(), b"xyz"),
        attachment().replace(NONCE.encode(), NONCE.encode() * 3),
        attachment().replace(str(NOW_NS).encode(), b'"now"'),
        attachment().replace(str(NOW_NS).encode(), b"1.5"),
        attachment(at_ns=10**400),
        attachment(at_ns=-1),
        b'{"user": "opa"}',
    ],
)
def test_what_is_no_signature_is_refused(given: bytes | None) -> None:
    with pytest.raises(Rejected, match=r"the attachment has to be|not signed") as caught:
        Gate(USERS).check(given, KEY, PAYLOAD, NOW_NS)
    assert caught.value.code == "forbidden"


@pytest.mark.parametrize("late_ns", [-FRESH_NS, 0, FRESH_NS])
def test_a_signature_is_good_for_thirty_seconds_either_way(late_ns: int) -> None:
    assert Gate(USERS).check(attachment(at_ns=NOW_NS - late_ns), KEY, PAYLOAD, NOW_NS) == OPA
    step_ns = 1 if late_ns >= 0 else -1
    with pytest.raises(Rejected, match=r"(30\.0 s old|of 30\.0 s from now); compare the clocks"):
        Gate(USERS).check(attachment(at_ns=NOW_NS - FRESH_NS * step_ns - step_ns), KEY, PAYLOAD, NOW_NS)


def test_what_was_signed_before_the_start_is_refused() -> None:
    gate = Gate(USERS, NOW_NS)
    assert gate.check(attachment(at_ns=NOW_NS), KEY, PAYLOAD, NOW_NS + 1) == OPA
    with pytest.raises(Rejected, match="before the daemon's start"):
        gate.check(attachment(at_ns=NOW_NS - 1, nonce=NONCE[::-1]), KEY, PAYLOAD, NOW_NS + 1)


def test_a_signature_is_good_once() -> None:
    gate = Gate(USERS)
    gate.check(attachment(), KEY, PAYLOAD, NOW_NS)
    gate.check(attachment(nonce=NONCE[::-1]), KEY, PAYLOAD, NOW_NS)
    gate.check(attachment(ADA), KEY, PAYLOAD, NOW_NS)
    for later_ns in (0, 1, FRESH_NS):
        with pytest.raises(Rejected, match="used before"):
            gate.check(attachment(), KEY, PAYLOAD, NOW_NS + later_ns)
    with pytest.raises(Rejected, match="s old"):
        gate.check(attachment(), KEY, PAYLOAD, NOW_NS + FRESH_NS + 1)


def test_the_memory_of_nonces_is_bounded_and_forgets_nothing_that_is_fresh(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(signatures, "REMEMBERED", 100)
    gate = Gate(USERS)
    sent = [attachment(at_ns=NOW_NS + n, nonce=f"{n:032x}") for n in range(1000)]
    for each in sent:
        gate.check(each, KEY, PAYLOAD, NOW_NS)
    for each in sent:
        with pytest.raises(Rejected, match="used before"):
            gate.check(each, KEY, PAYLOAD, NOW_NS + FRESH_NS)
    assert len(gate._seen["opa"]._nonces) == 100
    assert gate.check(attachment(ADA), KEY, PAYLOAD, NOW_NS) == ADA, "another's flood is not hers"


def test_old_nonces_are_forgotten() -> None:
    gate = Gate(USERS)
    for n in range(50):
        at_ns = NOW_NS + 2 * n * FRESH_NS
        gate.check(attachment(at_ns=at_ns, nonce=f"{n:032x}"), KEY, PAYLOAD, at_ns)
    assert len(gate._seen["opa"]._nonces) == 1


# ---- what zenoh is told ----


def allowed(users: list[User], who: str, flow: str, message: str, key: str, by: Any = "usrpwd") -> bool:
    """Return whether zenoh's rules allow a message, by its own inclusion of keys."""
    control = access_control(users, "b", by)
    assert control["enabled"]
    assert control["default_permission"] == "deny"
    assert {rule["permission"] for rule in control["rules"]} == {"allow"}
    rules = {rule["id"]: rule for rule in control["rules"]}
    subjects = {each["id"] for each in control["subjects"] if who in each["usernames"]}
    mine = [
        rules[n]
        for policy in control["policies"]
        if subjects & set(policy["subjects"])
        for n in policy["rules"]
    ]
    return any(
        flow in rule["flows"]
        and message in rule["messages"]
        and any(zenoh.KeyExpr(each).includes(zenoh.KeyExpr(key)) for each in rule["key_exprs"])
        for rule in mine
    )


def test_each_command_is_for_its_role_and_those_above() -> None:
    commands = [key for key in KEYS if COMMAND in key.way]
    assert {key.role for key in commands} == {Role.OPERATOR, Role.ADMIN}
    for key in commands:
        one = "hil/b/" + key.pattern.replace("<device>", "m1").replace("<name>", "x").replace("<verb>", "go")
        for user in USERS:
            assert allowed(USERS, user.name, "ingress", "put", one) == (user.role >= key.role), (user, one)


def test_nobody_may_tell_what_the_daemon_tells() -> None:
    for user in USERS:
        for message in ("delete", "reply", "declare_queryable", "liveliness_token"):
            assert not allowed(USERS, user.name, "ingress", message, "hil/b/axis/m1/state")
            assert not allowed(USERS, user.name, "ingress", message, "hil/b/@live/daemon")
        for key in ("axis/m1/state", "sim/clock", "verbs/m1", "layout", "port/m1/tx", "**", "axis/m1/**"):
            assert not allowed(USERS, user.name, "ingress", "put", f"hil/b/{key}")
        for flow, message in (("ingress", "put"), ("ingress", "query"), ("ingress", "declare_subscriber")):
            assert not allowed(USERS, user.name, flow, message, "hil/other/axis/m1/cmd/go")


def test_with_certificates_a_user_is_certificate_and_password_together() -> None:
    for subject in access_control(USERS, "b", "tls")["subjects"]:
        assert subject["cert_common_names"] == subject["usernames"] == [subject["id"]]
    assert "cert_common_names" not in access_control(USERS, "b")["subjects"][0]


@pytest.mark.parametrize(
    ("endpoint", "expected"),
    [
        ("tcp/127.0.0.1:7447", True),
        ("tcp/127.8.0.1:0", True),
        ("tcp/[::1]:7447", True),
        ("tcp/localhost:7447", True),
        ("tls/127.0.0.1:7447?rel=1#iface=lo", True),
        ("unixsock-stream//run/hil/zenoh", True),
        ("tcp/0.0.0.0:7447", False),
        ("tcp/[::]:7447", False),
        ("tcp/10.0.0.1:7447", False),
        ("tcp/localhost.example.com:7447", False),
        ("tcp/10.0.0.1:7447#127.0.0.1:1", False),
        ("udp/224.0.0.224:7446", False),
        ("serial//dev/ttyS0", False),
        ("nonsense", False),
        ("", False),
    ],
)
def test_loopback(endpoint: str, expected: bool) -> None:
    assert is_loopback(endpoint) is expected


def config_of(users: list[User] | None = None, **options: Any) -> dict[str, Any]:
    if users:
        options["users"] = Path("users")
    return session_config(Options(**options), "b", users or [], "dictionary")


TLS = TlsOptions(ca=Path("ca"), certificate=Path("c"), key=Path("k"))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"listen": ["tcp/0.0.0.0:7447"]}, "hil zenoh site"),
        ({"listen": ["tcp/127.0.0.1:7447", "tcp/[::]:7448"]}, r"tcp/\[::\]:7448"),
        ({"tls": TLS}, "add `users`"),
        ({"users": USERS, "listen": ["udp/224.0.0.1:7447"]}, "write tcp/"),
        ({"users": USERS, "listen": ["tcp/0.0.0.0:7447"], "tls": TLS}, "write tls/"),
        ({"users": USERS, "connect": ["tcp/10.0.0.1:7447"]}, "listen: "),
    ],
)
def test_an_open_door_is_refused_with_a_remedy(options: dict[str, Any], words: str) -> None:
    with pytest.raises(SecurityError, match=words):
        config_of(**options)


def test_an_open_door_that_is_asked_for() -> None:
    config = config_of(listen=["tcp/0.0.0.0:7447"], insecure=True)
    assert config["listen/endpoints"] == ["tcp/0.0.0.0:7447"]
    assert "access_control" not in config


def test_by_default_nobody_is_looked_for_and_nobody_told() -> None:
    config = config_of()
    assert config["listen/endpoints"] == ["tcp/127.0.0.1:7447"]
    for what in ("scouting/multicast", "scouting/gossip", "adminspace", "transport/shared_memory"):
        assert config[f"{what}/enabled"] is False
    assert config_of(listen=[], connect=["tcp/10.0.0.1:7447"])["listen/endpoints"] == []


def test_zenoh_takes_all_of_it() -> None:
    for config in (
        config_of(USERS),
        config_of(USERS, tls=TLS),
        client_config(["tls/10.0.0.1:7447"], "opa", OPA.secret, TLS),
    ):
        read_back = json.loads(str(made(config)))
        assert read_back["mode"] == config["mode"]
        assert read_back["transport"]["unicast"]["max_links"] == 1
