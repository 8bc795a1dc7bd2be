"""Folders of a bench: what is made for it, and what is left."""

from pathlib import Path

from hil.live.folders import folders


def test_what_was_made_for_the_runtime_directory_goes_with_it(tmp_path: Path) -> None:
    runtime = tmp_path / "a" / "b" / "run" / "bench"
    with folders("bench", tmp_path / "state", runtime):
        assert runtime.is_dir()
    assert [path.name for path in tmp_path.iterdir()] == ["state"]


def test_what_somebody_else_made_or_uses_stays(tmp_path: Path) -> None:
    base = tmp_path / "run"
    base.mkdir()
    with folders("bench", tmp_path / "state", base / "bench"):
        pass
    assert list(base.iterdir()) == []
    new = tmp_path / "new" / "run"
    with folders("one", tmp_path / "state", new / "one"):
        with folders("two", tmp_path / "other", new / "two"):
            pass
        assert [path.name for path in new.iterdir()] == ["one"]
        (new / "notes").touch()
    assert [path.name for path in new.iterdir()] == ["notes"]
