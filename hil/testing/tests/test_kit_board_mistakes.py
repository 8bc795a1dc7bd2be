"""Mistakes in boards outside of hil: each is said with its file and place, and the other boards work on."""

from pathlib import Path

import pytest
from kit_boards import BOARD, FIRMWARE, YAML, answers, bench, problems, write

from hil.config import ConfigError
from hil.testing import Bench


def board_problem(tmp_path: Path, **changed: str) -> str:
    """Problem of a board with this mistake, beside a good one that works on."""
    write(tmp_path / "boards" / "bad", **changed)
    write(tmp_path / "boards" / "good")
    assert answers(bench(tmp_path, "good")) == b"good"
    first, *others = problems(bench(tmp_path, "good", "bad"))
    assert first == (
        "bench.yaml:5:17: devices.d1.profile: the board bad cannot be used (mend what is said of it below)"
    )
    (found,) = others
    return found


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    board = write(tmp_path / "boards" / "namer")
    (board / "board.py").unlink()
    (board / "profile.yaml").rename(board / "profile.yml")
    with pytest.raises(ConfigError, match="there is no board in"):
        Bench(bench(tmp_path, "namer"))
    (board / "profile.yml").rename(board / "profile.yaml")
    assert problems(bench(tmp_path, "namer"))[1].startswith(
        "boards/namer/board.py:1:1: this file is missing ("
    )
    (board / "board.py").write_text(BOARD)
    (board / "profile.yaml").unlink()
    assert problems(bench(tmp_path, "namer"))[1].startswith("boards/namer/profile.yaml:1:1: No such file")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("name: bad", "name: other", "1:7: name: this is not its folder's name"),
        ("law: ", "lwa: ", '3:1: lwa: unknown key (did you mean "law"?)'),
        ("law: mechaduino", "law: mechanical", "3:6: law: there is no such control law"),
        (
            "value: 0.2",
            "value: strong",
            "13:37: axis.torque_constant_Nm_per_A.value: a number is wanted here",
        ),
        ("unit: Nm/A", "unit: Ncm/A", '13:48: axis.torque_constant_Nm_per_A.unit: "Ncm/A" is not the unit'),
        ("start_deg", "stop_deg", "16:3: axis.stop_deg: neither the law mechaduino nor a plant has this"),
        ("  main: {{baud: 9600}}", "  main: {{}}\n  main: {{}}", "7:3: uarts.main: this key is given twice"),
        ("baud: 9600", "baud: fast", "6:16: uarts.main.baud: a whole number is wanted here"),
    ],
)
def test_a_mistake_in_profile_yaml(tmp_path: Path, old: str, new: str, said: str) -> None:
    text = YAML.replace(old.replace("bad", "{name}"), new, 1).format(name="bad")
    write(tmp_path / "boards" / "bad", profile=text)
    write(tmp_path / "boards" / "good")
    assert answers(bench(tmp_path, "good")) == b"good"
    found = problems(bench(tmp_path, "bad"))[1:]
    assert any(each.startswith(f"boards/bad/profile.yaml:{said}") for each in found), found


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"board": "x = 1\n"}, "board.py:1:1: there is no PROFILE here (write PROFILE = Profile("),
        ({"board": "\nPROFILE = {}\n"}, "board.py:2:11: PROFILE is no Profile, but a dict"),
        ({"board": "import nowhere_at_all\n"}, "board.py:1:1: ModuleNotFoundError: No module named"),
        ({"board": BOARD.replace(".firmware", "bad.firmware")}, "board.py:3:1: ModuleNotFoundError: No mod"),
        ({"board": BOARD.replace("Namer", "Nmr")}, "board.py:3:1: ImportError: cannot import name 'Nmr'"),
        ({"board": BOARD.replace("firmware=", "firmwre=")}, "board.py:5:11: TypeError: Profile.__init__()"),
        ({"board": BOARD + "PROFILE = 1 / 0\n"}, "board.py:6:11: ZeroDivisionError: division by zero (mend"),
        ({"board": "\nif\n"}, "board.py:2:3: SyntaxError: invalid syntax"),
        ({"board": "raise SystemExit('no')\n"}, "board.py:1:1: SystemExit: no"),
        ({"firmware": "\n\nraise OSError('no adapter')\n"}, "firmware.py:3:1: OSError: no adapter"),
        (
            {"board": "from hil.vocab.profile import Profile\n\nPROFILE = Profile(\n    firmware='Namer')\n"},
            "board.py:4:14: firmware: a class or a function that takes a Board is wanted here, not this str",
        ),
    ],
)  # fmt: skip
def test_a_mistake_in_its_python(tmp_path: Path, changed: dict[str, str], said: str) -> None:
    assert board_problem(tmp_path, **changed).startswith(f"boards/bad/{said}")


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ("uarts=9600", "14: uarts: a mapping of names to UartSpec is wanted here, not this int"),
        (
            "axes={'elbow': AxisSpec(about='')}",
            "13: axes: these are elbow, and those of profile.yaml none (write the same names in both)",
        ),
        ("axes=('elbow',)", "13: axes: a mapping of names to AxisSpec is wanted here, not this tuple"),
        (
            "uarts={}",
            "14: uarts: these are none, and those of profile.yaml main (write the same names in both, and"
            ' "{}" for none)',
        ),
        (
            "uarts={'usb': UartSpec(about='')}",
            "14: uarts: these are usb, and those of profile.yaml main (write the same names in both)",
        ),
        (
            "uarts={'main': UartSpec(about=''), 'bus': UartSpec(about='')}",
            "14: uarts: these are main, bus, and those of profile.yaml main (write the same names in both)",
        ),
        ("uarts={'main': UartSpec(about='a'), 'main': UartSpec(about='b')}", "44: 'main' is given twice"),
        ("verbs=[Verb('ping', '')]", "14: verbs: a tuple of Verb is wanted here, not this list"),
        ("verbs=(Verb('ping', ''), Verb('ping', ''))", '14: verbs: there are two verbs "ping"'),
        ("verbs=(Verb('reset', ''),)", '14: verbs: there are two verbs "reset"'),
        ("dialogues={'stpo': Namer}", '18: dialogues: there is no verb "stpo" (write one of pin, reset'),
        ("dialogues={'reset': 1}", "18: dialogues: a mapping of verbs' names to functions is wanted here"),
        ("readers={'q': 1}", "16: readers: a mapping of names to functions is wanted here"),
        ("starve=1", "15: starve: a function is wanted here"),
        ("follow=1", "15: follow: a function is wanted here"),
        ("terminal_axis='x'", "22: terminal_axis: a class is wanted here"),
        ("commands=()", "17: commands: a function is wanted here"),
        ("shown_first=['r']", "20: shown_first: a tuple of fields' names is wanted here"),
        ("examples=('?',)", "17: examples: a tuple of Example with bytes is wanted here"),
        ("examples=(Example(types='?', answer=b''),)", "17: examples: a tuple of Example with bytes is"),
        (
            "examples=(Example(types=b'', answer=b'', uart='bus'),)",
            '17: examples: there is no serial interface "bus" (write one of main)',
        ),
        ("memory_file='table'", "20: memory_file: a MemoryFile is wanted here"),
    ],
)  # fmt: skip
def test_a_part_of_profile_that_does_not_do(tmp_path: Path, parts: str, said: str) -> None:
    text = (
        "from hil.vocab.profile import AxisSpec, Example, Profile, UartSpec\n"
        "from hil.vocab.verbs import Verb\n"
        f"from .firmware import Namer\nPROFILE = Profile(\n       {parts},\n    firmware=Namer)\n"
    )
    assert board_problem(tmp_path, board=text).startswith(f"boards/bad/board.py:5:{said}")


