"""Records of tests in JUnit's XML have the bench in them."""

import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from hil import __version__

TEST = """
CONFIG = {"bench": "press", "devices": {"m1": {"profile": "mechaduino", "port": "memory"}}}

def test_two(bench):
    bench(CONFIG), bench(CONFIG | {"bench": "lathe"}, seed=3)

def test_none():
    pass

def test_fails(bench):
    bench(CONFIG)
    assert False
"""


@pytest.mark.long
def test_each_test_has_its_benches_as_properties(tmp_path: Path) -> None:
    (tmp_path / "test_inner.py").write_text(TEST)
    path = os.pathsep.join(filter(None, sys.path))
    env = os.environ | {"PYTHONPATH": path, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    words = ["-q", "-p", "hil.testing.plugin", "-p", "no:cacheprovider", "--junitxml=out.xml"]
    subprocess.run([sys.executable, "-m", "pytest", *words], env=env, cwd=tmp_path, capture_output=True)
    cases = {
        case.attrib["name"]: {each.attrib["name"]: each.attrib["value"] for each in case.iter("property")}
        for case in ET.parse(tmp_path / "out.xml").iter("testcase")
    }
    two = cases["test_two"]
    assert (two["hil.bench"], two["hil.bench.2"]) == ("press", "lathe")
    assert (two["hil.kind"], two["hil.version"], two["hil.seed.2"]) == ("virtual", __version__, "3")
    assert two["hil.config_digest"] == cases["test_fails"]["hil.config_digest"]
    assert two["hil.config_digest"] != two["hil.config_digest.2"]
    assert cases["test_none"] == {}
