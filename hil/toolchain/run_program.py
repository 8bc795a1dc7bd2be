"""Programs that are run to their end."""

import subprocess
from collections.abc import Mapping, Sequence


def run_program(words: Sequence[str], env: Mapping[str, str]) -> "subprocess.CompletedProcess[str]":
    """Run a program, in English, without input."""
    return subprocess.run(
        words,
        env={**env, "LC_ALL": "C"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
