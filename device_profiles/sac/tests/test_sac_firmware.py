"""Behaviour that transcripts cannot show: times on the line, memory that fails, baud, bounds."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import cast

import pytest

from device_profiles.sac import firmware
from device_profiles.sac.eeprom import SIZE, Eeprom
from device_profiles.sac.parameters import Parameters
from hil.sim.twin import Twin
from hil.testing import Bench
from hil.testing.memory_store import MemoryStore

CONFIG = {"bench": "t", "devices": {"s1": {"profile": "sac", "port": "memory"}}}
CHARACTER_NS = 10 * 10**9 / 38400


class Terminal:
    """A bench with one board, past its cold start, and what somebody types at it."""

    def __init__(self) -> None:
        self.bench = Bench(CONFIG)
        self.port = self.bench.port("s1")
        self.device = self.bench.device("s1")
        self.axis = self.bench.axis("s1")
        self.run(1100)

    def run(self, ms: float) -> str:
        self.bench.run(ms=ms)
        assert self.device.failed is None
        return self.port.read().decode("latin-1")

    def say(self, *lines: str, ms: float = 100) -> str:
        """The answer to the last line."""
        answer = ""
        for line in lines:
            self.port.write(line.encode("latin-1") + b"\r")
            answer = self.run(ms)
        return answer

    def memory(self) -> dict[str, bytes]:
        """The board's memory, to be written to as from outside."""
        return cast("dict[str, bytes]", self.device.nvm)


@pytest.fixture
def sac() -> Iterator[Terminal]:
    terminal = Terminal()
    yield terminal
    terminal.bench.close()


# ---- times ----


def test_the_first_prompt_comes_a_second_after_the_version() -> None:
    bench = Bench(CONFIG)
    bench.run(ms=1500)
    (version_ns, version), (prompt_ns, prompt) = bench.port("s1").read_timed()
    assert (version, prompt) == (b"SAC 1.0\r\n", b"SAC>")
    assert (version_ns, prompt_ns) == (0, 10**9)


def test_a_listing_begins_within_2_ms_and_goes_out_at_38400_baud(sac: Terminal) -> None:
    asked_ns = sac.bench.now_ns
    sac.port.write(b"q\r")
    sac.bench.run(ms=500)
    sent = sac.port.read_timed()
    listing = b"".join(data for _, data in sent)
    assert listing.endswith(b"SAC>")
    heard_ns = asked_ns + 2 * CHARACTER_NS
    begins = [at_ns for at_ns, data in sent if b"Q\tSteps" in data]
    assert len(begins) == 1
    assert 0 <= begins[0] - heard_ns <= 2_000_000
    size = sum(len(data) for at_ns, data in sent if at_ns >= begins[0])
    last_ns, last = sent[-1]
    assert last_ns + len(last) * CHARACTER_NS == pytest.approx(begins[0] + size * CHARACTER_NS, abs=2)


def test_typing_on_during_a_listing_overruns_and_the_board_answers_on(sac: Terminal) -> None:
    sac.port.write(b"q\r" + b"v150\r" * 60)
    assert 0 < sac.run(2000).count("v150") < 60
    assert sac.say("").endswith("SAC>")
    assert sac.say("q", ms=500).count("\r\n") == 34 + 1


# ---- memory ----


def test_debug_dumps_what_is_durable(sac: Terminal) -> None:
    lines = sac.say("$CA8", "$CU21", "q5m77", "qs", "b", "$E", ms=1200).split("\r\n")
    rows = [line for line in lines if re.fullmatch(r"[0-9A-F]{4}:( [0-9A-F]{2}){16}", line)]
    assert [int(row[:4], 16) for row in rows] == list(range(0, SIZE, 16))
    data = bytes.fromhex("".join(row[5:] for row in rows))
    assert data == sac.device.nvm["eeprom"]
    eeprom = Eeprom.unpacked(data)
    assert (eeprom.parameters.autorun, eeprom.parameters.pin_map) == (8, [0, 0, 1, 0, 0, 0, 0, 0])
    assert eeprom.queue
    assert eeprom.queue[4].steps == 77


@pytest.mark.parametrize("damaged", [b"", b"\xff" * SIZE, b"\x00" * SIZE, b"SAC\x00" + bytes(1020)])
def test_a_damaged_or_foreign_eeprom_is_kept_aside_and_told(sac: Terminal, damaged: bytes) -> None:
    for number in (1, 2):
        sac.memory()["eeprom"] = damaged
        sac.device.reset()
        assert sac.run(1100).endswith("SAC>")
        assert sac.device.nvm[f"eeprom_damaged-{number}"] == damaged
        assert f"kept as eeprom_damaged-{number}" in sac.device.notes["eeprom"]
        assert Eeprom.unpacked(sac.device.nvm["eeprom"]) == Eeprom()
    sac.device.reset()
    sac.run(1100)
    assert not sac.device.notes


