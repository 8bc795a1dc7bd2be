"""Words of a bench that was asked for and does not run."""

from pathlib import Path

from hil.net.benches_here import Found, Here

CELL, TA = Path("/run/user/1/hil/cell"), Path("/run/user/1/hil/ta")


def test_of_killed_benches_the_one_that_was_asked_for_is_named() -> None:
    found = Found([], [], killed=[CELL, TA])
    assert found.none_runs("ta").endswith(
        f"one was killed that had {TA}: start it again, which cleans up, or remove the folder"
    )
    assert f"some were killed that had {CELL}, {TA}: start them again" in found.none_runs()


def test_a_killed_bench_is_said_though_another_runs() -> None:
    found = Found([Here(Path("/run/user/1/hil/alpha/control.sock"), 1, False)], [], killed=[CELL])
    assert found.not_running("cell") == (
        f"bench 'cell' was killed (folder {CELL}): start it again, which cleans up; running: alpha"
    )
    assert found.not_running("nix") == "bench 'nix' is not running here; running: alpha"
