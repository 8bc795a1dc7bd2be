"""Axes as Modbus nodes on a segment: requests in simulated time, what they do, and what they answer."""

import struct

import pytest
from modbus_line import DEVICES, M1, MASTER, Line, config, f32

from bridges.modbus.protocol import client_side as client
from bridges.modbus.protocol.frame import Frame, encode
from bridges.modbus.protocol.identification import ReadDeviceId
from bridges.modbus.protocol.pdu import Code, Refused, Table
from bridges.modbus.registers import layout
from bridges.modbus.registers.map_parts import USUAL
from hil.core.fields import OFFSETS
from hil.testing import Bench
from hil.wire.serial_line import character_ns, silence_ns

HOLDING, INPUT, COILS, BITS = (
    Table.HOLDING_REGISTERS,
    Table.INPUT_REGISTERS,
    Table.COILS,
    Table.DISCRETE_INPUTS,
)
MOVE_ABS = 8
"""Number of a Mechaduino's verb."""
TO_90 = client.write(HOLDING, layout.COMMAND_AT, (MOVE_ABS + 1, *f32(90.0)))
ENABLE = client.write_single(HOLDING, layout.CONTROL_AT, 1)
MS = 1_000_000


@pytest.fixture
def line():
    with Bench(config()) as bench:
        yield Line(bench)


def bits(line: Line, unit: int, address: int, ms: float = 60) -> tuple[int, ...]:
    return line.ask(unit, client.read(BITS, address), ms).values


@pytest.mark.parametrize(
    ("baud", "form", "size"), [(19200, "8E1", 11), (9600, "8N1", 10), (115200, "8N2", 11)]
)
def test_an_answer_begins_at_its_nanosecond(baud: int, form: str, size: int) -> None:
    with Bench(config({"m1": M1}, baud=baud, format=form, modbus={"units": {"m1": 17}})) as bench:
        line = Line(bench)
        began_ns = bench.now_ns
        line.ask(17, client.read(INPUT, 0, 2))
    (asked, answered) = line.wire
    assert (asked.at_ns, asked.who, answered.who) == (began_ns, MASTER, "m1.modbus")
    end_ns = began_ns + character_ns(8, baud, size)
    assert answered.at_ns == end_ns + silence_ns(baud, size) + MS, "one millisecond by default"


def test_the_answers_of_two_nodes_with_one_number_collide() -> None:
    """One shaft stands at 0, the other at 90 deg."""
    x1, x2 = ({"profile": "modbus_drive", "axis": {"start_deg": at_deg}} for at_deg in (0.0, 90.0))
    both = {"units": {"x1": 1, "x2": 1}, "duplicate_units": True}
    with Bench(config({"x1": x1, "x2": x2}, modbus=both)) as bench:
        line = Line(bench, boot_ms=500)
        raw = line.send(encode(1, 4, client.encode(client.read(INPUT, 0, 2))[1:]))
        assert Frame(0, raw).fault == "CRC"
        assert bench.segment("bus0").counters(bench.now_ns)["collisions"] == 1


def test_the_moment_of_a_read_is_the_end_of_its_request(line: Line) -> None:
    began_ns = line.bench.now_ns
    words = line.ask(1, client.read(INPUT, 16, 4)).values
    said_ns = int.from_bytes(b"".join(word.to_bytes(2, "big") for word in words), "big")
    assert said_ns == began_ns + character_ns(8, 19200, 11) + silence_ns(19200, 11)


def test_a_move_by_registers_is_done_when_its_motion_has_ended(line: Line) -> None:
    line.ask(1, ENABLE)
    line.ask(1, TO_90)
    assert bits(line, 1, layout.DONE_AT + MOVE_ABS) == (0,)
    assert line.ask(1, client.read(COILS, MOVE_ABS)).values == (1,), "under way"
    line.bench.run(ms=1000)
    assert bits(line, 1, layout.DONE_AT + MOVE_ABS) == (1,)
    assert line.bench.axis("m1").snapshot().yw == pytest.approx(90.0, abs=0.5)


