"""Where a bench's files are."""

from pathlib import Path

from hil.daemon.paths import control_sockets, log_file, runtime_base, runtime_bases, state_base


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
    assert runtime_bases(None, env) == [Path("/run/hil/lab"), Path("/run/hil")]
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
