"""Folder of recordings: unique names, what is kept, and what is never removed."""

import os
import stat
from pathlib import Path

import pytest

from hil.compose import recordings_folder
from hil.compose.recordings_folder import ENDING, HUNG, RecordingsFolder, recordings_in, run_name


def made(folder: Path, name: str, size: int = 10) -> Path:
    folder.mkdir(exist_ok=True)
    path = folder / f"{name}{ENDING}"
    path.write_bytes(bytes(size))
    return path


def names(folder: Path) -> list[str]:
    return [run_name(path) for path in recordings_in(folder)]


def test_recordings_of_one_second_have_names_of_their_own(tmp_path: Path) -> None:
    folder = RecordingsFolder(tmp_path / "r", 100, 10**9)
    begun = [folder.begin() for _ in range(12)]
    found = [path for path, _ in begun]
    for _, file in begun:
        file.close()
    assert len(set(found)) == 12
    assert recordings_in(folder.path) == found
    assert {stat.S_IMODE(path.stat().st_mode) for path in found} == {0o600}
    assert stat.S_IMODE(folder.path.stat().st_mode) == 0o700


def test_a_clock_that_was_set_back_takes_no_name_twice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = recordings_folder.datetime

    class Clock(real):  # type: ignore[misc, valid-type]
        @classmethod
        def now(cls, tz: object = None) -> object:
            return real(2026, 11, 29, 0, 9, 16, tzinfo=recordings_folder.UTC)

    monkeypatch.setattr(recordings_folder, "datetime", Clock)
    folder = RecordingsFolder(tmp_path, 100, 10**9)
    for _ in range(3):
        folder.begin()[1].close()
    assert names(tmp_path) == ["2026-11-29T00-09-16Z", "2026-11-29T00-09-16Z_2", "2026-11-29T00-09-16Z_3"]


def test_the_oldest_go_first_by_number_and_by_room(tmp_path: Path) -> None:
    for day in range(1, 8):
        made(tmp_path, f"2026-01-0{day}T00-00-00Z", 1000)
    (tmp_path / f"2026-01-01T00-00-00Z{HUNG}").write_text("m1")
    RecordingsFolder(tmp_path, 6, 10**9).tidy(0)
    assert [name[8:10] for name in names(tmp_path)] == ["03", "04", "05", "06", "07"]
    assert not list(tmp_path.glob(f"*{HUNG}"))
    RecordingsFolder(tmp_path, 6, 4500).tidy(1200)
    assert [name[8:10] for name in names(tmp_path)] == ["05", "06", "07"]


def test_what_a_program_writes_is_never_removed(tmp_path: Path) -> None:
    old = RecordingsFolder(tmp_path, 100, 10**9)
    running, file = old.begin()
    file.write(bytes(5000))
    later = made(tmp_path, "2999-01-01T00-00-00Z")
    RecordingsFolder(tmp_path, 1, 100).tidy(99)
    assert recordings_in(tmp_path) == [running]
    assert not later.exists()
    file.close()
    RecordingsFolder(tmp_path, 1, 100).tidy(99)
    assert recordings_in(tmp_path) == []


def test_a_folder_that_is_a_file_is_an_error_and_has_no_recordings(tmp_path: Path) -> None:
    path = tmp_path / "recordings"
    path.write_text("")
    with pytest.raises(OSError, match=r".*"):
        RecordingsFolder(path, 5, 10**9).begin()
    assert recordings_in(path) == []
    assert recordings_in(tmp_path / "none") == []
    os.mkfifo(tmp_path / f"2026-01-01T00-00-00Z{ENDING}")
    RecordingsFolder(tmp_path, 1, 1).tidy(0)  # waits for nobody
