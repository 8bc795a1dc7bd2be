"""Programs at ports: one table, and all that shows it."""

import re
from pathlib import Path
from typing import Any

import pytest

from hil.cli.bench.port_views import (
    as_json,
    listed_ports,
    meanings,
    program_view,
    programs_section,
    verdict_grid,
    verdict_table,
)
from hil.cli.framework.command_table import COMMANDS
from hil.compose import find_catalogue
from hil.vocab.port_programs import PORT_USES, PROGRAMS, VERDICTS, is_held, port_use

HOW_TO = Path(__file__).parents[3] / "docs/how-to"
LISTED: dict[str, Any] = {
    "bench": "t",
    "pid": 7,
    "devices": [
        {"device": "m1", "port": "pty", "address": "/run/m1", "ports": {}},
        {"device": "m2", "port": "pty", "address": "/dev/ttyACM9", "ports": {}},
        {"device": "s1", "port": "serial", "address": "/dev/ttyUSB0"}
        | {"ports": {"s1.network": {"kind": "pty", "address": "/run/s1.network", "clients": 0}}},
        {"device": "x1", "port": "carrier_pigeon", "address": "coop://1", "ports": {}},
        {"device": "d1", "port": None, "address": None, "ports": {}},
    ],
    "taps": [{"tap": "bus0.master", "kind": "tcp", "port": "socket://127.0.0.1:1", "clients": 0}],
}


def test_each_kind_of_port_has_a_row_with_each_kind_of_program() -> None:
    assert set(find_catalogue().ports) <= set(PORT_USES)
    for use in PORT_USES.values():
        assert list(use.uses) == list(PROGRAMS)


def test_what_is_missing_has_a_reason_and_a_remedy() -> None:
    for use in PORT_USES.values():
        lacking = dict(use.shortfalls())
        for name, each in use.uses.items():
            assert each.verdict in VERDICTS
            assert bool(each.why) == bool(each.help) == (name in lacking)


def test_remedies_name_what_there_is() -> None:
    helps = " ".join(each.help for use in PORT_USES.values() for each in use.uses.values())
    assert set(re.findall(r"(?:kind|port): (\w+)", helps)) <= set(PORT_USES)
    assert set(re.findall(r"hil ([a-z-]+)", f"{helps} {' '.join(VERDICTS.values())}")) <= set(COMMANDS)


@pytest.mark.parametrize(
    ("kind", "address", "row"),
    [
        ("pty", "/run/user/1000/hil/t/m1", "pty"),
        ("pty", "/dev/ttyACM9", "pty_in_dev"),
        ("pty", "/dev/ttyUSB0", "pty_in_dev"),
        ("pty", "/dev/ttyACM", "pty"),
        ("pty", "/tmp/dev/ttyACM9", "pty"),
        ("usb", "/dev/ttyACM0", "usb"),
        ("serial", "/dev/ttyUSB0", "serial"),
        ("tcp", "socket://127.0.0.1:1", "tcp"),
        (None, None, None),
        ("carrier_pigeon", "coop://1", None),
    ],
)
def test_a_row_is_found_by_kind_and_address(kind: str | None, address: str | None, row: str | None) -> None:
    assert port_use(kind, address) is (PORT_USES[row] if row else None)
    assert is_held(kind) == (kind == "serial")


def test_all_ports_of_a_bench_are_among_them() -> None:
    names = [port.name for port in listed_ports(LISTED)]
    assert names == ["m1", "m2", "s1", "s1.network", "x1", "bus0.master"]
    told = as_json(LISTED)
    assert list(told) == names
    assert told["m1"]["port lists"]["verdict"] == "no"
    assert told["m2"]["port lists"]["verdict"] == "some"
    assert told["x1"] is None


def test_lines_have_each_kind_once_with_its_reasons() -> None:
    head, titles, *lines = str(program_view(LISTED)).split("\n")
    assert head == "bench t (process 7)"
    assert " ".join(titles.split()) == "port terminals port lists DTR/RTS IDE 1.8 IDE 2 ser2net"
    assert [line.strip().split("  ")[0] for line in lines[: lines.index("")]] == [
        "pty",
        "pty /dev/ttyACM9",
        "serial",
        "tcp",
    ]
    at = lines.index("pty (m1, s1.network)")
    said = [" ".join(line.split()) for line in lines[at:]]
    assert "DTR/RTS: a pty has no modem lines. Helps: `hil with-lines PROGRAM`, or `kind: usb`" in said
    serial = lines[lines.index("serial (s1)") + 1]
    assert " ".join(serial.split()) == "At the other end: hil itself has this end open."
    assert "another kind (x1)" in lines
    assert verdict_grid([None]) is None


@pytest.mark.parametrize("columns", [40, 60])
def test_no_line_is_wider_than_the_terminal(monkeypatch: pytest.MonkeyPatch, columns: int) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", str(columns))
    assert max(map(len, program_view(LISTED).text().split("\n"))) <= columns


def test_pages_have_the_tables() -> None:
    assert f"\n{verdict_table()}\n\n{meanings()}\n" in (HOW_TO / "ports.md").read_text()
    assert f"\n{verdict_table(('IDE 1.8', 'IDE 2'))}\n" in (HOW_TO / "arduino.md").read_text()
    assert verdict_table() in programs_section()
