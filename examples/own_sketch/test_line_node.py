"""``line_node.ino`` among SACs: a master commands all of them on one line."""

from pathlib import Path

import pytest
import yaml

from device_profiles.sac.line_nodes import NODES
from device_profiles.sac.packet import encode
from hil.master import NodeMaster, Outcome
from hil.testing import attend

NODE = 40
TAP = "bus0.master"


def line_of(folder: Path, sacs: int = 0):
    """The sketch's bench, with so many SACs more; their addresses are to be given."""
    config = yaml.safe_load((folder / "bench.yaml").read_text())
    config["devices"]["u1"]["firmware"] = str(folder / config["devices"]["u1"]["firmware"])
    names = [f"n{number}" for number in range(sacs)]
    config["devices"] |= {name: {"profile": "sac"} for name in names}
    config["segments"]["bus0"]["stations"] += names
    return config


def carried_out(b, master, *orders):
    """Let a master give its orders one after the other; what became of them."""
    given = [order(b.now_ns) for order in orders]
    attend(b, {TAP: master}, lambda: master.is_idle)
    return [each.outcome for each in given]


@pytest.fixture
def line(bench, built):
    b = bench(line_of(built("line_node")))
    b.start()
    return b


def test_it_moves_and_answers(line):
    master = NodeMaster(NODES)
    assert carried_out(line, master, lambda at: master.send(NODE, b"m400v60", at)) == [Outcome.DONE]
    line.run(ms=500)
    assert line.axis("d1").snapshot().position_deg == pytest.approx(90.9, abs=0.2)
    assert carried_out(line, master, lambda at: master.text(NODE, "where", at)) == [Outcome.DONE]
    assert master.table[NODE].text == "at 400"


def test_what_it_does_not_know_it_refuses(line):
    master = NodeMaster(NODES)
    assert carried_out(line, master, lambda at: master.send(NODE, b"m77x", at)) == [Outcome.REFUSED]
    assert line.axis("d1").snapshot().steps_taken == 0


def test_a_wrong_crc_is_refused_and_another_address_is_silence(line):
    tap = line.tap(TAP)
    frame = bytearray(encode(NODE, 1, b"m400"))
    frame[-2] ^= 0x55
    tap.write(bytes(frame))
    line.run(ms=10)
    assert tap.read() == encode(1, NODE, b"\x15")
    tap.write(encode(NODE + 1, 1, b"m400"))
    line.run(ms=10)
    assert tap.read() == b""
    assert line.axis("d1").snapshot().steps_taken == 0


def test_it_waits_two_characters_before_it_answers(line):
    tap = line.tap(TAP)
    question = encode(NODE, 1, b"vd")
    begun_ns = line.now_ns
    tap.write(question)
    line.run(ms=10)
    first_ns, _ = tap.read_timed()[0]
    characters = (first_ns - begun_ns) / 1e9 * 3840
    assert characters == pytest.approx(len(question) + 2 + 1, abs=0.5)


def test_a_node_that_lets_go_too_early_is_not_understood(bench, built):
    """Without flush() the driver goes off while the answer is still in the transmitter."""
    b = bench(line_of(built("line_node", {"Serial.flush();": ""})))
    b.start()
    master = NodeMaster(NODES)
    assert carried_out(b, master, lambda at: master.send(NODE, b"m400", at)) == [Outcome.NOT_KNOWN]
    assert b.axis("d1").snapshot().steps_taken > 0  # it has moved


@pytest.mark.long
def test_with_sixty_sacs_all_answer_and_begin_together(bench, built):
    b = bench(line_of(built("line_node"), sacs=58))
    b.start()
    sacs = [f"s{number}" for number in (1, 2)] + [f"n{number}" for number in range(58)]
    for line in (b"$CM%d\r", b"$R\r"):
        for address, name in enumerate(sacs, 100):
            b.port(name).write(line % address if b"%" in line else line)
        b.run(ms=1500)
    master = NodeMaster(NODES)
    nodes = [NODE, *range(100, 160)]
    sent = carried_out(b, master, *[lambda at, n=node: master.send(n, b"m100v60s", at) for node in nodes])
    assert sent == [Outcome.DONE] * 61
    assert carried_out(b, master, master.release) == [Outcome.SENT]
    b.run(ms=3000)
    assert b.axis("d1").snapshot().position_deg == pytest.approx(0.9 + 22.5, abs=0.2)
    assert all(b.axis(name).snapshot().position_deg == pytest.approx(180, abs=2) for name in sacs)
    assert master.garbled == 0
