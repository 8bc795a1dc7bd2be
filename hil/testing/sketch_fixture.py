"""Fixture of sketches that a test run builds: ``sketch``."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest

BuildsSketch = Callable[..., Path]
"""Builder of a sketch: called with its folder, answers its ELF file; the hex file is beside it."""


@pytest.fixture(scope="session")
def sketch(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> BuildsSketch:
    """Build a sketch, once in a test run: ``sketch("sketches/blink")`` answers the path of its ELF file, for
    ``firmware:`` of a Uno, with the hex file beside it. The folder is one of the directory that pytest was
    started in, or of pytest's root. Options as of `hil sketch build`: ``libraries=["..."]``.

    A sketch that does not compile fails the test, with the compiler's words; where no compiler is installed
    the test is skipped, with the package that has it."""
    built = dict[tuple[object, ...], Path]()

    def build(folder: str | os.PathLike[str], *, libraries: tuple[str, ...] | list[str] = ()) -> Path:
        __tracebackhide__ = True
        from hil.toolchain.build_failed import BuildFailed, NoToolchain
        from hil.toolchain.sketch_build import BuildOptions, build_sketch

        place = Path(folder)
        if not place.exists():
            place = request.config.rootpath / place
        key = (place.resolve(), *libraries)
        if key not in built:
            output = tmp_path_factory.mktemp("sketch")
            try:
                built[key] = build_sketch(place, BuildOptions(output, [*map(Path, libraries)])).elf
            except NoToolchain as error:
                pytest.skip(str(error))
            except BuildFailed as error:
                pytest.fail(f"{folder} does not compile:\n{error}", pytrace=False)
        return built[key]

    return build
