"""The shipped test kit: benches on the virtual clock, for pytest and for scripts.

``Bench`` is a whole bench in memory; ``replay`` runs an input log again; ``replay_control`` runs a
control law over recorded encoder counts. Public and stable: changes stand in the CHANGELOG.

May import: hil.compose, hil.config, hil.core, hil.firmware, hil.runs, hil.sim, hil.telemetry, hil.vocab,
hil.wire, the standard library, numpy, pytest.

Tests may import too: device_profiles.
"""

from hil.compose.replay import Replayed, replay
from hil.config import ConfigError
from hil.testing.bench import Bench
from hil.testing.control import replay_control

__all__ = ["Bench", "ConfigError", "Replayed", "replay", "replay_control"]
