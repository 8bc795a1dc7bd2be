"""The part of the reference about runs, written from the models that check them."""

from hil.config.reference_page import keys_table
from hil.runs.run_document import RunDocument


def run_reference() -> str:
    """Every key of a run, Markdown."""
    schema = RunDocument.model_json_schema()
    parts = schema["$defs"]
    sections = [
        "## Runs",
        "A run is YAML or JSON, for `hil run`, `run/submit` over zenoh, the client and the test kit.",
        keys_table(schema),
    ]
    for title, model in (
        ("Axes: `axes.<name>`", "AxisRules"),
        ("Steps: `steps`; each does one thing", "_Step"),
        ("`wait_until`", "WaitUntil"),
        ("`repeat`", "Repeat"),
        ("Points of a spline, beside `at_s` the angles of axes", "SplinePoint"),
    ):
        sections += [f"### {title}", keys_table(parts[model])]
    return "\n\n".join(sections) + "\n"
