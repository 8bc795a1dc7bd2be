"""Programs for a board's processor in a configuration: what is read, and what is said of what cannot be."""

from pathlib import Path

import pytest

from hil.compose import find_catalogue
from hil.compose.build import start_memories
from hil.compose.simulated_config import as_simulated
from hil.config import BenchConfig, ConfigError, diff, from_dict, parse
from hil.sketch.chip_program import BOOT_SECTION, SECTION, unpacked
from hil.sketch.intel_hex import write_hex

IDLE, OTHER = b"\xff\xcf", b"\x00\x00\xff\xcf"


def config_in(folder: Path, keys: str, profile: str = "uno") -> BenchConfig:
    file = folder / "bench.yaml"
    text = f"bench: t\ndevices:\n  u1:\n    profile: {profile}\n    {keys}\n"
    return parse(text, str(file), find_catalogue())


def refused(folder: Path, keys: str, profile: str = "uno") -> list[str]:
    with pytest.raises(ConfigError) as error:
        config_in(folder, keys, profile)
    return [str(problem).replace(f"{folder}/", "") for problem in error.value.problems]


def write(folder: Path, name: str, *pieces: tuple[int, bytes]) -> None:
    (folder / name).parent.mkdir(exist_ok=True)
    (folder / name).write_bytes(write_hex(pieces))


def test_a_program_is_in_the_memory_at_the_start(tmp_path: Path) -> None:
    write(tmp_path, "build/x.hex", (0, IDLE))
    write(tmp_path, "boot.hex", (0x7E00, OTHER))
    config = config_in(tmp_path, "firmware: build/x.hex\n    bootloader: boot.hex")
    sections = start_memories(config, find_catalogue())["u1"]
    program, boot = unpacked(sections[SECTION]), unpacked(sections[BOOT_SECTION])
    assert (program.name, program.flash) == ("x.hex", IDLE)
    assert (boot.name, boot.start, boot.flash[0x7E00:]) == ("boot.hex", 0x7E00, OTHER)


def test_the_log_has_the_program_and_not_its_path(tmp_path: Path) -> None:
    write(tmp_path, "x.hex", (0, IDLE))
    config = config_in(tmp_path, "firmware: x.hex")
    assert config.model_dump(mode="json")["devices"]["u1"]["firmware"] == "x.hex"
    simulated = as_simulated(config)
    assert simulated["devices"]["u1"]["firmware"] is None
    simulated["devices"]["u1"]["port"] = "pty"
    assert from_dict(simulated, find_catalogue()).devices["u1"].firmware is None


def test_another_content_is_a_change(tmp_path: Path) -> None:
    write(tmp_path, "x.hex", (0, IDLE))
    old, same = (config_in(tmp_path, "firmware: x.hex") for _ in range(2))
    write(tmp_path, "x.hex", (0, OTHER))
    new = config_in(tmp_path, "firmware: x.hex")
    assert [change.action for change in diff(old, same)] == ["keep"]
    (change,) = diff(old, new)
    assert change.action == "restart"
    assert change.why[0].startswith('firmware: "x.hex (')


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        (
            "firmware: y.hex",
            "bench.yaml:5:15: devices.u1.firmware: y.hex cannot be read: No such file or directory (build it,"
            " or write where it is, from this file on)",
        ),
        (
            "firmware: build",
            "bench.yaml:5:15: devices.u1.firmware: build cannot be read: Is a directory (build",
        ),
        ("firmware: 5", "bench.yaml:5:15: devices.u1.firmware: a file's path is wanted here, not "),
        ("firmware: ~/x.hex", "bench.yaml:5:15: devices.u1.firmware: a file's path is wanted here, not "),
        ("firmware: [x.hex]", "bench.yaml:5:15: devices.u1.firmware: a file's path is wanted here, not "),
        (
            "bootloader: x.hex",
            "bench.yaml:5:17: devices.u1.bootloader: x.hex cannot be used (mend what is said",
        ),
        ("auto_reset: 1", "bench.yaml:5:17: devices.u1.auto_reset: "),
    ],
)
def test_a_key_that_cannot_be_used_is_said_with_its_place(tmp_path: Path, keys: str, said: str) -> None:
    (tmp_path / "build").mkdir()
    write(tmp_path, "x.hex", (0, IDLE))
    assert refused(tmp_path, keys)[0].startswith(said)


def test_a_damaged_file_is_said_with_its_line_and_column(tmp_path: Path) -> None:
    (tmp_path / "x.hex").write_text(":00000001FF\n:0")
    assert refused(tmp_path, "firmware: x.hex") == [
        "bench.yaml:5:15: devices.u1.firmware: x.hex cannot be used (mend what is said of it below)",
        "x.hex:2:1: a line follows the record of the end, which is line 1 (leave one program in the file)",
    ]


def test_a_program_has_to_leave_the_boot_section_alone(tmp_path: Path) -> None:
    write(tmp_path, "x.hex", (0, bytes(0x7E01)))
    write(tmp_path, "with_boot.hex", (0, IDLE), (0x7E00, OTHER))
    write(tmp_path, "boot.hex", (0x7C00, OTHER))
    write(tmp_path, "large.hex", (0, bytes(0x7C01)))
    (_, found) = refused(tmp_path, "firmware: x.hex")
    assert found == (
        "x.hex: its 32,257 bytes reach into the boot section, which begins at 0x7E00"
        " (make it smaller: it has room for 32,256 bytes)"
    )
    config = config_in(tmp_path, "firmware: with_boot.hex")
    assert config.devices["u1"].firmware is not None
    assert unpacked(config.devices["u1"].firmware.packed).flash == IDLE
    config_in(tmp_path, "firmware: large.hex")
    (_, found) = refused(tmp_path, "firmware: large.hex\n    bootloader: boot.hex")
    assert "begins at 0x7C00" in found


@pytest.mark.parametrize("key", ["firmware", "bootloader"])
def test_only_boards_with_a_processor_have_programs(tmp_path: Path, key: str) -> None:
    assert refused(tmp_path, f"{key}: x.hex", "sac") == [
        f"bench.yaml:5:5: devices.u1.{key}: a sac has no processor that runs a user's program"
        " (leave this key out)"
    ]
    (found,) = refused(tmp_path, "auto_reset: false", "sac")
    assert found == (
        "bench.yaml:5:5: devices.u1.auto_reset: a sac has no processor that its port resets"
        " (leave this key out)"
    )
    (found,) = refused(tmp_path, f"{key}: x.hex\n    at: /dev/ttyUSB0")
    assert found.startswith(f"bench.yaml:5:5: devices.u1.{key}: a real board (at: /dev/ttyUSB0) has its own")
