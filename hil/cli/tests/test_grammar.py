"""The command line as a whole: groups, examples, placeholders, what is told in JSON, words that are near."""

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import typer
import yaml
from typer.testing import CliRunner

from hil.cli.documents.command_tree import CliCommand, commands
from hil.cli.framework.command_classes import OrBelow, with_limits
from hil.cli.framework.command_group import app, panel_of
from hil.cli.framework.command_table import COMMANDS, PANELS
from hil.cli.framework.usage_words import USAGE_ERROR

ROOT = commands(app)
LEAVES = [command for command in ROOT.all() if command.arguments or not command.commands]
EXAMPLE = re.compile(r"^Example: hil (.+)", re.M)
TELL_NOTHING = {
    "top": "it redraws a terminal until Ctrl-C; `hil status --json` is for programs",
    "monitor": "it is a terminal: what it shows is the board's bytes, as they are",
    "with-lines": "it becomes another program",
    "virtual": "it becomes another program",
    "sketch gdb": "it serves GDB until Ctrl-C",
    "schema": "what it prints is JSON",
    "completion": "what it prints is a shell's script",
}
"""Commands of hil without --json, with the reason."""
HIL = [sys.executable, "-c", "from hil.cli.entry import main; main()"]


def parsed(words: list[str]) -> Any:
    """Parse a command line, and carry nothing out; answers the values of the command's parameters. Raises
    what the command line raises."""
    command: Any = typer.main.get_command(app)
    context = command.make_context("hil", words)
    while hasattr(command, "commands") and not isinstance(command, OrBelow):
        name, command, words = command.resolve_command(context, [*context._protected_args, *context.args])
        context = command.make_context(name, words, parent=context)
    return context.params


def example_of(command: CliCommand) -> list[str]:
    return shlex.split(re.split(r" [|>] ", EXAMPLE.findall(command.about)[0])[0])


@pytest.mark.parametrize("command", LEAVES, ids=lambda each: each.name)
def test_each_command_has_an_example_that_parses(command: CliCommand) -> None:
    examples = EXAMPLE.findall(command.about)
    assert examples, "write a paragraph `Example: hil ...` at the end of its docstring"
    for line in examples:
        words = shlex.split(re.split(r" [|>] ", line)[0])
        assert tuple(words[: len(command.path)]) == command.path
        parsed(words)


@pytest.mark.parametrize("command", LEAVES, ids=lambda each: " ".join(each.path))
@pytest.mark.parametrize(("flag", "words"), [("--bench", ["-b", "x"]), ("--json", ["--json"])])
def test_options_that_stand_before_the_verb(command: CliCommand, flag: str, words: list[str]) -> None:
    """They are the command's own, or refused: none is ignored."""
    line = [*words, *example_of(command)]
    if name := next((each.name for each in command.options if flag in each.flags), None):
        own = parsed(example_of(command))[name]  # a word behind the verb holds; a list has both
        given: Any = {"--bench": "x", "--json": True}[flag]
        assert parsed(line)[name] == ([given, *own] if isinstance(own, list) else own or given)
    else:
        with pytest.raises(USAGE_ERROR, match=r"asks no running bench|has no --json"):
            parsed(line)


def test_options_between_a_group_and_its_command_hold() -> None:
    assert (
        parsed(["-b", "x", "lease", "--json", "-b", "y", "show"]).items()
        >= {"as_json": True, "bench": "y"}.items()
    )
    assert parsed(["-b", "x", "lease", "show", "-b", "z"])["bench"] == "z"
    assert parsed(["lease", "--runtime-dir", "/r", "give"])["runtime_dir"] == Path("/r")


def test_help_shows_all_commands_in_groups_with_whole_summaries() -> None:
    said = CliRunner().invoke(app, ["--help"]).output
    shown = " ".join(said.split())
    for command in ROOT.commands:
        assert command.summary in shown
    assert "..." not in shown.replace("[OPTION...]", "").replace("[ARGUMENT...]", "")
    sections = re.split(r"^(\w+):$", said, flags=re.M)
    by_title = dict(zip(sections[1::2], sections[2::2], strict=True))
    assert list(by_title) == ["Options", *PANELS]
    for command in ROOT.commands:
        assert re.search(rf"^  {command.name} ", by_title[panel_of(command.name)], re.M)


@pytest.mark.parametrize("command", list(ROOT.all()), ids=lambda each: each.name or "hil")
def test_help_has_placeholders_in_capitals(command: CliCommand) -> None:
    short, long = (CliRunner().invoke(app, [*command.path, flag]) for flag in ("-h", "--help"))
    assert short.output == long.output
    assert long.exit_code == 0
    assert not re.search(r"<\w+>|\{\w+\}|\b(TEXT|PATH|INTEGER|FLOAT)\b", long.output)
    usage = long.output.partition("\n\n")[0]
    assert re.fullmatch(r"Usage: hil [a-z -]*(\[?[A-Z][][A-Z._=:-]*(\.\.\.)?\]?\s*)+", usage), usage


