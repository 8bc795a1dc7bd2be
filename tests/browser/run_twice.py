"""Browser tests, those that fail once more and alone; says which passed at the second try.

Chromium and benches share a computer's time, so a test may miss its deadline. One that needs a second try is
still a finding: the last line names it, and more than ``MOST_SHARE`` of them fail the whole.
"""

import json
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from pathlib import Path

MOST_SHARE = 0.03
"""Share of the tests that may need a second try, three in a hundred."""
FAILED = 1
"""Exit code of pytest if tests failed, and nothing else is wrong."""
CACHE = Path(".pytest_cache/web")
FAILURES, REPORT = CACHE / "v/cache/lastfailed", CACHE / "first_try.xml"


def last_line(needed: Sequence[str], count: int) -> tuple[str, int]:
    """Last line and exit code of a run in which all of ``count`` tests passed, and ``needed`` at the second
    try."""
    if not needed:
        return f"All {count} passed at the first try.", 0
    said = f"{len(needed)} of {count} passed at the second try: {', '.join(needed)}"
    if len(needed) > MOST_SHARE * count:
        return f"{said}. That is more than {MOST_SHARE:.0%}: mend what they wait for.", FAILED
    return said, 0


def _pytest(*options: str) -> int:
    command = [sys.executable, "-m", "pytest", "-q", "-o", f"cache_dir={CACHE}", "-rs", *options]
    return subprocess.run(command, check=False).returncode


def _failed() -> list[str]:
    return sorted(json.loads(FAILURES.read_text())) if FAILURES.exists() else []


def _count() -> int:
    """Number of the tests that were carried out."""
    suite = ElementTree.parse(REPORT).find("testsuite")
    return int(suite.get("tests", 0)) - int(suite.get("skipped", 0)) if suite is not None else 0


def main(files: Sequence[str]) -> int:
    FAILURES.unlink(missing_ok=True)
    side_by_side = ("--dist", "loadfile", "--no-loadscope-reorder", "-n", "2")
    code = _pytest(*side_by_side, f"--junit-xml={REPORT}", *files)
    needed, count = _failed(), _count()
    if code == FAILED and needed:
        print("Once more, alone: Chromium and benches share this computer's time.", flush=True)
        code = _pytest("--last-failed", "--last-failed-no-failures", "none", *files)
    if code:
        return code
    said, code = last_line(needed, count)
    print(said, flush=True)
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
