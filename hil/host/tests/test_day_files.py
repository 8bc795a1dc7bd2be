"""Files of days: what is kept, what is removed, and what a disk without room does."""

import asyncio
import logging
from pathlib import Path

import pytest

from hil.host.day_files import DayFiles, day_files_in, last_line

DAY_NS = 86_400_000_000_000
FIRST_NS = 20_000 * DAY_NS


def keep(files: DayFiles, *lines: tuple[int, str]) -> None:
    async def main() -> None:
        for day, line in lines:
            files.keep(line, FIRST_NS + day * DAY_NS)
        await files.close()

    asyncio.run(main())


def names(folder: Path) -> list[str]:
    return [path.name for path in day_files_in(folder)]


def test_a_file_a_day_and_the_oldest_go(tmp_path: Path) -> None:
    folder = tmp_path / "commands"
    for day in range(5):
        keep(DayFiles(folder, 3, 10_000), (day, f"a{day}"), (day, f"b{day}"))
    assert names(folder) == ["2024-10-06.jsonl", "2024-10-07.jsonl", "2024-10-08.jsonl"]
    assert (folder / "2024-10-08.jsonl").read_text() == "a4\nb4\n"
    assert last_line(folder) == "b4"
    assert (folder / "2024-10-08.jsonl").stat().st_mode & 0o777 == 0o600


def test_older_days_make_room_and_a_full_day_says_so_and_goes_on(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    keep(DayFiles(tmp_path, 30, 100), (0, "x" * 60))
    files = DayFiles(tmp_path, 30, 100)
    keep(files, (1, "y" * 60))
    assert names(tmp_path) == ["2024-10-05.jsonl"]
    with caplog.at_level(logging.ERROR):
        files = DayFiles(tmp_path, 30, 100)
        keep(files, (1, "z" * 60))
    assert "room" in files.problem
    assert "lines are lost" in caplog.text
    assert last_line(tmp_path) == "y" * 60
    keep(files := DayFiles(tmp_path, 30, 100), (2, "w" * 60))
    assert not files.problem


def test_a_folder_that_cannot_be_written_stops_nothing(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "commands").write_text("a file")
    files = DayFiles(tmp_path / "commands", 30, 1000)
    with caplog.at_level(logging.ERROR):
        keep(files, (0, "x"), (0, "y"))
    assert files.problem
    assert len(caplog.records) == 1


def test_a_half_line_of_a_killed_bench_stays_alone(tmp_path: Path) -> None:
    (tmp_path / "2024-10-04.jsonl").write_text("whole\nhal")
    assert last_line(tmp_path) == "whole"
    keep(DayFiles(tmp_path, 30, 1000), (0, "new"))
    assert (tmp_path / "2024-10-04.jsonl").read_text() == "whole\nhal\nnew\n"


def test_nothing_there_has_no_last_line(tmp_path: Path) -> None:
    assert last_line(tmp_path / "none") == ""
    assert day_files_in(tmp_path / "none") == []
