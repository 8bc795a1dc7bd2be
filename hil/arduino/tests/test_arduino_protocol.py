"""The dialogues with the Arduino IDE, message by message, as the specifications have them."""

from collections.abc import Callable

import pytest

from hil.arduino.protocol import BAUDS, Discovery, Message, Monitor, board_port, board_port_1_8

HELLO = 'HELLO 1 "arduino-cli 1.2.3"'
HELLO_ANSWER = [{"eventType": "hello", "protocolVersion": 1, "message": "OK"}]
QUIT_ANSWER = [{"eventType": "quit", "message": "OK"}]
M1 = board_port("/run/hil/lab/m1", "lab", "m1", profile="mechaduino")
M2 = board_port("socket://127.0.0.1:7001", "lab", "m2", profile="mechaduino")
M1_MESSAGE = {
    "address": "/run/hil/lab/m1",
    "label": "lab/m1",
    "protocol": "hil",
    "protocolLabel": "Virtual board (hil)",
    "hardwareId": "hil/lab/m1",
    "properties": {"bench": "lab", "device": "m1", "profile": "mechaduino"},
}
NOT_COMMANDS = ("", " ", "NONSENSE", "hello", "LISTS", '{"eventType": "hello"}', '{"HELLO": ', "\x00\ufffd")


def error(event: str, answers: list[Message]) -> str:
    """The reason of an answer that is an error of this event, and nothing else."""
    (answer,) = answers
    assert set(answer) == {"eventType", "error", "message"}
    assert (answer["eventType"], answer["error"]) == (event, True)
    assert answer["message"]
    return str(answer["message"])


class Ports(list[Message]):
    """Ports that a discovery finds; ``broken`` makes it fail."""

    broken = False

    def find(self) -> list[Message]:
        if self.broken:
            raise OSError("Resource busy")
        return list(self)


def discovery(*ports: Message, after: tuple[str, ...] = (HELLO,)) -> tuple[Discovery, Ports]:
    found = Ports(ports)
    made = Discovery(found.find)
    for line in after:
        assert "error" not in made.command(line)[0]
    return made, found


class Link:
    """A ``MonitorLink`` that writes down what it is told, and refuses when it shall."""

    def __init__(self) -> None:
        self.done: list[object] = []
        self.refusal = ""

    def _do(self, *what: object) -> None:
        if self.refusal:
            raise OSError(self.refusal)
        self.done.append(what)

    def open(self, client: tuple[str, int], address: str, baud: int) -> None:
        self._do("open", client, address, baud)

    def set_baud(self, baud: int) -> None:
        self._do("baud", baud)

    def close(self) -> None:
        self._do("close")


def monitor(*after: str) -> tuple[Monitor, Link]:
    link = Link()
    made = Monitor(link)
    for line in (HELLO, *after):
        assert "error" not in made.command(line)[0]
    return made, link


Make = Callable[[], Discovery | Monitor]


@pytest.mark.parametrize(
    "make", [lambda: Discovery(list), lambda: Monitor(Link())], ids=["discovery", "monitor"]
)
class TestBoth:
    @pytest.mark.parametrize("agent", ["Arduino IDE 1.8.13", "arduino-cli 1.2.3", "x"])
    def test_hello(self, make: Make, agent: str) -> None:
        assert make().command(f'HELLO 1 "{agent}"\r') == HELLO_ANSWER

    def test_a_newer_client_is_told_the_version_that_exists(self, make: Make) -> None:
        assert make().command('HELLO 7 "arduino-cli 9"') == HELLO_ANSWER

    @pytest.mark.parametrize("rest", ["", "1", "1 x", '"x"', 'one "x"', '1 ""', '1 "a"b"', '1 "x" 2'])
    def test_a_malformed_hello_is_none(self, make: Make, rest: str) -> None:
        tool = make()
        assert error("command_error", tool.command(f"HELLO {rest}".strip()))
        assert tool.command(HELLO) == HELLO_ANSWER

    def test_hello_comes_once(self, make: Make) -> None:
        tool = make()
        tool.command(HELLO)
        assert error("hello", tool.command(HELLO))

    def test_nothing_comes_before_hello(self, make: Make) -> None:
        tool = make()
        lines = ["START", "STOP", "LIST", "START_SYNC"]
        if isinstance(tool, Monitor):
            lines = ["DESCRIBE", "CONFIGURE baudrate 9600", "OPEN 127.0.0.1:9 /x", "CLOSE"]
        for line in lines:
            assert "HELLO must come before" in error("command_error", tool.command(line))
        assert tool.command(HELLO) == HELLO_ANSWER

    def test_quit_works_always_and_ends_it(self, make: Make) -> None:
        for before in ((), (HELLO,), (HELLO, "START"), (HELLO, "START_SYNC"), (HELLO, "OPEN 127.0.0.1:9 /x")):
            tool = make()
            for line in before:
                tool.command(line)
            assert tool.command("QUIT") == QUIT_ANSWER
            assert tool.dead
            assert tool.command(HELLO) == []

    @pytest.mark.parametrize("line", NOT_COMMANDS)
    def test_what_is_no_command(self, make: Make, line: str) -> None:
        for before in ((), (HELLO,)):
            tool = make()
            for each in before:
                tool.command(each)
            assert (
                error("command_error", tool.command(line)) == f"Unknown command {line.strip().split(' ')[0]}"
            )


