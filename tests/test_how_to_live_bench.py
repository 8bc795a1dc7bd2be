"""The blocks of ``write-a-test.md`` about live benches, and of ``runs.md`` about runs at a shell."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from e2e_support import HIL, PATIENCE_S, Place, config, ended, until
from markdown_blocks import block, blocks, fits

TEST_PAGE, RUNS_PAGE = "docs/how-to/write-a-test.md", "docs/how-to/runs.md"
LIVE, RUNS = "A program of your own", "See and cancel runs"
FAR = '{"run": "far", "axes": {"m1": {}}, "steps": [{"move": {"m1": 72000.0}}]}'


def test_the_test_of_the_page_passes(tmp_path: Path) -> None:
    program = next(
        each.text for each in blocks(TEST_PAGE) if each.heading == LIVE and each.language == "python"
    )
    (tmp_path / "test_page.py").write_text(program)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=120, check=False)
    assert "1 passed" in done.stdout, done.stdout


def test_the_context_manager_of_the_page_prints(capsys: pytest.CaptureFixture[str]) -> None:
    _, program = (
        each.text for each in blocks(TEST_PAGE) if each.heading == LIVE and each.language == "python"
    )
    exec(program, {})
    assert capsys.readouterr().out.splitlines()[:2] == ["vd", "0\t0"]


def test_a_shell_waits_for_the_file_as_the_page_does(place: Place) -> None:
    commands = block(TEST_PAGE, LIVE, 3).replace("$ ", "")
    place.write(config(devices={"s1": {"profile": "sac", "flash": {}}}))
    where = " ".join(place.folders())
    script = commands.replace("hil serve", f"{HIL} serve {where}").replace("python3", sys.executable)
    done = subprocess.run(
        ["sh", "-c", f"{script}\nkill $!; wait $!; ls"],
        capture_output=True,
        text=True,
        cwd=place.folder,
        timeout=PATIENCE_S,
        check=False,
    )
    assert f"{place.runtime}/t/s1\n" in done.stdout, (done.stdout, done.stderr)
    assert "ready.json" not in done.stdout


def test_serve_tells_programs_when_boards_answer(place: Place) -> None:
    ready = place.folder / "ready.json"
    server = place.launch(config(), "--json", "--ready-file", str(ready))
    until(ready.exists, "the boards")
    told = json.loads(ready.read_text())
    assert json.loads(server.output) == told
    assert told["sim_ns"] >= 4_050_000_000
    assert told["pid"] == server.pid
    assert told["ports"] == {"m1": str(place.runtime / "t" / "m1")}
    server.stop()
    assert not ready.exists()
    nowhere = str(place.folder / "no" / "ready.json")
    said = place.launch(config(), "--ready-file", nowhere).refused()
    assert said == f"hil: --ready-file {nowhere}: No such file or directory\n"


def test_runs_are_seen_and_cancelled_as_the_page_shows(place: Place) -> None:
    server = place.serve(config(speed=1)).ready()
    server.ask("do", device="m1", name="enable", parameters={})
    place.write(FAR, "far.yaml")
    printed = ""
    for line in block(RUNS_PAGE, RUNS).splitlines():
        if line.startswith("$ "):
            words = [*line.removeprefix("$ hil ").split(), "--runtime-dir", str(place.runtime)]
            environment = os.environ | {"COLUMNS": "100"}
            done = subprocess.run(
                [HIL, *words], capture_output=True, text=True, cwd=place.folder, env=environment, check=True
            )
            printed += f"{line}\n{done.stdout}"
            if "--detach" in words:
                until(lambda: server.ask("runs", name="far")[0]["left_s"], "its plan")
            if "--at-once" in words:
                ended(server, "far")
    assert fits(block(RUNS_PAGE, RUNS), printed, r"\d+ s left", r"\d+\.\d+ deg", r"\d+\.\d{3}"), printed
