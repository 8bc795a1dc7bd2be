"""RFC 2217 port, against pyserial's own client over a real socket, and its codec byte by byte."""

import asyncio
import os
import shutil
import subprocess
import termios
import threading
from itertools import pairwise
from pathlib import Path

import pytest
import serial
from hypothesis import given
from hypothesis import strategies as st

from hil.testing.ports import RecordingHost, run_port, until
from hil.vocab.ports import PortContext
from virtual_ports.rfc2217.port import Options, make
from virtual_ports.rfc2217.telnet import DO, DONT, ECHO, WILL, WONT, Telnet

pytestmark = pytest.mark.filterwarnings("ignore:set(Daemon|Name)")  # pyserial 3.5 of its threads
ALL = bytes(range(256))
LOCAL_FLAGS = 3
VERBS = (DO, DONT, WILL, WONT)
NEGOTIATING = [bytes((255, verb)) for verb in VERBS]


def made():
    return make(Options(), PortContext("b", "s1", Path("/nowhere")))


def read_some(fd):
    try:
        return os.read(fd, 4096)
    except BlockingIOError:
        return b""


def with_client(script, answer=lambda data: b""):
    """Run ``script(client)`` in a thread against a port; answers the host."""
    port = made()
    hosts: list[RecordingHost] = []
    wrong: list[BaseException] = []

    async def scenario(port, host):
        hosts.append(host)
        host.answer = answer

        def talk():
            try:
                with serial.serial_for_url(port.address, 38400, timeout=10) as client:
                    script(client)
            except BaseException as error:
                wrong.append(error)

        thread = threading.Thread(target=talk)
        thread.start()
        await until(lambda: not thread.is_alive())

    run_port(port, scenario)
    assert wrong == []
    return hosts[0]


def test_every_byte_passes_both_ways():
    def script(client):
        client.write(ALL)
        assert client.read(256) == ALL

    host = with_client(script, answer=lambda data: data)
    assert host.got == ALL
    assert set(host.bauds) == {38400}


@pytest.mark.skipif(shutil.which("telnet") is None, reason="no telnet here")
def test_a_persons_telnet_sends_each_key_at_once_and_shows_it_once():
    port = made()

    async def scenario(port, host):
        host.answer = lambda data: b"answer to " + data
        ours, its = os.openpty()
        try:
            command = ["telnet", *port.address.removeprefix("rfc2217://").split(":")]
            telnet = subprocess.Popen(command, stdin=its, stdout=its, stderr=its, start_new_session=True)
            try:
                await until(lambda: not termios.tcgetattr(its)[LOCAL_FLAGS] & (termios.ICANON | termios.ECHO))
                os.write(ours, b"p")
                os.set_blocking(ours, False)
                shown = bytearray()
                await until(lambda: b"answer to p" in shown or shown.extend(read_some(ours)))
                assert host.got == b"p"
                assert shown.endswith(b"\nanswer to p")
            finally:
                telnet.kill()
                telnet.wait()
        finally:
            os.close(ours)
            os.close(its)

    run_port(port, scenario)


def test_baud_break_and_modem_lines():
    def script(client):
        client.baudrate = 250_000
        client.write(b"a")
        client.send_break(0.01)
        client.write(b"b")
        client.dtr = False
        client.rts = False
        assert (client.cts, client.dsr, client.cd, client.ri) == (True, True, True, False)
        client.write(b"c")
        client.reset_input_buffer()

    host = with_client(script)
    assert host.got == b"a\0bc"
    assert host.bauds == [250_000] * len(host.bauds)


def test_the_next_client_starts_anew():
    port = made()

    async def scenario(port, host):
        loop = asyncio.get_running_loop()

        def talk(baud):
            with serial.serial_for_url(port.address, baud, timeout=10) as client:
                client.write(b"x")

        for baud in (9600, 115200):
            before = len(host.got)
            await loop.run_in_executor(None, talk, baud)
            await until(lambda: len(host.got) > before)  # noqa: B023 - awaited here
            assert host.bauds[-1] == baud
        await until(lambda: port.stats().clients == 0)
        assert port.client_baud() is None

    run_port(port, scenario)


def test_negotiations_end():
    telnet = Telnet("x")
    assert telnet.decode(b"\xff\xfd\x2c") == (b"", b"\xff\xfb\x2c\xff\xfa\x2c\x6b\xb0\xff\xf0")
    assert telnet.decode(b"\xff\xfd\x2c") == (b"", b"")
    assert telnet.decode(b"\xff\xfb\x2c") == (b"", b"\xff\xfd\x2c")
    assert telnet.decode(b"\xff\xfd\x63") == (b"", b"\xff\xfc\x63")
    assert telnet.decode(b"\xff\xfb\x63") == (b"", b"\xff\xfe\x63")
    assert telnet.decode(b"\xff\xfc\x63") == (b"", b"")
    assert telnet.decode(b"\xff\xfe\x2c") == (b"", b"\xff\xfc\x2c")


def commands(data: bytes) -> list[tuple[int, int]]:
    """Verbs and options of what a client is sent, without requests."""
    return [
        (data[at + 1], data[at + 2]) for at in range(0, len(data) - 2) if data[at : at + 2] in NEGOTIATING
    ]


def test_a_client_is_offered_to_send_each_key_at_once_and_to_show_none_twice():
    telnet = Telnet("x")
    assert telnet.hello == b"\xff\xfb\x01\xff\xfb\x03\xff\xfb\x00\xff\xfd\x00"
    agreed = b"\xff\xfd\x01\xff\xfd\x03\xff\xfd\x00\xff\xfb\x00"
    assert telnet.decode(agreed + b"p\r\x00") == (b"p\r\x00", b"")
    refused = agreed.replace(b"\xfd", b"\xfe").replace(b"\xfb", b"\xfc")
    assert Telnet("x").decode(refused) == (b"", b"")


