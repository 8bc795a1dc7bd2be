"""``hil serve --detach`` and ``hil shutdown``: a bench that goes on when the command has ended."""

import json
import os
import signal
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from e2e_support import HIL, PATIENCE_S, until

from hil.cli.framework.exit_codes import Exit

ONE = "bench: desk\ndevices:\n  m1: {profile: mechaduino}\n"
Command = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture
def command(tmp_path: Path) -> Iterator[Command]:
    """Run ``hil`` in a folder with benches of its own, which end with the test."""
    (tmp_path / "bench.yaml").write_text(ONE)
    base = {"XDG_RUNTIME_DIR": str(tmp_path / "run"), "XDG_STATE_HOME": str(tmp_path / "state")}

    def run(*words: str) -> "subprocess.CompletedProcess[str]":
        environment = os.environ | base
        return subprocess.run(
            [HIL, *words],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
            check=False,
        )

    yield run
    run("shutdown")


def test_a_bench_goes_on_until_it_is_stopped(command: Command, tmp_path: Path) -> None:
    begun = command("serve", "bench.yaml", "--detach", "--log", "bench.log")
    assert (begun.returncode, begun.stderr) == (0, "")
    said = begun.stdout.splitlines()
    assert said[0].startswith("bench desk runs: process ")
    assert said[1] == f"  m1 at {tmp_path}/run/hil/desk/m1"
    assert said[2] == f"Its log is {tmp_path}/state/hil/desk/serve.log. `hil shutdown` ends it."
    assert "Angle" in command("type", "m1", "p", "--until", "raw encoder").stdout
    stopped = command("shutdown")
    assert (stopped.returncode, stopped.stdout) == (0, "bench desk has ended\n")
    assert '"end"' in (tmp_path / "bench.log").read_text().splitlines()[-1]  # it was closed before
    none = command("shutdown")
    assert none.returncode == Exit.FAILED
    assert none.stderr.startswith("hil: no bench is running here")


@pytest.mark.thorough
def test_the_report_for_programs_has_the_log(command: Command, tmp_path: Path) -> None:
    report = json.loads(command("--json", "serve", "--detach", "bench.yaml").stdout)
    assert report["ports"] == {"m1": f"{tmp_path}/run/hil/desk/m1"}
    assert report["log"] == f"{tmp_path}/state/hil/desk/serve.log"
    assert json.loads(command("shutdown", "--json").stdout) == {"bench": "desk", "stopped": True}
    assert not Path(report["control"]).exists()


@pytest.mark.thorough
def test_a_second_one_is_refused_and_leaves_the_first_ones_log(command: Command, tmp_path: Path) -> None:
    pid = json.loads(command("serve", "--json", "--detach", "bench.yaml").stdout)["pid"]
    second = command("serve", "--detach", "bench.yaml")
    assert second.returncode == Exit.MISTAKE
    assert (
        second.stderr
        == f"hil: bench desk is running already, as process {pid}; `hil shutdown -b desk` ends it,"
        " or write another name behind bench:\n"
    )
    assert [each.name for each in (tmp_path / "state/hil/desk").glob("serve.log*")] == ["serve.log"]


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["bad.yaml"], Exit.MISTAKE, 'bad.yaml:3:17: devices.m1.profile: there is no profile "mecha"'),
        (["none.yaml"], Exit.MISTAKE, "hil: none.yaml: No such file or directory"),
        (["bench.yaml", "--log", "no/b.log"], Exit.MISTAKE, "no/b.log"),
    ],
)
def test_one_that_does_not_start_says_why(
    command: Command, tmp_path: Path, words: list[str], code: int, said: str
) -> None:
    (tmp_path / "bad.yaml").write_text(ONE.replace("mechaduino", "mecha"))
    refused = command("serve", "--detach", *words)
    assert (refused.returncode, refused.stdout) == (code, "")
    assert said in refused.stderr
    assert not [*(tmp_path / "state").glob("hil/desk/serve.log*")]


@pytest.mark.thorough
def test_ctrl_c_while_it_starts_leaves_nothing(command: Command, tmp_path: Path) -> None:
    slow = ONE + "speed: 0.01\n"
    (tmp_path / "slow.yaml").write_text(slow)
    environment = os.environ | {
        "XDG_RUNTIME_DIR": str(tmp_path / "run"),
        "XDG_STATE_HOME": str(tmp_path / "state"),
    }
    socket = tmp_path / "run/hil/desk/control.sock"
    with subprocess.Popen([HIL, "serve", "slow.yaml", "--detach"], cwd=tmp_path, env=environment) as starting:
        until(socket.exists, "a bench that starts")
        starting.send_signal(signal.SIGINT)
        assert starting.wait(PATIENCE_S) == Exit.INTERRUPTED
    assert command("shutdown").returncode == Exit.FAILED
    assert not [*(tmp_path / "state").glob("hil/desk/serve.log*")]
