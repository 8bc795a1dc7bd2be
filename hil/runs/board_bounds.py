"""Bounds of what a run asks of boards: those of the verbs by which it moves and stops them."""

from collections.abc import Iterator, Mapping

from hil.config.document import Finding
from hil.runs.run_document import AxisRules, RunDocument
from hil.vocab.axis import AxisNow
from hil.vocab.parameters import Parameter, plain
from hil.vocab.verbs import Verb

LIMITS = {"velocity_rpm": "rpm", "acceleration_rpm_per_s": "rpm/s"}
"""Limits of a run's axes that boards have bounds for, with their units."""
WHOLE_RPM = Parameter("velocity_rpm", "", minimum=1, is_whole=True)
"""Speeds of a board that says nothing of them."""
_ASKED = ("position_deg", *LIMITS)


def bounds_of(verbs: Mapping[str, Verb], *, follows_paths: bool) -> dict[str, Parameter]:
    """Find the bounds of a board with these verbs: of its stop, and of the verb that sends it to an angle if
    it follows no paths."""
    used = [verbs[name] for name in (("stop",) if follows_paths else ("stop", "move_abs")) if name in verbs]
    return {each.name: each for verb in used for each in verb.parameters if each.name in _ASKED}


def fitted(run: RunDocument, axes: Mapping[str, AxisNow]) -> RunDocument:
    """Let the limits that nobody chose be such that the boards take them."""

    def of_axis(name: str, rules: AxisRules) -> AxisRules:
        bounds = axes[name].bounds
        chosen = {
            key: bound.maximum if bound.default is None else float(bound.default)
            for key, bound in bounds.items()
            if key in LIMITS.keys() - rules.model_fields_set and not _is_within(getattr(rules, key), bound)
        }
        return rules.model_copy(update=chosen) if chosen else rules

    return run.model_copy(update={"axes": {name: of_axis(name, rules) for name, rules in run.axes.items()}})


def bound_findings(run: RunDocument, axes: Mapping[str, AxisNow]) -> Iterator[Finding]:
    """Find the limits that boards do not take."""
    for name, rules in run.axes.items():
        for key, unit in LIMITS.items():
            bound = axes[name].bounds.get(key)
            if bound and not _is_within(getattr(rules, key), bound):
                least, most = plain(bound.minimum), plain(bound.maximum)
                what = f"{name} takes {least} to {most} {unit}"
                yield Finding(("axes", name, key), what, f"write {least} to {most}, or leave it out")


def _is_within(value: float, bound: Parameter) -> bool:
    return bound.minimum <= value <= bound.maximum