def is_its_own(each):
    verb, option = each
    return verb in (WILL, WONT), option


@given(
    st.sets(st.sampled_from((0, 1, 3, 44))),
    st.lists(st.tuples(st.sampled_from(VERBS), st.integers(0, 255)), unique_by=is_its_own),
)
def test_a_client_that_keeps_to_rfc_854_is_answered_once(wants, asked):
    """It agrees to what it wants, refuses the rest, and answers changes alone. It takes back nothing that
    it asked for: two such sides go round by RFC 854, as RFC 1143 says; the next test has the bound."""
    telnet = Telnet("x")
    is_on = dict.fromkeys((is_ours, option) for is_ours in (True, False) for option in range(256))
    sent = telnet.decode(b"".join(bytes((255, *each)) for each in asked))[1]
    waiting, rounds = telnet.hello + sent, 0
    while waiting:
        rounds += 1
        assert rounds < 4
        answers = b""
        for verb, option in commands(waiting):
            key = (verb in (WILL, WONT), option)
            agrees = verb in (WILL, DO) and option in wants
            if is_on[key] != agrees:
                is_on[key] = agrees
                answers += bytes(
                    (255, (DO if agrees else DONT) if key[0] else (WILL if agrees else WONT), option)
                )
        waiting = telnet.decode(answers)[1]


@given(st.data(), st.integers(0, 255))
def test_no_answers_go_round_for_ever_whatever_a_client_makes_of_them(data, option):
    """It answers each answer with one of its choice, as the one that always wants the contrary."""
    telnet, answered = Telnet("x"), 0
    reply = b"\xff" + bytes((DO, option))
    contrary = {WILL: DONT, WONT: DO, DO: WONT, DONT: WILL}
    pick = data.draw(st.sampled_from([contrary, dict.fromkeys(VERBS, DO), dict.fromkeys(VERBS, WILL), None]))
    while reply := telnet.decode(reply)[1]:
        answered += 1
        assert answered < 50
        verb, its = commands(reply)[0]
        reply = bytes((255, pick[verb] if pick else data.draw(st.sampled_from(VERBS)), its))


def test_the_one_that_always_wants_the_contrary_is_refused_in_the_end():
    telnet, said = Telnet("x"), [WILL]
    assert telnet.decode(bytes((255, DONT, ECHO))) == (b"", b"")  # the offer is refused
    asked = DO
    while reply := telnet.decode(bytes((255, asked, ECHO)))[1]:
        said.append(reply[1])
        asked = DONT if reply[1] == WILL else DO
    assert said[-1] == WONT
    assert 3 < said.count(WILL) < 10  # a person may change her mind


@pytest.mark.parametrize(
    ("asked", "answered"),
    [
        (b"\x00", b"\x64hil"),
        (b"\x01\x00\x00\x25\x80", b"\x65\x00\x00\x25\x80"),
        (b"\x01\x00\x00\x00\x00", b"\x65\x00\x00\x00\x00"),
        (b"\x02\x07", b"\x66\x08"),
        (b"\x03\x02", b"\x67\x01"),
        (b"\x04\x02", b"\x68\x01"),
        (b"\x05\x03", b"\x69\x01"),
        (b"\x05\x07", b"\x69\x08"),
        (b"\x05\x09", b"\x69\x09"),
        (b"\x0c\x03", b"\x70\x03"),
    ],
)
def test_requests_are_answered_with_what_is_in_force(asked, answered):
    wrap = b"\xff\xfa\x2c%b\xff\xf0"
    assert Telnet("hil").decode(wrap % asked) == (b"", wrap % answered)


@pytest.mark.parametrize("sub", [b"", b"\x2c", b"\x2c\x01\x00", b"\x63\x01", b"\x2c\x63\x01", b"\x2c" * 500])
def test_requests_that_are_none_are_not_answered(sub):
    assert Telnet("x").decode(b"\xff\xfa" + sub + b"\xff\xf0ok") == (b"ok", b"")


@given(st.binary(max_size=300), st.lists(st.integers(0, 300), max_size=5))
def test_any_bytes_in_any_pieces_mean_the_same(data, cuts):
    whole = Telnet("x").decode(data)
    telnet = Telnet("x")
    ends = [0, *sorted(min(cut, len(data)) for cut in cuts), len(data)]
    parts = [telnet.decode(data[i:j]) for i, j in pairwise(ends)]
    assert (b"".join(line for line, _ in parts), b"".join(reply for _, reply in parts)) == whole
    assert len(whole[0]) <= len(data)


@given(st.binary(max_size=300))
def test_what_is_encoded_is_decoded(data):
    telnet = Telnet("x")
    assert telnet.decode(telnet.encode(data)) == (data, b"")


def test_dtr_that_comes_on_opens_the_line() -> None:
    def script(client: serial.Serial) -> None:
        client.write(b"ab")
        client.dtr = False
        client.dtr = True
        client.write(b"c")
        client.dtr = True
        client.write(b"d")

    host = with_client(script)
    assert host.got == b"abcd"
    assert host.openings[0] == 0
    assert len(host.openings) == 2
    assert host.openings[1] <= 2  # before what is sent after it


def test_dtr_of_one_of_two_clients_opens_nothing() -> None:
    def script(client: serial.Serial) -> None:
        with serial.serial_for_url(client.portstr, 38400, timeout=10) as other:
            other.dtr = False
            other.dtr = True
            other.write(b"a")

    assert with_client(script).openings == [0]
