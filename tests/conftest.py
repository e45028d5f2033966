"""What all tests share: hypothesis without a clock, because the first call of compiled code takes seconds."""

from hypothesis import HealthCheck, settings

settings.register_profile("house", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("house")
