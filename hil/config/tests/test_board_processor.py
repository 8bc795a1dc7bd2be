"""``processor:`` of a ``profile.yaml``: what it is, and what is wrong with it, each with its place."""

from pathlib import Path

import pytest

from hil.config import ConfigError, ProfileInfo
from hil.config.catalogue import profile_from_yaml
from hil.vocab.axis_plan import ProcessorPlan

HEAD = "name: node\ntitle: Node\n"
PINS = "{LED: PB5, STEP: PD3, BACK: PC0, SENSE: ADC6}"


def profile(*lines: str) -> ProfileInfo:
    return profile_from_yaml(HEAD + "\n".join(lines) + "\n", Path("node"))


def processor(keys: str) -> ProfileInfo:
    return profile(f"processor: {{{keys}}}")


def said(*lines: str) -> tuple[str, str]:
    """Refuse a profile: from where its problem is on, and what is said."""
    with pytest.raises(ConfigError) as refused:
        profile(*lines)
    (found,) = refused.value.problems
    line = (HEAD + "\n".join(lines)).splitlines()[found.line - 1]
    message = found.message.partition(": ")[2]
    return line[found.column - 1 :], f"{message} ({found.remedy})"


def test_a_chip_alone_is_a_unos() -> None:
    made = profile("processor: atmega328p")
    assert made.processor
    assert made.processor.plan == ProcessorPlan()
    assert made.kind("axis").title == "pins"
    assert (made.kind("axis").inputs["D13"], made.kind("axis").analog["A7"]) == (13, 7)
    assert made.warnings == ()


def test_all_keys_are_in_the_plan() -> None:
    keys = (
        f"chip: atmega328p, clock_Hz: 8000000, supply_V: 3.3, aref_V: 2.5, fuses: {{low: 0xE2}}, pins: {PINS}"
    )
    made = processor(keys)
    pins = (("LED", 13), ("STEP", 3), ("BACK", 14), ("SENSE", 20))
    assert made.processor
    assert made.processor.plan == ProcessorPlan(8_000_000, 3.3, 2.5, (0xE2, 0xDE, 0xFD), pins)
    assert made.uarts["main"].baud == 115_200


def test_pins_are_a_kind_of_their_own() -> None:
    kind = processor(f"chip: atmega328p, pins: {PINS}").kind("axis")
    assert kind.inputs == kind.outputs == {"LED": 13, "STEP": 3, "BACK": 14}
    assert kind.analog == {"BACK": 0, "SENSE": 6}
    assert kind.means == {"step_V": 3}
    voltages = [name for name in kind.fields if name.endswith("_V")]
    assert voltages == ["vcc_V", "step_V", "back_V", "sense_V"]
    assert kind.described("sense_V").meaning.startswith("voltage at pin SENSE, ")
    assert kind.described("step_V").meaning.startswith("mean voltage at pin STEP: ")
    assert [*kind.settable] == ["vcc_V", "back_V", "sense_V"]
    assert processor(f"chip: atmega328p, pins: {PINS}").kind("axis") is kind


PADS = "ADC6, ADC7, " + ", ".join(
    f"P{port}{bit}" for port, bits in (("B", 6), ("C", 6), ("D", 8)) for bit in range(bits)
)


@pytest.mark.parametrize(
    ("keys", "at", "wrong"),
    [
        ("chip: atmega2560", "atmega2560", "\"atmega2560\" is none of the choices (write 'atmega328p')"),
        ("clock_Hz: 20000001", "20000001", "the number 20000001 is too large (write 20000000 or less)"),
        ("clock_Hz: 0", "0", "the number 0 is too small (write 1 or more)"),
        ("supply_V: 1.7", "1.7", "1.7 is too small (write 1.8 or more)"),
        ("supply_V: 5.6", "5.6", "5.6 is too large (write 5.5 or less)"),
        (
            "supply_V: 3.3, aref_V: 5.0",
            "5.0",
            "5 V at AREF are more than the supply's 3.3 V (write at most the supply's voltage)",
        ),
        (
            "pins: {LED: PB8}",
            "PB8}",
            f'there is no pin of an ATmega328P "PB8" (did you mean "PB5"? known are: {PADS})',
        ),
        (
            "pins: {X: PC6}",
            "PC6}",
            'there is no pin of an ATmega328P "PC6" (it is RESET, which is no pin here; leave it out)',
        ),
        (
            "pins: {X: ADC0}",
            "ADC0}",
            'there is no pin of an ATmega328P "ADC0" (write PC0, which is the same pin)',
        ),
        ("pins: {A: PB5, B: PB5}", "PB5}", "PB5 is the pin A already (a pin of the chip has one name)"),
        (
            "pins: {2x: PB5}",
            "2x: PB5}",
            '"2x" is no name of a pin (write a letter, and up to 31 more of letters, digits and _)',
        ),
        (
            "pins: {VCC: PB5}",
            "VCC: PB5}",
            "VCC is the name of a voltage of the processor already (give the pin another)",
        ),
        (
            "pins: {led: PB5, LED: PB4}",
            "LED: PB4}",
            "LED and led differ only by capital letters (give the pin another name)",
        ),
    ],
)
def test_what_is_wrong_is_said_at_its_place(keys: str, at: str, wrong: str) -> None:
    chip = "" if keys.startswith("chip") else "chip: atmega328p, "
    assert said(f"processor: {{{chip}{keys}}}") == (f"{at}}}", wrong)


def test_its_pins_are_the_boards_axis() -> None:
    wrong = said("axes: {a: {law: pin_bank, axis: {}}}", "processor: atmega328p")
    assert wrong == (
        "processor: atmega328p",
        "the processor's pins are no axis here"
        " (leave law and axes out: the axis of such a board is its pins; a motor is another device)",
    )


def test_its_line_has_a_speed() -> None:
    wrong = said("processor: {chip: atmega328p, bootloader_baud: null}", "uarts: {main: {}}")
    assert wrong == (
        "main: {}}",
        "the processor's serial interface needs a speed, for when its program has set none"
        " (write {baud: 9600})",
    )


@pytest.mark.parametrize(
    ("clock_Hz", "supply_V", "most"),
    [(4_000_000, 1.8, ""), (4_100_000, 1.8, "4 MHz"), (16_000_000, 3.3, "13.3 MHz"), (20_000_000, 4.5, "")],
)
def test_a_clock_that_is_too_fast_is_a_warning(clock_Hz: int, supply_V: float, most: str) -> None:
    warnings = processor(f"chip: atmega328p, clock_Hz: {clock_Hz}, supply_V: {supply_V}").warnings
    if not most:
        assert warnings == ()
        return
    (warning,) = warnings
    assert (warning.file, warning.line, warning.column) == ("node/profile.yaml", 3, 41)
    assert f"safe operating area: {most} at most" in warning.message