def test_what_tells_something_tells_it_in_json() -> None:
    own = [each for each in LEAVES if each.path[0] in COMMANDS and each.path[0] != "arduino"]
    without = {each.name for each in own if "--json" not in {f for o in each.options for f in o.flags}}
    assert without == set(TELL_NOTHING)


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["status", "--json", "--runtime-dir", "/nowhere"], 1, "no bench is running here"),
        (["reset", "--json"], 2, "DEVICE is missing"),
        (["stat", "--json"], 2, 'did you mean "status"?'),
        (["docs", "zenho", "--json"], 2, 'none has this word; did you mean "zenoh"? `hil docs` lists'),
        (["check", "--json", "b.yaml"], 2, "b.yaml:1:8: there is no space"),
    ],
)
def test_errors_in_json(words: list[str], code: int, message: str, tmp_path: Path) -> None:
    (tmp_path / "b.yaml").write_text("bench: t\nm1:\n  a:b\n  c: 1\n")
    message = message.replace("1:8", "3:5")
    done = subprocess.run([*HIL, *words], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == code
    assert done.stderr == ""
    error = json.loads(done.stdout)["error"]
    assert message in error["message"]
    assert error["exit_code"] == code
    if words[0] == "check":
        assert error["problems"][0].items() >= {"file": "b.yaml", "line": 3, "column": 5}.items()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("statsu", """there is no command 'statsu'; did you mean "status"? `hil --help` lists them"""),
        ("stat", """there is no command 'stat'; did you mean "status"? `hil --help` lists them"""),
        (
            "fault injct",
            """there is no command 'injct' of `hil fault`; did you mean "inject"? `hil fault --help` lists""",
        ),
        ("run list square", "square is too much for `hil run list`; write `hil run list [OPTION...]`"),
        (
            "recordings --jsn",
            """there is no option --jsn of `hil recordings`; did you mean "--json"? `hil recordings --""",
        ),
        ("list m1", "m1 is too much for `hil list`; write `hil list [OPTION...]`"),
    ],
)
def test_a_mistyped_command(words: str, said: str) -> None:
    done = CliRunner().invoke(app, words.split())
    assert (done.exit_code, done.output.startswith(f"hil: {said}")) == (2, True)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["set", "m1", "r", "fast"], 'r: "fast" is no number; write a number'),
        (["doctor", "--devices", "0"], "write at least 1"),
        (["doctor", "--devices", "513"], "write at most 512"),
    ],
)
def test_values_of_the_command_line(words: list[str], said: str) -> None:
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 2
    assert said in done.output
    assert "Input" not in done.output


def test_a_page_of_the_documentation_and_the_list_of_them() -> None:
    assert "runs" in CliRunner().invoke(app, ["docs"]).output
    page = Path(__file__).parents[3] / "docs" / "how-to" / "runs.md"
    for name in ("runs", "runs.md", "docs/how-to/runs.md", "runs#multi-axis-runs"):
        assert CliRunner().invoke(app, ["docs", name]).output == page.read_text()


def test_init_writes_what_check_takes_and_leaves_what_is_there(tmp_path: Path) -> None:
    file = tmp_path / "Lab 1.yaml"
    assert CliRunner().invoke(app, ["init", str(file)]).exit_code == 0
    assert "no problems" in CliRunner().invoke(app, ["check", str(file)]).output
    assert file.read_text().startswith("# yaml-language-server: $schema=Lab 1.schema.json\n")
    assert json.loads((tmp_path / "Lab 1.schema.json").read_text())["properties"]["devices"]
    again = CliRunner().invoke(app, ["init", str(file)])
    assert again.exit_code == 2
    assert "is there already" in again.output
    nowhere = CliRunner().invoke(app, ["init", str(tmp_path / "none" / "a.yaml")])
    assert (nowhere.exit_code, nowhere.output.count("\n")) == (2, 1)
    assert f"there is no folder {tmp_path / 'none'}" in nowhere.output


def test_benches_of_init_in_two_folders_have_two_names(tmp_path: Path) -> None:
    for folder, name in (("Press 2", "press-2"), ("mill", "mill"), ("47", "bench")):
        file = tmp_path / folder / "bench.yaml"
        file.parent.mkdir()
        assert CliRunner().invoke(app, ["init", str(file)]).exit_code == 0
        assert yaml.safe_load(file.read_text())["bench"] == name


@pytest.mark.parametrize(
    ("about", "shown"),
    [
        ("At most.  [default: 1.0; 0.05<=x<=60]", "At most.  [default: 1.0; 0.05 to 60]"),
        ("Count.  [x>=1]", "Count.  [at least 1]"),
        ("Rate.  [0<x<=5]", "Rate.  [more than 0, at most 5]"),
        ("A name, as x.  [default: x]", "A name, as x.  [default: x]"),
        ("Of it. [default: the usual one]  [50<=x<=4000]", "Of it. [default: the usual one]  [50 to 4000]"),
    ],
)
def test_limits_are_words(about: str, shown: str) -> None:
    assert with_limits(about) == shown


@pytest.mark.parametrize("command", LEAVES, ids=lambda each: each.name)
def test_help_has_no_signs_for_limits(command: CliCommand) -> None:
    shown = CliRunner().invoke(app, [*command.path, "--help"]).output
    assert re.findall(r"[<>]=?x|x[<>]=?|\b[A-Z]+-[A-Z]+\b", shown) == []