@pytest.mark.parametrize(
    ("file", "content", "said"),
    [
        ("profile.yaml", b"", "profile.yaml:1:1: keys are wanted here, not nothing"),
        ("profile.yaml", b"\x7fELF\0\xff", "profile.yaml:1:6: this is no text file (give a text, saved"),
        ("profile.yaml", b"\xff\xfe", "profile.yaml:1:1: the byte 0xff is not UTF-8 text"),
        ("profile.yaml", b"name: bad\n\tlaw: sac\n", "profile.yaml:2:1: a tab stands"),
        ("board.py", b"\xff\xfe", "board.py:1:2: SyntaxError: (unicode error)"),
        ("board.py", b"{}['x']\n", "board.py:1:1: KeyError: 'x' (mend this line)"),
        (
            "board.py",
            b"def f():\n    f()\n\n\nf()\n",
            "board.py:2:5: RecursionError: maximum",
        ),
    ],
)
def test_a_file_that_is_none(tmp_path: Path, file: str, content: bytes, said: str) -> None:
    (write(tmp_path / "boards" / "bad") / file).write_bytes(content)
    assert problems(bench(tmp_path, "bad"))[1].startswith(f"boards/bad/{said}")


def test_a_mended_board_works_in_the_same_process(tmp_path: Path) -> None:
    board = write(tmp_path / "boards" / "namer", firmware="1 / 0\n")
    assert "firmware.py:1:1: ZeroDivisionError" in problems(bench(tmp_path, "namer"))[1]
    (board / "firmware.py").write_text(FIRMWARE.format(name="well again"))
    assert answers(bench(tmp_path, "namer")) == b"well again"
