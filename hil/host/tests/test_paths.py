"""Folders of a bench's files."""

import socket
from pathlib import Path

import pytest

from hil.host import paths
from hil.host.paths import control_sockets, log_file, runtime_base, runtime_bases, state_base
from hil.net.benches_here import find


def bench_in(folder: Path) -> Path:
    folder.mkdir(parents=True)
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(str(folder / "control.sock"))
    return folder / "control.sock"


def test_a_command_in_a_unit_means_the_bench_of_its_service(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    services = tmp_path / "run"
    monkeypatch.setattr(paths, "SERVICES", services)
    a, b = bench_in(services / "a"), bench_in(services / "b")
    assert [each.socket for each in find(None, {"XDG_RUNTIME_DIR": str(tmp_path)}).benches] == [a, b]
    assert [each.socket for each in find(None, {"RUNTIME_DIRECTORY": str(b.parent)}).benches] == [b]
    assert [each.socket for each in find(None, {"RUNTIME_DIRECTORY": str(services)}).benches] == [a, b]


def test_the_directories_of_a_service(tmp_path: Path) -> None:
    env = {
        "RUNTIME_DIRECTORY": "/run/hil/lab:/run/other",
        "STATE_DIRECTORY": "/var/lib/hil",
        "LOGS_DIRECTORY": "/var/log/hil",
        "XDG_RUNTIME_DIR": "/run/user/1",
    }
    option, configured = Path("/o"), Path("/c")
    assert runtime_base(option, configured, env, "lab") == option
    assert runtime_base(None, configured, env, "lab") == configured
    assert runtime_base(None, None, env, "lab") / "lab" == Path("/run/hil/lab")
    assert runtime_base(None, None, env, "b") / "b" == Path("/run/hil/lab/b")
    assert state_base(None, None, env, "lab") / "lab" == Path("/var/lib/hil/lab")
    assert runtime_bases(None, env) == [Path("/run/hil/lab")]
    assert runtime_bases(None, {"XDG_RUNTIME_DIR": "/x"}) == [Path("/x/hil"), Path("/run/hil")]
    assert runtime_bases(option, env) == [option]
    assert log_file(Path("a.log"), env) == Path("/var/log/hil/a.log")
    assert log_file(Path("/x/a.log"), env) == Path("/x/a.log")
    assert (log_file(Path("a.log"), {}), log_file(None, env)) == (Path("a.log"), None)
    made = [tmp_path / "control.sock", tmp_path / "b" / "control.sock", tmp_path / "c" / "d" / "control.sock"]
    for path in made:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    assert control_sockets(tmp_path) == made
