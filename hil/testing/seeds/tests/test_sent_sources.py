"""A project on its way to other computers."""

import subprocess

import pytest

from hil.testing.seeds import sent_sources
from hil.testing.seeds.sent_sources import SourcesRefused, files_of, pack, unpacked

FILES = ("test_a.py", "data/bench.yaml", "run.sh", ".hidden", ".venv/x", "env/pyvenv.cfg", "env/y", "build/z")


@pytest.fixture
def project(tmp_path):
    for name in FILES:
        path = tmp_path / "project" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(name)
    (tmp_path / "project/run.sh").chmod(0o755)
    return tmp_path / "project"


def test_without_git_what_others_made_stays_here(project):
    assert [*map(str, files_of(project))] == ["data/bench.yaml", "run.sh", "test_a.py"]


def test_with_git_it_is_what_git_has_or_would_add(project):
    (project / ".gitignore").write_text("env/\nbuild/\n.venv/\n")
    subprocess.run(["git", "init", "-q", project], check=True)
    names = [*map(str, files_of(project))]
    assert names == [".gitignore", ".hidden", "data/bench.yaml", "run.sh", "test_a.py"]


def test_the_same_files_are_the_same_bytes_and_come_back(project, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(tmp_path))
    packed = pack(project)
    (project / "test_a.py").touch()
    assert pack(project) == packed
    there = unpacked(packed)
    assert unpacked(packed) == there != project
    assert (there / "data/bench.yaml").read_text() == "data/bench.yaml"
    assert (there / "run.sh").stat().st_mode & 0o777 == 0o755
    (project / "test_a.py").write_text("other")
    assert unpacked(pack(project)) != there


def test_a_project_that_is_too_large_is_refused(project, monkeypatch):
    monkeypatch.setattr(sent_sources, "MOST_BYTES", 10)
    with pytest.raises(SourcesRefused, match="are sent to a farm: let git ignore"):
        pack(project)
