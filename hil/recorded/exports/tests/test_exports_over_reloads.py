"""Exports go on over a reload, with the boards that are there then."""

from dataclasses import replace
from io import BytesIO
from itertools import groupby

import pytest
from exported_bench import recorded

from hil.recorded.exports.capture_export import write_capture
from hil.recorded.exports.csv_table import csv_lines
from hil.recorded.exports.export_names import wanted_fields
from hil.recorded.exports.signal_sources import UNKNOWN, SignalCourse, signal_sources
from hil.recorded.recorded_run import RecordedRun
from hil.sim.input_log import InputLog, ReloadPlace
from hil.sim.inputs import Bytes, Logged
from hil.sim.reloads import Begun, Reloaded
from hil.testing import Bench
from hil.vocab.time import NS_PER_MS, NS_PER_S, SimTimeNs
from hil.wire.pcapng import read

CONFIG = {"bench": "t", "devices": {"m1": {"profile": "mechaduino"}, "s1": {"profile": "sac"}}}
RELOAD_NS, END_NS = SimTimeNs(3 * NS_PER_S), SimTimeNs(6 * NS_PER_S)


def log(*, begins_again: bool) -> InputLog:
    """A board that makes ten pulses before a reload and, if it is there again, ten after it."""

    def drive(bench: Bench) -> None:
        bench.run(1500)
        bench.port("s1").write(b"m5v60\r")
        bench.run(1)

    before = recorded(drive, CONFIG)
    devices = before.config["devices"]
    config = before.config if begins_again else {**before.config, "devices": {"m1": devices["m1"]}}
    begun = (Begun("s1", 7, RELOAD_NS, {}),) if begins_again else ()
    reload = Reloaded(RELOAD_NS, config, ("s1",), begun)
    after = [Logged(SimTimeNs(5 * NS_PER_S), "s1", Bytes(b"m5v60\r"))] if begins_again else []
    return replace(
        before,
        inputs=[*before.inputs, *after],
        sent=[],
        lines=[0] * (len(before.inputs) + len(after)),
        reloads=[ReloadPlace(reload, len(before.inputs), 0)],
    )


def edges(of: InputLog) -> dict[str, list[tuple[int, int]]]:
    run = RecordedRun(of)
    sources = signal_sources(run)
    names = [name for each in sources for name in each.names]
    found: dict[str, list[tuple[int, int]]] = {name: [] for name in names}
    for at_ns, name, level in SignalCourse(run, sources, names, SimTimeNs(0), END_NS).edges():
        found[name].append((at_ns, level))
    return found


def test_pins_and_lines_go_on_with_the_board_that_is_there() -> None:
    found = edges(log(begins_again=True))
    rises = [at_ns for at_ns, level in found["s1.clk"] if level == 1]
    assert [len([*of]) for _, of in groupby(rises, lambda at_ns: at_ns < RELOAD_NS)] == [10, 10]
    assert [at_ns for at_ns, _ in found["s1.rx"] if at_ns >= 5 * NS_PER_S]
    assert [at_ns for at_ns, _ in found["s1.tx"] if at_ns > 5 * NS_PER_S]


def test_pins_of_a_board_that_has_gone_are_unknown() -> None:
    found = edges(log(begins_again=False))
    assert found["s1.clk"][-1] == (RELOAD_NS, UNKNOWN)
    assert not [at_ns for at_ns, _ in found["s1.tx"] if at_ns > RELOAD_NS]


@pytest.mark.parametrize("begins_again", [True, False])
def test_a_table_has_gaps_where_there_is_no_board(begins_again: bool) -> None:
    run = RecordedRun(log(begins_again=begins_again))
    fields = wanted_fields(run, ["s1.pulses", "m1.r"])
    text = "".join(csv_lines(run, fields, SimTimeNs(2 * NS_PER_S), END_NS, 100 * NS_PER_MS))
    header, *rows = [line.split(",") for line in text.splitlines()]
    assert header == ["at_s", "s1.pulses [pulse]", "m1.r [deg]"]
    assert len(rows) == 41
    assert all(row[2] == "0" for row in rows)
    cells = {float(row[0]): row[1] for row in rows}
    assert cells[2.9] == "10"
    assert cells[6.0] == ("10" if begins_again else "")
    assert cells[4.0] == ("0" if begins_again else "")


def test_bytes_of_both_boards_are_captured() -> None:
    run, file = RecordedRun(log(begins_again=True)), BytesIO()
    write_capture(file, run, ["s1"], SimTimeNs(0), END_NS)
    sent = [(each.at_ns < RELOAD_NS, each.event) for each in read(file.getvalue())]
    assert {*sent} == {(True, 1), (True, 2), (False, 1), (False, 2)}
