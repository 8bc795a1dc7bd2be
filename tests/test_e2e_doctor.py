"""``hil doctor`` in processes that Linux really refuses something."""

import json
import os
import resource
import subprocess
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest
from denials import CALLS, install_filter, limited, needs_calls
from e2e_support import AS_STRANGER, HIL, PATIENCE_S, TERMINAL, Place, needs_stranger

Findings = dict[str, dict[str, str]]
RT_ROOT = Path("/sys/fs/cgroup/cpu")


def run(place: Place, *options: str, prefix: tuple[str, ...] = (), **popen: object) -> tuple[int, str]:
    """Run a command of ``hil``; its exit code and output."""
    folders = ("--runtime-dir", str(place.runtime), "--state-dir", str(place.state))
    done = subprocess.run(
        [*prefix, HIL, "doctor", *folders, *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        timeout=PATIENCE_S,
        env=os.environ | TERMINAL,
        check=False,
        **popen,  # type: ignore[call-overload]
    )
    text = done.stdout.decode()
    assert "Traceback" not in text
    return done.returncode, text


def examine(place: Place, **how: object) -> Findings:
    """Findings by name; the exit code tells of problems."""
    code, text = run(place, "--json", **how)  # type: ignore[arg-type]
    findings = {finding["name"]: finding for finding in json.loads(text)}
    assert sum(not name.startswith(("bench ", "memory ")) for name in findings) == 20
    assert code == any(finding["verdict"] == "problem" for finding in findings.values()), text
    return findings


@needs_stranger
def test_no_rtprio(open_place: Place) -> None:
    refuse = limited(resource.RLIMIT_RTPRIO, 0)
    findings = examine(open_place, prefix=AS_STRANGER, preexec_fn=refuse)
    priority = findings["real-time priority"]
    assert priority["verdict"] == "problem"
    assert priority["found"] == "tried, refused (EPERM): RLIMIT_RTPRIO is 0, at most 0"
    assert priority["remedy"].startswith(
        "LimitRTPRIO=80, or `rtprio 80` for you in /etc/security/limits.conf"
    )
    code, text = run(open_place, prefix=AS_STRANGER, preexec_fn=refuse)
    assert code == 1
    assert priority["remedy"] in text, "for people the remedy is one line"
    assert text.index("real-time priority") < text.index("runtime directory"), "the worst first"


@needs_stranger
def test_the_remedy_for_no_rtprio(open_place: Place) -> None:
    findings = examine(open_place, prefix=AS_STRANGER, preexec_fn=limited(resource.RLIMIT_RTPRIO, 80))
    assert findings["real-time priority"]["found"] == "tried: SCHED_FIFO 80"
    soft_only = examine(open_place, prefix=AS_STRANGER, preexec_fn=limited(resource.RLIMIT_RTPRIO, 0, 80))
    assert soft_only["real-time priority"]["remedy"] == "`ulimit -r 80`"


@needs_stranger
@pytest.mark.parametrize(("limit", "name"), [(0, "EPERM"), (65536, "ENOMEM")])
def test_no_memlock(open_place: Place, limit: int, name: str) -> None:
    findings = examine(open_place, prefix=AS_STRANGER, preexec_fn=limited(resource.RLIMIT_MEMLOCK, limit))
    memory = findings["locked memory"]
    assert memory["verdict"] == "problem"
    assert memory["found"] == f"tried, refused ({name}): RLIMIT_MEMLOCK is {limit >> 10} kB"
    assert memory["remedy"].startswith("LimitMEMLOCK=45M")


@needs_stranger
def test_the_remedy_for_no_memlock(open_place: Place) -> None:
    mended = examine(open_place, prefix=AS_STRANGER, preexec_fn=limited(resource.RLIMIT_MEMLOCK, 256 << 20))
    assert mended["locked memory"]["verdict"] == "ok"


@pytest.fixture
def group_without_budget() -> Iterator[Path]:
    if not (RT_ROOT / "cpu.rt_runtime_us").exists():
        pytest.skip("no real-time group scheduling (cgroup version 1, CONFIG_RT_GROUP_SCHED) here")
    above = RT_ROOT / f"hil-doctor-{os.getpid()}"
    group = above / "below"
    try:
        group.mkdir(parents=True)
    except OSError as error:
        pytest.skip(f"no control group can be made: {error.strerror}")
    yield group
    group.rmdir()
    above.rmdir()


def test_a_group_without_a_budget(place: Place, group_without_budget: Path) -> None:
    def enter() -> None:
        (group_without_budget / "cgroup.procs").write_text("0")

    findings = examine(place, preexec_fn=enter)
    for name in ("real-time priority", "real-time group"):
        assert findings[name]["verdict"] == "problem"
        assert "this control group has no real-time budget" in findings[name]["found"]
    remedy = findings["real-time group"]["remedy"]
    knobs = [
        str(folder / "cpu.rt_runtime_us") for folder in (group_without_budget.parent, group_without_budget)
    ]
    assert remedy == f"as root `echo 500000 | tee {' '.join(knobs)}`"
    command = remedy.split("`")[1]
    subprocess.run(["sh", "-c", command], check=True, stdout=subprocess.DEVNULL, timeout=PATIENCE_S)
    mended = examine(place, preexec_fn=enter)
    assert mended["real-time group"]["found"] == "500000 of 1000000 us"
    assert mended["real-time priority"]["verdict"] == "ok"


@needs_calls
def test_a_seccomp_filter(place: Place) -> None:
    if examine(place)["real-time priority"]["verdict"] != "ok":
        pytest.skip("without the filter real-time priority is refused, too")
    findings = examine(place, preexec_fn=partial(install_filter, CALLS["sched_setscheduler"]))
    priority = findings["real-time priority"]
    assert priority["verdict"] == "problem"
    assert priority["found"] == "tried, refused (EPERM): a seccomp filter refuses it"
    assert "RestrictRealtime=yes" in priority["remedy"]
    assert "sched_setscheduler" in priority["remedy"]
    assert findings["seccomp"]["verdict"] == "note"


@pytest.mark.parametrize("limit", [6, 16])
def test_few_descriptors(place: Place, limit: int) -> None:
    findings = examine(place, preexec_fn=limited(resource.RLIMIT_NOFILE, limit))
    descriptors = findings["RLIMIT_NOFILE"]
    assert (descriptors["verdict"], descriptors["found"]) == ("problem", str(limit))
    assert "1024" in descriptors["remedy"]


def test_no_descriptor_at_all(place: Place) -> None:
    """No file can be opened, not even to read the limit. (The command itself needs some to start.)"""
    script = """
import dataclasses, json, resource, sys
from pathlib import Path
from hil.core import Core
from hil.host.doctor import judge
from hil.host.probes import try_all
from hil.host.system import read_system

resource.setrlimit(resource.RLIMIT_NOFILE, (0, 0))
tried = try_all(8, Path(sys.argv[1]), Path(sys.argv[1]))
print(json.dumps([dataclasses.asdict(finding) for finding in judge(read_system(), tried, 8)]))
"""
    command = [sys.executable, "-c", script, str(place.runtime)]
    done = subprocess.run(command, capture_output=True, timeout=PATIENCE_S, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
    findings = {finding["name"]: finding for finding in json.loads(done.stdout)}
    assert "no file descriptor" in findings["real-time priority"]["found"]
    assert findings["ptys"]["found"] == "tried, refused (EMFILE)"
    assert findings["inotify"]["found"].startswith("tried, refused (EMFILE)")
    assert "Too many open files" in findings["state directory"]["found"]


def test_a_state_folder_that_is_a_file(place: Place) -> None:
    place.state.parent.mkdir(parents=True, exist_ok=True)
    place.state.write_text("")
    findings = examine(place)
    assert findings["state directory"]["verdict"] == "problem"
    assert findings["state directory"]["remedy"] == "choose another with --state-dir"


@needs_stranger
def test_a_runtime_folder_of_somebody_else(place: Place) -> None:
    place.runtime.mkdir(parents=True, exist_ok=True)
    os.chmod(place.runtime, 0o777)
    findings = examine(place, prefix=AS_STRANGER)
    assert "it belongs to another user" in findings["runtime directory"]["found"]


def test_nothing_is_left_behind(place: Place) -> None:
    def files() -> list[Path]:
        return sorted(place.runtime.parent.rglob("*"))

    before = files()
    examine(place)
    assert files() == before
