"""Checks of the fixture that builds sketches, and of pins by their addresses."""

from collections.abc import Callable

import pytest

from hil.testing import Bench

pytest_plugins = ["pytester"]
TEST = """
def test_it(sketch):
    elf = sketch("blink")
    assert elf == sketch("blink")
    assert elf.name == "blink.elf"
    assert elf.with_suffix(".hex").read_text().startswith(":")
"""


def write(pytester: pytest.Pytester, text: str) -> None:
    folder = pytester.mkdir("blink")
    (folder / "blink.ino").write_text(text)
    pytester.makepyfile(TEST)


def test_a_sketch_is_built_once(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    write(pytester, "void setup() {}\nvoid loop() {}\n")
    monkeypatch.setenv("XDG_CACHE_HOME", str(pytester.path / "cache"))
    done = pytester.runpytest_inprocess("-rs", "-p", "no:cacheprovider")
    counts = done.parseoutcomes()
    if "skipped" in counts:
        pytest.skip("no compiler for AVR is installed")
    assert counts == {"passed": 1}
    assert not (pytester.path / "blink" / "build").exists()


def test_a_sketch_that_does_not_compile_fails_its_test(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(pytester, "void setup() { x; }\nvoid loop() {}\n")
    monkeypatch.setenv("XDG_CACHE_HOME", str(pytester.path / "cache"))
    done = pytester.runpytest_inprocess("-p", "no:cacheprovider")
    if "skipped" in done.parseoutcomes():
        pytest.skip("no compiler for AVR is installed")
    done.stdout.fnmatch_lines(["*blink does not compile:*", "*blink.ino:1:16: error: 'x' was not declared*"])


def test_a_test_is_skipped_where_no_compiler_is_installed(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(pytester, "void setup() {}\nvoid loop() {}\n")
    monkeypatch.setenv("PATH", str(pytester.path))
    done = pytester.runpytest_inprocess("-rs", "-p", "no:cacheprovider")
    assert done.parseoutcomes() == {"skipped": 1}
    done.stdout.fnmatch_lines(["*avr-gcc is not installed: `apt install gcc-avr*"])


def test_a_pin_has_its_edges_and_its_level(bench: Callable[..., Bench]) -> None:
    made = bench({"bench": "b", "devices": {"u1": {"profile": "uno"}, "m1": {"profile": "mechaduino"}}})
    made.run(ms=100)
    pin = made.pin("u1.D8")
    assert (pin.level, pin.edges) == (0, [])
    made.port("u1").write(b"pin 8 1\n")
    made.run(ms=50)
    assert pin.level == 1
    assert [level for _, level in pin.edges] == [1]
    assert pin.edges == made.device("u1").pin("D8").edges()
    made.pin("m1.D2").set(0)
    with pytest.raises(KeyError, match="D99"):
        made.pin("u1.D99")
    with pytest.raises(KeyError, match="no device"):
        made.pin("u2.D1")