def test_start_list_stop() -> None:
    tool, found = discovery(M1)
    assert tool.command("START") == [{"eventType": "start", "message": "OK"}]
    assert tool.command("LIST") == [{"eventType": "list", "ports": [M1_MESSAGE]}]
    found.clear()
    assert tool.command("LIST") == [{"eventType": "list", "ports": []}]
    assert tool.command("STOP") == [{"eventType": "stop", "message": "OK"}]
    assert tool.command("START") == [{"eventType": "start", "message": "OK"}]


def test_start_sync_tells_what_there_is_and_what_changes() -> None:
    tool, _ = discovery(M1, M2)
    answers = tool.command("START_SYNC")
    assert answers[0] == {"eventType": "start_sync", "message": "OK"}
    assert answers[1] == {"eventType": "add", "port": M1_MESSAGE}
    assert [answer["eventType"] for answer in answers[1:]] == ["add", "add"]
    assert tool.found([M1, M2]) == []
    gone = {"address": M2["address"], "protocol": "hil"}
    assert tool.found([M1]) == [{"eventType": "remove", "port": gone}]
    assert [a["port"]["address"] for a in tool.found([M2])] == [M1["address"], M2["address"]]
    # A description that changes replaces the one before, without a remove.
    renamed = board_port(M2["address"], "lab", "other")
    assert tool.found([renamed]) == [{"eventType": "add", "port": renamed}]


def test_the_ide_1_8_says_no_hello() -> None:
    ports = Ports([board_port_1_8(M1)])
    tool = Discovery(ports.find, greets=False)
    named = M1_MESSAGE | {"identificationPrefs": {".": "hil:virtual:mechaduino"}}
    assert tool.command("START_SYNC")[1:] == [{"eventType": "add", "port": named}]
    assert tool.syncing
    ports.clear()
    gone = {"address": M1["address"], "protocol": "hil"}
    assert tool.found(ports) == [{"eventType": "remove", "port": gone}]
    assert tool.command("STOP") == [{"eventType": "stop", "message": "OK"}]
    assert not tool.syncing


def test_a_stop_forgets_what_the_client_knew() -> None:
    tool, _ = discovery(M1, after=(HELLO, "START_SYNC", "STOP"))
    assert tool.found([M1, M2]) == []
    assert [answer["eventType"] for answer in tool.command("START_SYNC")] == ["start_sync", "add"]


def test_a_discovery_that_is_not_asked_says_nothing() -> None:
    for after in ((HELLO,), (HELLO, "START"), (HELLO, "START_SYNC", "QUIT")):
        tool, _ = discovery(after=after)
        assert tool.found([M1]) == []


@pytest.mark.parametrize(
    ("after", "line", "event"),
    [
        ((), "STOP", "stop"),
        ((), "LIST", "list"),
        (("START",), "START", "start"),
        (("START_SYNC",), "START", "start"),
        (("START_SYNC",), "LIST", "list"),
        (("START_SYNC",), "START_SYNC", "start_sync"),
        (("START", "STOP"), "LIST", "list"),
        (("START", "STOP"), "STOP", "stop"),
    ],
)
def test_discovery_commands_out_of_order(after: tuple[str, ...], line: str, event: str) -> None:
    tool, _ = discovery(M1, after=(HELLO, *after))
    before = tool.syncing
    assert error(event, tool.command(line))
    assert tool.syncing == before


def test_start_sync_after_start_is_what_older_editions_ask_for() -> None:
    tool, _ = discovery(M1, after=(HELLO, "START"))
    assert [answer["eventType"] for answer in tool.command("START_SYNC")] == ["start_sync", "add"]