def test_a_motion_that_another_cuts_short_is_refused_not_done(line: Line) -> None:
    line.bench.run(ms=1000)
    move = list(line.bench._runtime.devices["s1"].verbs).index("move_abs")
    line.ask(2, client.write(HOLDING, layout.COMMAND_AT, (move + 1, *f32(360.0))))
    line.bench.axis("s1").do("stop", how="prejudice")
    line.bench.run(ms=100)
    assert bits(line, 2, layout.DONE_AT + move) == (0,)
    assert bits(line, 2, layout.REFUSED_AT + move) == (1,)


def test_a_done_bit_stays_what_it_was_when_another_moves_the_axis_later(line: Line) -> None:
    line.ask(1, ENABLE)
    line.ask(1, TO_90)
    line.bench.run(ms=1000)
    line.bench.axis("m1").do("move_abs", position_deg=0.0)
    line.bench.run(ms=1000)
    assert bits(line, 1, layout.DONE_AT + MOVE_ABS) == (1,)
    assert bits(line, 1, layout.REFUSED_AT + MOVE_ABS) == (0,)


@pytest.mark.parametrize(
    ("request_", "code"),
    [
        (client.read(HOLDING, 5000, 1), Code.ILLEGAL_DATA_ADDRESS),
        (client.write_single(HOLDING, layout.CONTROL_AT, 3), Code.ILLEGAL_DATA_VALUE),
        (client.write(HOLDING, layout.COMMAND_AT, (MOVE_ABS + 1, *f32(2e6))), Code.ILLEGAL_DATA_VALUE),
        (TO_90, Code.SERVER_DEVICE_BUSY),
        (client.ask_identification(ReadDeviceId.INDIVIDUAL, 77), Code.ILLEGAL_DATA_ADDRESS),
        (client.diagnose(99), Code.ILLEGAL_FUNCTION),
    ],
)
def test_a_refusal_is_an_exception(line: Line, request_: client.Request, code: Code) -> None:
    with pytest.raises(Refused) as caught:
        line.ask(1, request_)
    assert caught.value.code == code


def test_functions_that_nobody_knows_and_wrong_lengths_are_exceptions(line: Line) -> None:
    assert line.send(encode(1, 99)) == encode(1, 99 | 0x80, b"\1")
    assert line.send(encode(1, 3, b"\0\0\0")) == encode(1, 0x83, b"\3")
    node = line.bench._runtime.cards["m1.modbus"]
    assert node.counters()["exceptions"] == 2
    assert node.counters()["refusal"].startswith("03: ")


def f64(value: float) -> tuple[int, ...]:
    return struct.unpack(">4H", struct.pack(">d", value))


