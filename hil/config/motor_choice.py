"""Motor of the catalogue in place of a profile's."""

from collections.abc import Mapping

from hil.config.motors import MOTORS, own_figures
from hil.core.kinds import KINDS


def with_motor(parameters: Mapping[str, float], motor: str, plant: str, law: str) -> dict[str, float]:
    """Put a motor of the catalogue into the parameters of an axis. A driver whose current is a parameter is
    set to the motor's rated current."""
    own, kind = own_figures(motor, plant), KINDS.get(law)
    if kind and kind.driver_A:
        own[kind.current_parameter] = MOTORS[motor].rated_A
    return {name: own.get(name, value) for name, value in parameters.items()}