def test_a_search_that_fails_is_said() -> None:
    tool, found = discovery(M1, after=(HELLO, "START"))
    found.broken = True
    assert error("list", tool.command("LIST")) == "Resource busy"
    tool.command("STOP")
    assert error("start_sync", tool.command("START_SYNC")) == "Resource busy"
    found.broken = False
    assert tool.command("START_SYNC")[0] == {"eventType": "start_sync", "message": "OK"}


def test_describe_and_configure() -> None:
    tool, link = monitor()
    values = [str(baud) for baud in BAUDS]
    (answer,) = tool.command("DESCRIBE")
    parameter = answer["port_description"]["configuration_parameters"].pop("baudrate")
    assert answer == {
        "eventType": "describe",
        "message": "OK",
        "port_description": {"protocol": "hil", "configuration_parameters": {}},
    }
    assert parameter == {
        "label": "Baudrate",
        "type": "enum",
        "values": values,
        "value": values,
        "selected": "115200",
    }
    assert tool.command("CONFIGURE baudrate 9600") == [{"eventType": "configure", "message": "OK"}]
    described = tool.command("DESCRIBE")[0]["port_description"]["configuration_parameters"]["baudrate"]
    assert described["selected"] == "9600"
    assert link.done == []


def test_a_wrong_configuration_changes_nothing() -> None:
    tool, link = monitor()
    before = tool.command("DESCRIBE")
    said = error("configure", tool.command("CONFIGURE baudrate 123456"))
    assert said == "invalid value for parameter baudrate: 123456"
    assert error("configure", tool.command("CONFIGURE baudrate 9600 8N1"))
    assert "parity" in error("configure", tool.command("CONFIGURE parity N"))
    for line in ("CONFIGURE", "CONFIGURE baudrate"):
        assert error("command_error", tool.command(line))
    tool.command("OPEN 127.0.0.1:1 /x")
    link.refusal = "the port has no baud"
    assert error("configure", tool.command("CONFIGURE baudrate 9600")) == "the port has no baud"
    assert tool.command("DESCRIBE") == before


def test_open_configure_close() -> None:
    tool, link = monitor("CONFIGURE baudrate 38400")
    assert tool.command("OPEN 127.0.0.1:32123 /run/hil/lab/m1") == [{"eventType": "open", "message": "OK"}]
    assert tool.command("CONFIGURE baudrate 19200") == [{"eventType": "configure", "message": "OK"}]
    assert tool.command("CLOSE") == [{"eventType": "close", "message": "OK"}]
    assert link.done == [
        ("open", ("127.0.0.1", 32123), "/run/hil/lab/m1", 38400),
        ("baud", 19200),
        ("close",),
    ]
    assert tool.command("OPEN [::1]:7 socket://127.0.0.1:7001") == [{"eventType": "open", "message": "OK"}]
    assert link.done[-1] == ("open", ("::1", 7), "socket://127.0.0.1:7001", 19200)
    assert tool.command("QUIT") == QUIT_ANSWER
    assert link.done[-1] == ("close",)


def test_an_address_may_have_spaces() -> None:
    tool, link = monitor()
    tool.command("OPEN 127.0.0.1:1 /home/a b/m1")
    assert link.done == [("open", ("127.0.0.1", 1), "/home/a b/m1", 115200)]


def test_open_and_close_out_of_order() -> None:
    tool, link = monitor()
    assert error("close", tool.command("CLOSE")) == "port already closed"
    link.refusal = "unknown port /dev/ttyACM23"
    assert error("open", tool.command("OPEN 127.0.0.1:1 /dev/ttyACM23")) == "unknown port /dev/ttyACM23"
    link.refusal = ""
    assert error("close", tool.command("CLOSE"))
    tool.command("OPEN 127.0.0.1:1 /x")
    assert error("open", tool.command("OPEN 127.0.0.1:1 /y"))
    assert link.done == [("open", ("127.0.0.1", 1), "/x", 115200)]
    for line in ("OPEN", "OPEN 127.0.0.1:1", "OPEN 127.0.0.1 /x", "OPEN 127.0.0.1:port /x", "OPEN :1 /x"):
        assert error("command_error", tool.command(line))


def test_a_port_that_goes_by_itself() -> None:
    tool, link = monitor("OPEN 127.0.0.1:1 /x")
    gone = [{"eventType": "port_closed", "message": "serial port disappeared!"}]
    assert tool.lost("serial port disappeared!") == gone
    assert link.done[-1] == ("close",)
    assert tool.lost("again") == []
    assert error("close", tool.command("CLOSE")) == "port already closed"
    assert tool.command("OPEN 127.0.0.1:1 /x") == [{"eventType": "open", "message": "OK"}]
