"""Samples of axes while they run: for those who watch, as series, figures, pictures.

``sampler.py`` hands samples to any number of watchers; ``recording.py`` is a series; ``step_response.py`` its
figures; ``text_plot.py`` and ``picture.py`` draw it.

May import: hil.core, hil.vocab, the standard library, matplotlib, plotext.

Tests may import too: hil.compose, hil.config, hil.sim, hil.testing, hil.wire.
"""

from hil.telemetry.recording import Recording, check_signals
from hil.telemetry.sampler import Sampler, Subscription
from hil.telemetry.step_response import other_motion, step_response

__all__ = [
    "Recording",
    "Sampler",
    "Subscription",
    "check_signals",
    "other_motion",
    "step_response",
]
