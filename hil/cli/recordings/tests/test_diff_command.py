"""``hil diff``: recordings beside each other, beside today's boards, and beside another configuration."""

import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from hil.cli.framework.command_group import app
from hil.sim.log_checks import without_checks
from hil.testing import Bench

CONFIG = {
    "bench": "two",
    "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}, "s1": {"profile": "sac"}},
}
HEAVY = """
bench: two
devices:
  m1: {profile: mechaduino, flash: {table: identity}, axis: {inertia_kg_m2: 0.0001}}
"""


def hil(*words: object) -> Result:
    return CliRunner().invoke(app, list(map(str, words)))


def told(*words: object) -> Any:
    return json.loads(hil("diff", *words, "--json").stdout)


def typed(bench: Bench, target: bytes = b"90", at_ms: float = 200.5) -> None:
    bench.start()
    for text in (b"y", b"x", b"r\r%s\r" % target):
        bench.run(at_ms)
        bench.port("m1").write(text)
    bench.run(300)
    bench.port("m1").write(b"p")
    bench.run(200)


def recorded(
    file: Path, drive: Callable[[Bench], object] = typed, config: Mapping[str, Any] = CONFIG
) -> Path:
    with Bench(config) as bench, file.open("w") as opened:
        drive(bench)
        bench.inputs.write_to(opened)
    return file


@pytest.fixture
def log(tmp_path: Path) -> Path:
    return recorded(tmp_path / "one.log")


def changed(log: Path, change: Callable[[str], str]) -> Path:
    """Log without checks, with its text changed."""
    made = log.with_name("changed.log")
    made.write_text(change("".join(without_checks(log.read_text()))))
    return made


def test_what_is_equal(log: Path, tmp_path: Path) -> None:
    assert (hil("diff", log).exit_code, hil("diff", log).stdout) == (0, "identical\n")
    assert hil("diff", log, recorded(tmp_path / "again.log")).stdout == "identical\n"
    assert hil("bundle", log, "-y", "-o", tmp_path / "one.hilz").exit_code == 0
    assert hil("diff", log, tmp_path / "one.hilz").stdout == "identical\n"
    (tmp_path / "bench.yaml").write_text(json.dumps(CONFIG))
    assert hil("diff", log, tmp_path / "bench.yaml").stdout == "identical\n"
    assert told(log)["identical"] is True


def test_another_input_and_what_came_of_it(log: Path, tmp_path: Path) -> None:
    other = recorded(tmp_path / "other.log", lambda bench: typed(bench, b"45"))
    done = hil("diff", log, other)
    assert done.exit_code == 1
    assert re.match(r"different from \d+\.\d+s on\ninputs, of which 2 are the same:\n", done.stdout)
    assert "'r\\r90\\r'" in done.stdout
    assert "'r\\r45\\r'" in done.stdout
    assert "inputs before it:" in done.stdout
    assert "said before it: " in done.stdout
    values = told(log, other)
    assert values["config"] == values["boards"] == values["memories"] == []
    assert values["inputs"]["same"] == 2
    assert {"m1"} == {each["device"] for each in values["sent"]}
    assert all(each["axis"] == "m1" and each["then"] != each["now"] for each in values["fields"])
    assert values["fields"]
    assert values["at_ns"] <= values["states_at_ns"]


def test_another_configuration_key_by_key(log: Path, tmp_path: Path) -> None:
    config = {
        **CONFIG,
        "devices": {**CONFIG["devices"], "m1": {"profile": "mechaduino", "flash": {"table": "empty"}}},
    }
    other = recorded(tmp_path / "other.log", config=config)
    values = told(log, other)
    assert values["config"] == ['devices.m1.flash.table: "identity" -> "empty"']
    assert any(each.startswith("m1: ") for each in values["memories"])
    assert values["inputs"] is None
    assert "configuration:\n  devices.m1.flash.table" in hil("diff", log, other).stdout


def test_the_inputs_at_another_configuration(log: Path, tmp_path: Path) -> None:
    heavy = tmp_path / "heavy.yaml"
    heavy.write_text(HEAVY)
    done = hil("diff", log, heavy)
    assert done.exit_code == 1
    assert "devices.m1.axis.inertia_kg_m2: unset -> 0.0001" in done.stdout
    assert re.search(r"states at [\d.]+s, recorded and \S+heavy.yaml, run today:\n  m1\.\w+  ", done.stdout)
    values = told(log, heavy)
    assert values["states_at_ns"] is not None
    assert values["fields"]


def test_bytes_that_are_others_today(log: Path) -> None:
    other = changed(
        log, lambda text: re.sub(r'("device":"m1","sent":"[0-9a-f]*)39302e3030', r"\g<1>39312e3030", text)
    )
    done = hil("diff", other)
    assert done.exit_code == 1
    assert re.search(r"sent:\n  m1, piece \d+: logged b'[^']*91\.00", done.stdout)
    assert "now b'" in done.stdout
    assert "state of m1 now: position_deg=" in done.stdout
    said = hil("replay", other).stderr
    assert said.startswith("hil: different: m1, piece ")
    assert said.endswith(f"\n`hil diff {other}` says what was before it\n")
    assert f"  {said.splitlines()[0].removeprefix('hil: different: ')}\n" in done.stdout  # in the same words
    values = told(other)
    assert values["state_now"]["m1"]["loop_on"] == 1
    (first,) = values["sent"]
    assert bytes.fromhex(first["first"][0]["hex"]).replace(b"91", b"90") == bytes.fromhex(
        first["first"][1]["hex"]
    )


def test_a_log_of_another_version_is_compared_as_far_as_it_goes(log: Path) -> None:
    def with_an_unknown_verb(text: str) -> str:
        lines = text.splitlines(keepends=True)
        at = next(index for index, line in enumerate(lines) if '"data":"72' in line)
        ns = json.loads(lines[at])["at_ns"]
        lines.insert(at, f'{{"at_ns":{ns},"device":"m1","input":"do","verb":"dance","parameters":[]}}\n')
        return "".join(lines)

    done = hil("diff", changed(log, with_an_unknown_verb))
    assert done.exit_code == 0
    assert done.stdout.startswith("identical\nnote: ")
    assert "compared up to there" in done.stdout
    assert "dance" in done.stdout
    assert told(log)["notes"] == []


def test_a_log_that_was_cut(log: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.log"
    cut.write_bytes(b"".join(log.read_bytes().splitlines(keepends=True)[:-4]))
    done = hil("diff", log, cut)
    assert done.exit_code == 0
    assert done.stdout.startswith("identical\nnote: ")
    longer = recorded(tmp_path / "longer.log", lambda bench: (typed(bench), bench.port("m1").write(b"m")))
    assert told(log, longer)["inputs"]["first"][0] == "none"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nowhere.log"], "nowhere.log: No such file or directory"),
        (["one.log", "nowhere.log"], "nowhere.log: No such file or directory"),
        (["one.log", "nowhere.yaml"], "nowhere.yaml: No such file or directory"),
        (["one.log", "wrong.yaml"], "wrong.yaml:1:"),
        (["wrong.log"], "this is no recording"),
    ],
)
def test_bad_input(
    log: Path, words: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("wrong.yaml").write_text("bench: 1\n")
    Path("wrong.log").write_text("{}\n")
    done = hil("diff", *words)
    assert done.exit_code == 2
    assert said in done.stderr
    assert done.stdout == ""
