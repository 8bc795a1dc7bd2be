"""Option ``listen`` of all doors and ports, their old keys, and where each is pointed out."""

import os
import socket
from contextlib import ExitStack
from typing import Any

import pytest
from e2e_support import Place
from pydantic import ValidationError

from bridges.metrics.metrics_options import Options as Metrics
from bridges.modbus.door.door_options import Options as Modbus
from bridges.web.web_options import Options as Web
from bridges.zenoh.options import Options as Zenoh
from hil.compose import find_catalogue
from hil.config import ConfigError, diff, parse
from virtual_ports.rfc2217.port import Options as Rfc2217
from virtual_ports.tcp.port import Options as Tcp


@pytest.mark.parametrize(
    ("options", "given_options", "listen"),
    [
        (Web, {}, "127.0.0.1"),
        (Web, {"host": "127.0.0.1", "port": None}, "127.0.0.1"),
        (Web, {"port": 9000}, "127.0.0.1:9000"),
        (Web, {"listen": 9000}, "127.0.0.1:9000"),
        (Web, {"host": "::1", "port": 9000}, "[::1]:9000"),
        (Web, {"listen": "localhost"}, "localhost"),
        (Tcp, {}, "127.0.0.1:0"),
        (Tcp, {"host": "0.0.0.0"}, "0.0.0.0:0"),
        (Tcp, {"host": "0.0.0.0", "port": 7001}, "0.0.0.0:7001"),
        (Rfc2217, {"listen": "0.0.0.0"}, "0.0.0.0:0"),
        (Metrics, {"listen": 9000}, "127.0.0.1:9000"),
        (Metrics, {"listen": "[::1]"}, "[::1]:9464"),
        (Modbus, {"listen": "localhost"}, "localhost:1502"),
    ],
)
def test_old_keys_and_new_ones_mean_the_same(options: Any, given_options: Any, listen: str) -> None:
    assert options.model_validate(given_options).listen == listen


@pytest.mark.parametrize("options", [Web, Tcp, Rfc2217])
def test_both_old_and_new_keys_are_a_mistake(options: Any) -> None:
    with pytest.raises(ValidationError, match="port beside listen: the address is there twice"):
        options.model_validate({"port": 1, "listen": 1})


@pytest.mark.parametrize(
    ("written", "listen"),
    [
        ("0.0.0.0:7448", ["tcp/0.0.0.0:7448"]),
        (7448, ["tcp/127.0.0.1:7448"]),
        (["127.0.0.1:1", "tls/[::]:2", "udp/x"], ["tcp/127.0.0.1:1", "tls/[::]:2", "udp/x"]),
        ([], []),
    ],
)
def test_zenoh_takes_addresses_beside_its_own_words(written: object, listen: list[str]) -> None:
    assert Zenoh.model_validate({"listen": written}).listen == listen


def test_an_address_of_zenohs_that_is_none_is_said() -> None:
    with pytest.raises(ValidationError, match="'70000' is no port"):
        Zenoh.model_validate({"listen": ["x:70000"]})


OLD = """\
bench: old
devices:
  m1:
    profile: mechaduino
    port: {kind: tcp, host: 0.0.0.0, port: 7001}
segments:
  bus0:
    taps:
      a: {port: {kind: rfc2217, port: 7002}}
bridges:
  web:
    host: "::1"
    port: 9000
"""
NEW = [
    "old.yaml:5:23: devices.m1.port: host, port: the old keys go with the next release"
    " (write `listen: 0.0.0.0:7001`)",
    "old.yaml:9:33: segments.bus0.taps.a.port: port: the old key goes with the next release"
    " (write `listen: 127.0.0.1:7002`)",
    "old.yaml:12:5: bridges.web: host, port: the old keys go with the next release"
    ' (write `listen: "[::1]:9000"`)',
]


def test_old_keys_are_read_and_pointed_out() -> None:
    read = parse(OLD, "old.yaml", find_catalogue())
    assert [str(each) for each in read.written.old_keys] == NEW
    new = OLD.replace("host: 0.0.0.0, port: ", "listen: 0.0.0.0:").replace("rfc2217, port", "rfc2217, listen")
    new = new.replace('    host: "::1"\n    port: 9000', '    listen: "[::1]:9000"')
    again = parse(new, "new.yaml", find_catalogue())
    assert again.written.old_keys == ()
    assert again == read
    assert [each.action for each in diff(read, again)] == ["keep"]


def test_two_doors_at_one_address_are_found() -> None:
    doors = "bridges:\n  web: {listen: 9000}\n  metrics: {listen: 9000}\n"
    text = f"bench: b\ndevices: {{s1: {{profile: sac}}}}\n{doors}"
    with pytest.raises(ConfigError) as refused:
        parse(text, "b.yaml", find_catalogue())
    assert str(refused.value).startswith(
        'b.yaml:5:21: bridges.metrics.listen: the bridge web listens in the same place, "127.0.0.1:9000"'
    )


def test_all_doors_that_cannot_be_had_are_listed_with_their_places_and_who_has_them() -> None:
    with Place() as place, ExitStack() as stack:
        here = [stack.enter_context(socket.create_server(("127.0.0.1", 0))) for _ in range(2)]
        taken = [each.getsockname()[1] for each in here]
        own = "bench: a\ndevices: {s1: {profile: sac}}\nbridges: {metrics: {listen: 0}}\n"
        other = place.serve(own, bench="a")
        taken.append(int(other.ask("status")["bridges"]["metrics"]["listen"][0].rpartition(":")[2]))
        said = place.launch(
            "bench: t\ndevices:\n"
            f"  m1: {{profile: mechaduino, port: {{kind: tcp, listen: {taken[0]}}}}}\n"
            f"bridges:\n  web: {{port: {taken[1]}}}\n  modbus: {{listen: {taken[2]}}}\n"
        ).refused()
        file = place.folder / "t.yaml"
        ours = f"(process {os.getpid()}); choose another port, or end it"
        assert f"WARNING {file}:5:9: bridges.web: port: the old key goes with the next release" in said
        for line, key, number in (("3:55", "devices.m1.port", 0), ("5:8", "bridges.web", 1)):
            beginning = f"{file}:{line}: {key}.listen: 127.0.0.1:{taken[number]} is in use by "
            (one,) = (each for each in said.splitlines() if each.startswith(beginning))
            assert one.endswith(ours)
        bench = f"127.0.0.1:{taken[2]} is in use by hil (process {other.process.pid}, bench a); choose"
        assert f"{file}:6:20: bridges.modbus.listen: {bench}" in said
