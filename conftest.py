"""Settings of all tests."""

from hypothesis import HealthCheck, settings

# The time of an example depends on what else this machine does.
settings.register_profile("hil", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("hil")
