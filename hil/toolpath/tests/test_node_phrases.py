"""Paths carried out by SACs on a segment, and compared pulse by pulse with what was asked for."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import pytest
from line_rig import LineRig
from small_mill import LINEAR, mill, motions_of, planned

from device_profiles.sac.path_planner import PATHS
from hil.toolpath.deviation import asked_path, deviation
from hil.toolpath.line_load import can_be_sent
from hil.toolpath.machine import machine_from_data
from hil.toolpath.node_phrases import NodePhrases
from hil.toolpath.stream_phrase import StreamPhrase

EXAMPLES = Path(__file__).parents[3] / "examples" / "gcode"


class Named(NamedTuple):
    """Phrase whose axes are called as the devices."""

    commands: object


def follow(text, machine, at_us=lambda phrases, phrase, at_us: None):
    """Positions after each pulse, and the phrases. ``at_us`` is called while a phrase runs."""
    rig = LineRig(tuple(axis.stepper.microstep_exponent for axis in machine.axes))
    devices = {axis.letter: f"s{number}" for number, axis in enumerate(machine.axes)}
    maker = NodePhrases(machine, PATHS)
    done, phrases = [], []
    for phrase in maker.of(planned(text, machine)):
        if not hasattr(phrase, "commands"):
            continue
        commands = (replace(each, axis=devices[each.axis]) for each, _ in phrase.commands)
        done.append(rig.perform(Named(commands), phrase.ahead, partial(at_us, maker, phrase)))
        assert max(each.end_us for each in done[-1]) == pytest.approx(phrase.duration_s * 1e6, abs=200_000)
        phrases.append(phrase)
    assert rig.late == 0
    at = {axis.letter: 0 for axis in machine.axes}
    unit = {axis.letter: axis.pulses_per_unit for axis in machine.axes}
    places = [tuple(at[letter] / unit[letter] for letter in at)]
    for commands, phrase, pulses in zip(done, phrases, rig.pulses(), strict=True):
        assert at == phrase.begin
        events = []
        for letter, device in devices.items():
            signs = [
                s for c in commands if c.axis == device for s in [(c.pulses > 0) * 2 - 1] * abs(c.pulses)
            ]
            events += zip(pulses[device], [letter] * len(signs), signs, strict=True)
        for _, letter, sign in sorted(events):
            at[letter] += sign
            places.append(tuple(at[each] / unit[each] for each in at))
        assert at == phrase.end
    assert {letter: rig.bench.axis(device).snapshot().pulses for letter, device in devices.items()} == at
    return places, phrases


def off(text, machine):
    places, _ = follow(text, machine)
    return deviation(asked_path(motions_of(text), machine), places)


@pytest.mark.thorough
@pytest.mark.long
def test_a_circle_of_50_mm_at_1200_mm_per_min():
    found = off("G21 G90\nG0 X50\nG3 I-50 F1200", mill("xy", tolerance_mm=0.05))
    assert 0.002 < found.largest <= 0.05 / 2
    assert found.rest <= 0.01


def test_corners_and_arcs_within_the_tolerance():
    text = "G21 G90 F1200\nG1 X9\nY9.5\nG2 X12 Y9.5 I1.5\nG1 X0 Y0\nX3.333 Y1.777 Z2"
    found = off(text, mill(tolerance_mm=0.05))
    assert 0.002 < found.largest <= 0.05
    assert found.rest <= 0.01


def test_each_way_of_a_tiny_engraving():
    text = "G21 G90 F600\nG0 Z1\nX2 Y2\nG1 Z-0.1\n" + "\n".join(
        f"X{2 + n * 0.07:.2f} Y{2 + n % 3 * 0.05:.2f}" for n in range(40)
    )
    found = off(text + "\nG0 Z1\nX0 Y0", mill(tolerance_mm=0.05))
    assert found.largest <= 0.05
    assert found.rest <= 0.02


@pytest.mark.thorough
@pytest.mark.long
@pytest.mark.parametrize("name", ["engraving.ngc", "mixed_units.ngc", "expressions.ngc"])
def test_programs_of_other_programs_stay_within_the_tolerance(name):
    axis = LINEAR | {"steps_per_mm": 40, "min_mm": -20, "max_mm": 220}
    axes = {letter: axis | {"node": 4 + number} for number, letter in enumerate("xyz")}
    machine = machine_from_data({"machine": "mill", "tolerance_mm": 0.03, "axes": axes})
    text = (EXAMPLES / name).read_text()
    found = off(text, machine)
    assert 0.005 < found.largest <= 0.03
    assert found.rest <= 0.02


def test_a_reversed_axis_and_other_microsteps():
    machine = machine_from_data(
        {
            "machine": "plotter",
            "axes": {
                letter: {
                    "node": node,
                    "is_reversed": letter == "y",
                    "microstep_exponent": exponent,
                    "steps_per_mm": 20,
                    "min_mm": -10,
                    "max_mm": 50,
                    "velocity_mm_per_min": 2000,
                    "acceleration_mm_per_s2": 150,
                }
                for letter, node, exponent in (("x", 4, 0), ("y", 5, 3))
            },
        }
    )
    found = off("G21 F1500\nG1 X10 Y-3\nG3 X12 Y2 I1 J2.5\nG61.1 G1 X0 Y1", machine)
    assert found.largest <= 0.05 * 1.01 + 0.02


def test_an_axis_that_rests_long_ends_the_phrase():
    text = "G21 G61 F60\nG1 X1 Y0.1\n" + "\n".join(f"X{n}" for n in range(2, 16)) + "\nX16 Y0.5"
    phrases = [
        p for p in NodePhrases(mill("xy"), PATHS).of(planned(text, mill("xy"))) if hasattr(p, "commands")
    ]
    assert len(phrases) == 2
    assert phrases[0].end == phrases[1].begin == {"x": 15 * 160, "y": 16}
    needed = [command.needed_us for command, _ in phrases[0].commands]
    assert needed == sorted(needed)


def test_places_go_along():
    items = list(NodePhrases(mill("xy"), PATHS).of(planned("G21 F900\nG1 X5\nY5\nG4 P1\nG0 X0", mill("xy"))))
    first, dwell, second, *_ = items
    assert {placed.place.line for placed in first.commands} == {2, 3}
    assert (dwell.seconds, second.place.line) == (1.0, 5)


def test_less_than_a_pulse_is_no_command():
    items = [
        i
        for i in NodePhrases(mill(), PATHS).of(planned("G21 F900\nG1 X0.001", mill()))
        if hasattr(i, "commands")
    ]
    assert items == []


def test_an_axis_without_a_node_is_refused():
    axis = {"axis": "m1", "deg_per_mm": 360, "min_mm": 0, "max_mm": 9, "velocity_mm_per_min": 9}
    machine = machine_from_data({"machine": "m", "axes": {"x": axis | {"acceleration_mm_per_s2": 9}}})
    with pytest.raises(ValueError, match="without a node"):
        NodePhrases(machine, PATHS)


WAVES = "G21 G90 F1500\nG1 " + "\n".join(f"X{n} Y{(n % 4) * 0.6:.1f}" for n in range(1, 60))


@pytest.mark.parametrize("brake_us", [150_000, 400_000, 1_234_567])
def test_a_brake_stays_on_the_path_and_the_rest_follows(brake_us):
    said = []

    def brake(maker, phrase, now_us):
        if now_us >= brake_us and not said:
            said.append(phrase.brake())
            maker.override = 0.5

    machine = mill("xy", tolerance_mm=0.05)
    places, phrases = follow(WAVES, machine, brake)
    assert said == [True]
    first, second = phrases
    assert first.end == second.begin
    assert first.duration_s < brake_us / 1e6 + 2.5
    found = deviation(asked_path(motions_of(WAVES), machine), places)
    assert found.largest <= 0.05
    assert found.rest <= 0.01
    whole = planned(WAVES, machine).duration_s
    assert second.duration_s > 1.3 * (whole - first.duration_s)  # corners keep their speed


def test_a_brake_near_the_end_or_before_the_start_is_none():
    machine = mill("xy")
    phrase = next(NodePhrases(machine, PATHS).of(planned("G21 F600\nG1 X1 Y0.1\nX1.3 Y1", machine)))
    assert not phrase.brake()
    for _ in phrase.commands:
        pass
    assert not phrase.brake()


def test_a_long_line_is_streamed_so_that_it_can_brake():
    machine = mill("xy")
    phrase = next(NodePhrases(machine, PATHS).of(planned("G21 F60\nG1 X100 Y3", machine)))
    commands = phrase.commands
    for _ in range(20):
        next(commands)
    assert phrase.brake()
    rest = sum(1 for _ in commands)
    assert rest < 30
    assert 0 < phrase.end["x"] < 16_000
    assert not phrase.brake()


def test_a_line_of_too_many_commands_is_streamed():
    """At 4000 full steps a second a line needs a command for each 50 steps to stay within a step."""
    axis = {
        "steps_per_mm": 80,
        "min_mm": 0,
        "max_mm": 400,
        "microstep_exponent": 0,
        "velocity_mm_per_min": 3000,
        "acceleration_mm_per_s2": 300,
    }
    axes = {letter: axis | {"node": 4 + number} for number, letter in enumerate("xyz")}
    machine = machine_from_data({"machine": "quick", "latency_ms": 8, "axes": axes})
    kinds = set()
    for way in ("X295.37 Y289.3 Z298.1", "X300"):
        plan = planned(f"G21 F8000\nG1 {way}", machine)
        for phrase in NodePhrases(machine, PATHS).of(plan):
            if hasattr(phrase, "commands"):
                kinds.add(type(phrase).__name__)
                commands = [placed.command for placed in phrase.commands]
                assert isinstance(phrase, StreamPhrase) or can_be_sent(machine, commands)
                assert phrase.end == NodePhrases(machine, PATHS).pulses_at(next(plan.stretches).end)
    assert kinds == {"LinePhrase", "StreamPhrase"}