def test_a_load_has_its_bound_here_too_and_a_zero_is_a_write(line: Line) -> None:
    load_at, angle_at = (layout.FIELDS_AT + OFFSETS[name] // 2 for name in ("load_torque_Nm", "position_deg"))
    axis = line.bench.axis("m1")
    line.ask(1, client.write(HOLDING, load_at, f64(4.95)))
    assert axis.load_torque_Nm == 4.95
    for wrong_Nm in (4.96, -99.0, float("nan"), float("inf")):
        with pytest.raises(Refused) as refused:
            line.ask(1, client.write(HOLDING, load_at, f64(wrong_Nm)))
        assert refused.value.code == Code.ILLEGAL_DATA_VALUE
    line.ask(1, client.write(HOLDING, load_at, f64(0.0)))
    line.bench.run(ms=200)
    assert axis.snapshot().position_deg > 720
    line.ask(1, client.write(HOLDING, angle_at, f64(0.0)))
    assert axis.snapshot().position_deg == pytest.approx(0, abs=1e-6)


def test_every_function_is_there(line: Line) -> None:
    line.ask(1, client.write_single(COILS, layout.INPUTS_AT, 1))
    assert line.ask(1, client.read(COILS, layout.INPUTS_AT)).values == (1,)
    line.ask(1, client.write(COILS, layout.INPUTS_AT, (0, 0)))
    first = layout.PARAMETERS_AT + layout.PER_VERB * MOVE_ABS
    line.ask(1, client.write(HOLDING, first, f32(12.5)))
    assert line.ask(1, client.read(HOLDING, first, 2)).values == f32(12.5)
    line.ask(1, client.mask_write(first, 0xFF00, 0x0011))
    assert line.ask(1, client.read(HOLDING, first)).values == (f32(12.5)[0] & 0xFF00 | 0x11,)
    both = client.read_write(first, 2, first, f32(-3.0))
    assert line.ask(1, both).values == f32(-3.0)
    assert line.ask(1, client.ask_report()).data == b"\1\xffmechaduino"
    said = line.ask(2, client.ask_identification(ReadDeviceId.REGULAR)).identification
    assert said
    assert said.objects[6] == b"t/s1"


def test_a_broadcast_is_carried_out_by_all_and_answered_by_none() -> None:
    with Bench(config({"m1": M1, "m2": M1})) as bench:
        line = Line(bench)
        assert line.send(encode(0, 6, b"\0\0\0\1")) == b""
        assert [bench.axis(name).snapshot().loop_on for name in ("m1", "m2")] == [1, 1]
        assert line.send(encode(0, 3, b"\0\0\0\1")) == b"", "a read of all is nothing"
        assert [each.who for each in line.wire] == [MASTER, MASTER]


def test_in_listen_only_mode_it_does_nothing_until_a_restart(line: Line) -> None:
    assert line.send(encode(1, 8, b"\0\4\0\0")) == b""
    assert line.send(encode(1, 6, b"\0\0\0\1")) == b""
    assert line.bench.axis("m1").snapshot().loop_on == 0
    assert line.ask(2, client.read(INPUT, 0)).values == (layout.VERSION,), "the other is not concerned"
    assert line.send(encode(1, 8, b"\0\1\0\0")) == b""
    line.ask(1, ENABLE)


def test_counters_of_the_line_know_frames_for_others_too(line: Line) -> None:
    line.ask(2, client.read(INPUT, 0))
    line.send(encode(1, 4, b"\0\0\0\1")[:-1] + b"\0")
    line.ask(1, client.read(INPUT, 0))
    count = {
        name: int.from_bytes(line.ask(1, client.diagnose(name)).data, "big") for name in (11, 12, 14, 13)
    }
    # Two frames of node 2's exchange, the request, and three requests for counters up to each.
    assert count == {11: 4, 12: 1, 14: 4, 13: 0}
    line.ask(1, client.diagnose(10))
    assert line.ask(1, client.diagnose(11)).data == b"\0\1"


def test_only_the_node_that_is_asked_is_told() -> None:
    names = [f"m{at}" for at in range(1, 9)]
    with Bench(config(dict.fromkeys(names, M1))) as bench:
        line = Line(bench)
        told: list[str] = []
        for name, node in bench._runtime.cards.items():
            hear = node.hear
            node.hear = lambda *a, name=name, hear=hear: (told.append(name), hear(*a))  # type: ignore[method-assign]
        line.ask(5, client.read(INPUT, 0))
    assert told == ["m5.modbus"]


def test_without_power_it_is_silent_and_with_it_it_starts_anew(line: Line) -> None:
    first = layout.PARAMETERS_AT + layout.PER_VERB * MOVE_ABS
    line.ask(1, client.write(HOLDING, first, f32(12.5)))
    with line.bench.fault("node_brown_out", "m1"):
        assert line.send(encode(1, 4, b"\0\0\0\1")) == b""
    assert line.ask(1, client.read(HOLDING, first, 2)).values != f32(12.5)


def test_a_reset_by_its_coil_is_answered(line: Line) -> None:
    line.ask(1, ENABLE)
    line.ask(1, client.write_single(COILS, layout.RESET_AT, 1))
    assert line.bench.axis("m1").snapshot().loop_on == 0


def test_a_board_that_has_stopped_still_tells_so(line: Line) -> None:
    line.bench._runtime.devices["m1"].power.fail("it is a test")
    status, fault = line.ask(1, client.read(INPUT, 1, 2)).values
    assert (status >> 4 & 1, fault) == (1, 1)
    with pytest.raises(Refused) as caught:
        line.ask(1, ENABLE)
    assert caught.value.code == Code.SERVER_DEVICE_FAILURE


def test_registers_that_raise_stop_their_board_alone() -> None:
    class Broken:
        manners = USUAL
        looks_before_writes = False

        def needs_look(self, span: object) -> bool:
            return False

        def read(self, *of: object) -> bool:
            raise ZeroDivisionError("by zero")

    with Bench(config({"m1": M1, "m2": M1})) as bench:
        line = Line(bench)
        node = bench._runtime.cards["m1.modbus"]
        node._server._registers = Broken()  # type: ignore[assignment]
        assert line.send(encode(1, 4, b"\0\0\0\1")) == b""
        failed = bench.device("m1").failed
        assert failed
        assert failed.startswith("its Modbus node: ZeroDivisionError: by zero (test_kit_modbus_nodes.py:")
        assert line.ask(2, client.read(INPUT, 0)).values == (layout.VERSION,)
        bench.device("m1").reset()
        assert line.ask(1, client.read(INPUT, 0)).values == (layout.VERSION,)


def test_several_axes_of_a_board_and_several_segments() -> None:
    wires = {
        "bus0": {"modbus": {"units": {"m1": 1}}, "taps": {"master": {}}},
        "bus1": {"modbus": {"units": {"s1": 1}, "word_order": "low_first"}, "taps": {"master": {}}},
    }
    with Bench({"bench": "t", "devices": DEVICES, "segments": wires}) as bench:
        bench.run(ms=4000)
        masters = [bench.tap(f"{name}.master") for name in wires]
        for master in masters:
            master.write(encode(1, 17))
        bench.run(ms=50)
        assert [master.read()[5:-2] for master in masters] == [b"mechaduino", b"sac"]
        masters[1].write(encode(1, 4, b"\0\4\0\2"))
        bench.run(ms=50)
        low_first = masters[1].read()[3:-2]
        crc = bench._runtime.cards["s1.modbus"]._of.make_registers().map.crc  # type: ignore[attr-defined]
        assert int.from_bytes(low_first[2:] + low_first[:2], "big") == crc


def test_a_frame_in_pieces_and_two_too_close() -> None:
    with Bench(config({"m1": M1})) as bench:
        line = Line(bench)
        ask = encode(1, 17)
        line.master.write(ask[:2])
        bench.run(ms=3 * 11 / 19.2)  # the second piece comes half a character after the first
        assert line.send(ask[2:]) == encode(1, 17, b"\x0c\1\xffmechaduino")
        line.master.write(ask[:2])
        bench.run(ms=4 * 11 / 19.2)  # two characters of silence, more than 1.5
        assert line.send(ask[2:]) == b""
        assert line.send(ask + ask) == b"", "two frames without silence are none"
        assert line.send(ask) != b""


def test_a_master_at_another_speed_is_not_understood(line: Line) -> None:
    from hil.sim.inputs import Bytes

    runtime = line.bench._runtime
    for baud in (9600, 38400):
        runtime.apply_to(runtime.taps[MASTER], Bytes(encode(1, 17), baud))
        line.bench.run(ms=100)
    assert line.master.read() == b""
    assert line.send(encode(1, 17)) != b""
