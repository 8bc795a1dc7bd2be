"""The board and the framing of ``docs/how-to/add-a-framing.md``, as they stand there."""

from pathlib import Path

import pytest
from how_to_pages import only_test, run_tests, style_problems, write_files
from markdown_blocks import block

from hil.testing import Bench, check_profile

PAGE = "add-a-framing"


@pytest.fixture
def files(tmp_path: Path) -> list[Path]:
    return write_files(PAGE, tmp_path)


@pytest.mark.thorough
def test_its_tests_pass(files: list[Path], tmp_path: Path) -> None:
    said = run_tests(only_test(files), tmp_path).stdout
    assert "7 passed" in said, said


def test_the_board_passes_the_shipped_checks_and_the_style(files: list[Path], tmp_path: Path) -> None:
    check_profile(tmp_path / "boards" / "meter")
    assert style_problems([path for path in files if path.suffix == ".py"]) == ""


def test_its_configuration_is_good(files: list[Path], tmp_path: Path) -> None:
    (tmp_path / "try.yaml").write_text(block(f"docs/how-to/{PAGE}.md", "Use it"))
    with Bench(tmp_path / "try.yaml") as bench:
        bench.run(ms=10)
        bench.tap("bus0.master").write(b"11?A1\r")
        bench.run(ms=50)
        assert bench.tap("bus0.master").read() == b"11=0CF\r"
