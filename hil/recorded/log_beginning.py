"""Beginning of a log, up to an input or a reload of its bench."""

from dataclasses import replace

from hil.recorded.time_words import time_text
from hil.sim.input_log import InputLog


def beginning(log: InputLog, inputs: int, at_ns: int, why: str) -> InputLog:
    """Take the first inputs of a log, and what was sent before a time. ``why``: reason, for people."""
    sent = [piece for piece in log.sent if piece.at_ns < at_ns]
    reloads = [
        place._replace(sent=min(place.sent, len(sent))) for place in log.reloads if place.reload.at_ns < at_ns
    ]
    return replace(
        log,
        inputs=log.inputs[:inputs],
        lines=log.lines[:inputs],
        sent=sent,
        reloads=reloads,
        cut=why,
        end_ns=max(min(log.end_ns, at_ns - 1), 0),
    )


def before_reload(log: InputLog) -> InputLog:
    """Take a log up to the first reload of its bench, all of one without."""
    if not log.reloads:
        return log
    place = log.reloads[0]
    why = f"the bench was reloaded at {time_text(place.reload.at_ns)}, and only what was before is looked at"
    return beginning(log, place.inputs, place.reload.at_ns, why)
