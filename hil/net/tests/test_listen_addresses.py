"""Addresses to listen at, as users write them, and who has one that is taken."""

import asyncio
import errno
import os
import socket
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.net.address_holder import address_holder
from hil.net.endpoint import BadAddress, check_joined, endpoint, has_port, listen_address
from hil.net.listeners import refusal, why_refused

GOOD: dict[str | int, str] = {
    "127.0.0.1:8080": "127.0.0.1:8080",
    "[::1]:8080": "[::1]:8080",
    "localhost:8080": "localhost:8080",
    "lab-1.example.org:80": "lab-1.example.org:80",
    "127.1:80": "127.1:80",
    8080: "127.0.0.1:8080",
    "8080": "127.0.0.1:8080",
    0: "127.0.0.1:0",
    "0.0.0.0": "0.0.0.0:9464",
    "[::]": "[::]:9464",
    "lab1": "lab1:9464",
}
BAD: dict[str | int, str] = {
    70000: "'70000' is no port",
    -1: "'-1' is no port",
    "-1": "'-1' is no port",
    "x:70000": "'70000' is no port",
    "x:-1": "'-1' is no port",
    "x:http": "'http' is no port",
    "x:": "there is no port behind the colon",
    ":8080": "':8080' has no host",
    "a:b:c": "'a:b:c' is no address and port",
    "::1": "'::1' is an IPv6 address without brackets",
    "::1:8080": "'::1:8080' is an IPv6 address without brackets",
    "[a]:80": "'[a]' is no address",
    "[127.0.0.1]:80": "'[127.0.0.1]' is no address",
    "[::1": "'[::1' is no address",
    "": "'' has no host",
    "a b": "'a b' is no address",
    " 127.0.0.1:80": "' 127.0.0.1' is no address",
    "127.0.0.1:80 ": "'80 ' is no port",
    "tcp/127.0.0.1:80": "is no address and port",
    "http://127.0.0.1:80": "is no address and port",
}


@pytest.mark.parametrize("text", GOOD)
def test_what_is_an_address(text: str | int) -> None:
    assert listen_address(text, 9464) == GOOD[text]
    endpoint(GOOD[text])


@pytest.mark.parametrize("text", BAD)
def test_what_is_none_is_said_with_a_remedy(text: str | int) -> None:
    with pytest.raises(BadAddress) as refused:
        listen_address(text, 9464)
    assert BAD[text] in str(refused.value)
    assert refused.value.remedy


@given(st.one_of(st.text(alphabet="0123456789abx:[]./ -", max_size=20), st.integers(-10, 10**6)))
def test_an_address_is_refused_or_can_be_parsed_and_stays_the_same(text: str | int) -> None:
    try:
        listen = listen_address(text, 9464)
    except BadAddress:
        return
    assert endpoint(listen)[1] <= 65535
    assert listen_address(listen, 1) == listen


def test_who_has_an_address_is_said() -> None:
    listen = (
        "import socket; s = socket.create_server(('127.0.0.1', 0)); print(s.getsockname()[1], flush=True)"
    )
    with subprocess.Popen(
        [sys.executable, "-c", f"{listen}; input()"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as other:
        assert other.stdout
        number = int(other.stdout.readline())
        for host in ("127.0.0.1", "0.0.0.0", "::"):
            assert f"(process {other.pid})" in address_holder(host, number)
        assert address_holder("127.0.0.2", number) == ""
        assert address_holder("localhost", number) == ""  # no address: nobody is looked for
        refused = asyncio.run(why_refused(f"127.0.0.1:{number}"))
        assert refused
        assert refused.is_taken
        assert str(refused).startswith(f"127.0.0.1:{number} is in use by python")
        assert str(refused).endswith(f"(process {other.pid}); choose another port, or end it")
        other.communicate("\n", timeout=20)


def test_a_listener_with_ipv6_has_the_ipv4_address_too() -> None:
    if not socket.has_dualstack_ipv6():
        pytest.skip("no IPv6 here")
    with socket.create_server(("::", 0), family=socket.AF_INET6, dualstack_ipv6=True) as server:
        assert f"(process {os.getpid()})" in address_holder("127.0.0.1", server.getsockname()[1])


def test_an_address_of_another_computer_is_refused_in_the_same_form() -> None:
    refused = asyncio.run(why_refused("192.0.2.1:80"))  # RFC 5737: nobody's
    assert str(refused) == (
        "192.0.2.1:80 is no address of this computer; write 127.0.0.1, or one that `ip address` shows"
    )
    assert asyncio.run(why_refused("127.0.0.1:0")) is None


def test_a_port_is_behind_a_name_or_not() -> None:
    assert [has_port(each) for each in ("lab1:1", "[::1]:1", "lab1", "[::1]")] == [True, True, False, False]


def test_a_port_without_the_right_to_it_is_refused_in_the_same_form() -> None:
    for number in (errno.EACCES, errno.EPERM):
        assert str(refusal(OSError(number, ""), "127.0.0.1:80")) == (
            "no right to listen at 127.0.0.1:80; choose a port above 1023, or give the right to this user"
        )
    assert not refusal(OSError(errno.EACCES, ""), "127.0.0.1:80").is_taken


@pytest.mark.parametrize(
    "given", ["tcp/127.0.0.1:7447", "tls/[::1]:7447", "tcp/lab:7447?rel=1", "serial//dev/ttyUSB0"]
)
def test_an_address_to_connect_to_is_zenohs(given: str) -> None:
    check_joined(given)


@pytest.mark.parametrize(
    "given", ["", "nonsense", "tcp/host", "tcp/:7447", "http://x:1", "tcp/a b:1", "tcp/x:0"]
)
def test_what_is_no_address_to_connect_to_is_refused(given: str) -> None:
    with pytest.raises(BadAddress) as refused:
        check_joined(given)
    assert refused.value.remedy.startswith("write ")
