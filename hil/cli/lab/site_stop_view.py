"""``hil stop --site``: the stop of all that moves on all benches of a site, and who has confirmed it."""

from typing import Any

from hil.cli.framework.ask import BenchOptions
from hil.cli.framework.command_answers import CommandAnswer
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.progress_bars import bar
from hil.cli.lab.lab_options import LabOptions

HALT_S = 10.0
"""Further time for the answer of the bench here, whose real boards have five seconds to confirm."""


def stop_site(bench: BenchOptions, lab: LabOptions, timeout_s: float, how: str) -> CommandAnswer:
    """Stop a site: the benches of a lab, or those that are joined to one here."""
    with bar("benches confirm that they stop"):
        if lab.are_given:
            with lab.opened() as session:
                rows = session.stop(how, answer_s=timeout_s)
        else:
            wait_s = timeout_s + HALT_S
            rows = bench.ask("stop_site", how=how, within_s=timeout_s, timeout_s=wait_s)["benches"]
    confirmed = [row for row in rows if row["state"] == "confirmed"]
    said = [_line(row) for row in rows]
    said.append(f"{len(confirmed)} of {len(rows)} benches have confirmed" if rows else "no bench is there")
    is_done = rows and len(confirmed) == len(rows) and not any(row["refused"] for row in rows)
    return CommandAnswer({"benches": rows}, "\n".join(said), Exit.DONE if is_done else Exit.FAILED)


def _line(row: dict[str, Any]) -> str:
    if row["state"] != "confirmed":
        return f"{row['bench']}: NOT CONFIRMED: {row['why']}"
    done = [f"run {name} cancelled" for name in row["runs"]] + [f"{name} stops" for name in row["stopped"]]
    what = ", ".join(done) or "nothing moves"
    line = f"{row['bench']}: confirmed after {row['took_s'] * 1e3:.0f} ms: {what}"
    return "\n".join([line, *(f"  {name}: not stopped: {why}" for name, why in row["refused"].items())])