def test_a_flipped_bit_is_damage(sac: Terminal) -> None:
    sac.say("$CA8")
    good = sac.device.nvm["eeprom"]
    sac.memory()["eeprom"] = good[:9] + bytes([good[9] ^ 1]) + good[10:]
    sac.device.reset()
    sac.run(1100)
    assert "checksum" in sac.device.notes["eeprom"]


def test_a_change_that_cannot_be_stored_reads_back_as_before(
    sac: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    sac.say("$CL20")

    def fails(store: MemoryStore, device: Twin, sections: object, answered: object) -> bool:
        return False

    monkeypatch.setattr(MemoryStore, "commit", fails)
    sac.say("$CL30")
    assert "L slow\t\t20\r\n" in sac.say("$E")


# ---- the line's speed ----


def typed_at(sac: Terminal, baud: int, text: str = "\r", ms: float = 100) -> str:
    sac.port.write(text.encode(), client_baud=baud)
    return sac.run(ms)


def test_another_baud_holds_from_the_reset_on_and_rst_brings_38400_back(sac: Terminal) -> None:
    sac.say("$Cm9600")
    assert typed_at(sac, 38400).endswith("SAC>")
    sac.say("$R")
    assert "SAC>" not in typed_at(sac, 38400)
    typed_at(sac, 9600)
    begin_ns = sac.bench.now_ns
    sac.port.write(b"v150\r", client_baud=9600)
    sac.bench.run(ms=100)
    echo = [(at_ns, data) for at_ns, data in sac.port.read_timed() if at_ns >= begin_ns]
    assert b"".join(data for _, data in echo) == b"v150\r\nSAC>"
    assert echo[0][0] - begin_ns == pytest.approx(10**10 / 9600, abs=2)
    sac.device.pin("RST").set(0)
    sac.device.reset()
    sac.run(1200)
    assert typed_at(sac, 38400).endswith("SAC>")


@pytest.mark.parametrize(("typed", "baud"), [(0, 488), (5, 488), (4_000_000_000, 2_000_000)])
def test_a_baud_that_no_divider_makes(sac: Terminal, typed: int, baud: int) -> None:
    sac.say(f"$Cm{typed}", "$R", ms=400)
    assert typed_at(sac, baud, ms=400).endswith("SAC>")


def test_the_software_port_above_38400_is_told(sac: Terminal) -> None:
    sac.say("$Cn57600", "$R")
    assert "above 38400" in sac.device.notes["sw"]
    sac.say("$Cn38400", "$R")
    assert not sac.device.notes


def test_a_brick_is_told(sac: Terminal) -> None:
    sac.say("$CE1", "$R")
    assert "RST" in sac.device.notes["terminal"]
    assert sac.say("") == ""


# ---- the queue's bounds ----


def test_thirty_wait_and_the_next_are_dropped_whole(sac: Terminal) -> None:
    sac.say("m1v20a0d0s", *(f"m{n}" for n in range(2, 32)), ms=5)
    assert sac.axis.snapshot().pending == 30
    sac.say("m100v77")
    assert sac.axis.snapshot().pending == 30
    assert "v\t20\r\n" in sac.say("cf")
    listing = sac.say("q", ms=500)
    # 31 commands: the first has been taken out, and its place is position 1 again.
    assert "\r\n1\t31\t CW\t20\t" in listing
    assert "\r\n30\t30\t CW\t20\t" in listing
    sac.say("y", ms=40_000)
    assert sac.axis.snapshot().pulses == 2 * sum(range(1, 32))


def test_the_position_wraps_from_30_to_1(sac: Terminal) -> None:
    for n in range(1, 31):
        sac.say(f"m{n}v600a0d0", ms=n + 10)
    assert "Q is at 1\t" in sac.say("q", ms=500)


def test_a_queue_edit_during_its_run_acts_next_time(sac: Terminal) -> None:
    sac.say("q1m100v60a0d0", "q2m100v60a0d0", "ls1", "lf2", "q1m-1v60", "q2m-1v60", ms=10)
    sac.say("", ms=440)
    assert sac.axis.snapshot().pulses > 150
    sac.say("S", ms=1)


def test_custom_pins_reach_the_driver(sac: Terminal) -> None:
    """Exponent 4 on pins LLH: an A4988 makes half steps of it, the engine still counts 16 pulses a step."""
    sac.say("$CN2", "$CU41", "$CJ4", "$R", "m10v60a0d0", ms=200)
    state = sac.axis.snapshot()
    assert state.pulses == 160
    assert state.commanded_deg == pytest.approx(160 * 0.9)


# ---- the documents ----


def test_each_decision_of_the_readme_names_a_place_in_the_code() -> None:
    folder = Path(firmware.__file__).parent
    text = (folder / "README.md").read_text()
    rows = re.findall(r"^\| [^|]+ \| `([\w/]+\.(?:py|c|h))`: `(\w+)` \|$", text, re.M)
    assert len(rows) >= 20
    for file, name in rows:
        path = folder / file if file.endswith(".py") else folder.parent.parent / "hil/core/native" / file
        assert re.search(rf"\b{name}\b", path.read_text()), f"{file}: {name}"


def test_every_parameter_of_the_screen_is_one_of_the_memory() -> None:
    from device_profiles.sac.parameters import BY_LETTER

    fields = {parameter.field for parameter in BY_LETTER.values()}
    assert fields == set(vars(Parameters())) - {"is_pulses", "pin_map"}


# ---- the encoder ----


def turn(sac: Terminal, cycles: int, first: str, levels: dict[str, int]) -> None:
    """Whole quadrature cycles from these levels on, a millisecond an edge; ``first``: the pin that leads."""
    second = "EnB" if first == "EnA" else "EnA"
    for name in (first, second) * 2 * cycles:
        levels[name] ^= 1
        sac.device.pin(name, levels[name])
        sac.run(1)


@pytest.mark.parametrize("first", ["EnA", "EnB"])
@pytest.mark.parametrize("ena", [0, 1])
@pytest.mark.parametrize("enb", [0, 1])
@pytest.mark.parametrize("at_power_up", ["before", "after"])
def test_each_cycle_of_the_encoder_is_a_pulse_wherever_it_rested_at_power_up(
    sac: Terminal, ena: int, enb: int, first: str, at_power_up: str
) -> None:
    """Pins that are driven while the board has no power, or in the second of its cold start."""
    sac.device.pin("EnB", 1)  # a quarter of a cycle that the reset forgets
    if at_power_up == "after":
        sac.device.reset()
        sac.run(500)
    levels = {"EnA": ena, "EnB": enb}
    for name, level in levels.items():
        sac.device.pin(name, level)
    if at_power_up == "before":
        sac.device.reset()
    sac.run(1100)
    before = sac.axis.snapshot().pulses
    # Each way of starting a cycle from these levels: which pin leads makes the direction.
    leads = 1 if (first == "EnA") == (ena == enb) else -1
    for cycles in range(1, 11):
        turn(sac, 1, first, levels)
        assert sac.axis.snapshot().pulses - before == leads * cycles


# ---- Estop ----


def test_the_operator_is_told_while_estop_is_low(sac: Terminal) -> None:
    for _ in range(2):
        sac.device.pin("Estop", 0)
        assert sac.device.notes["Estop"].startswith("Estop is low")
        sac.device.pin("Estop", 0)
        sac.say("$R", ms=300)
        assert "Estop" in sac.device.notes
        sac.device.pin("Estop", 1)
        assert "Estop" not in sac.device.notes


def test_an_estop_that_is_low_at_power_up_is_told_too(sac: Terminal) -> None:
    sac.device.pin("Estop", 0)
    sac.device.reset()
    sac.run(1100)
    assert "Estop" in sac.device.notes
    sac.device.reset()
    sac.device.pin("Estop", 1)
    sac.run(1100)
    assert "Estop" not in sac.device.notes


def test_estop_acts_when_it_falls_and_holds_nothing(sac: Terminal) -> None:
    sac.say("m300v150ad", "m400v150ad")
    sac.device.pin("Estop", 0)
    stopped_at = sac.axis.snapshot().pulses
    sac.run(3000)
    assert 0 < sac.axis.snapshot().pulses == stopped_at  # the second is dropped with the first
    sac.say("m100v150ad", ms=3000)
    assert sac.axis.snapshot().pulses == stopped_at + 200
    sac.say("m", ms=1000)
    sac.device.pin("Estop", 1)
    assert sac.axis.snapshot().speed_rpm > 0  # nor does it act when it rises
