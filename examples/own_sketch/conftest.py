"""Builds the sketches of this folder, each once; without the compiler their tests are skipped."""

import shutil
from pathlib import Path

import pytest

from hil.toolchain.build_failed import NoToolchain
from hil.toolchain.sketch_build import build_sketch

HERE = Path(__file__).parent


@pytest.fixture(scope="session")
def built(tmp_path_factory):
    """Copy of a sketch's folder with the program in it; ``changes`` are made in its text before."""
    done = {}

    def build(name, changes=()):
        key = name, *dict(changes).items()
        if key in done:
            return done[key]
        folder = tmp_path_factory.mktemp("built") / name
        shutil.copytree(HERE / name, folder, ignore=shutil.ignore_patterns("build"))
        sketch = folder / f"{name}.ino"
        for old, new in dict(changes).items():
            assert sketch.read_text().count(old) == 1
            sketch.write_text(sketch.read_text().replace(old, new))
        try:
            build_sketch(folder)
        except NoToolchain as error:
            pytest.skip(str(error))
        return done.setdefault(key, folder)

    return build
