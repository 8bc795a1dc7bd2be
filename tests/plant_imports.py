"""Run in a copy of the tree: plants modules, and says what the contracts find then.

Reads a JSON object of texts by path from its input, and writes one list of problems for the tree as it is and
one for the tree with all plants.
"""

import json
import sys
from pathlib import Path

from importlinter.application import use_cases
from importlinter.application.use_cases import create_report, read_user_options
from importlinter.configuration import configure


def problems() -> list[str]:
    report = create_report(read_user_options("pyproject.toml"), cache_dir=".cache")
    assert not report.invalid_contract_options, report.invalid_contract_options
    return [
        problem for _, check in report.get_contracts_and_checks() for problem in check.metadata["problems"]
    ]


def plant(files: dict[str, str]) -> None:
    for name, text in files.items():
        path = Path(name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


if __name__ == "__main__":
    sys.path.insert(0, ".")
    configure()
    if register := getattr(use_cases, "_register_contract_types", None):  # versions before 2.17
        register(read_user_options("pyproject.toml"))
    before = problems()
    plant(json.load(sys.stdin))
    answer = json.dumps([before, problems()])
    print(f"\n{answer}")
