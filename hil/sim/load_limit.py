"""Limit of the torque on a shaft, whoever sets it: the configuration, a command or a fault."""

import math
from collections.abc import Iterable

from hil.vocab.faults import MOST_LOADS


def load_problem(torque_Nm: object, holding_Nm: float, others_Nm: Iterable[float] = ()) -> str | None:
    """Error text for a torque on the shaft of a motor that holds ``holding_Nm``, beside others that are or
    will be there; or None.

    Torques that push the same way add up to the limit at most. One that pushes the other way does not count:
    it may end first.
    """
    most_Nm = MOST_LOADS * holding_Nm
    words = (
        f"write {-most_Nm:g} to {most_Nm:g}, {MOST_LOADS} times what this motor holds"
        f" ({holding_Nm:g} Nm): a larger torque only spins it"
    )
    if isinstance(torque_Nm, bool) or not isinstance(torque_Nm, int | float):
        return words
    beside_Nm = math.fsum(other_Nm for other_Nm in others_Nm if other_Nm * torque_Nm > 0)
    sum_Nm = beside_Nm + torque_Nm
    if abs(sum_Nm) <= most_Nm or math.isclose(abs(sum_Nm), most_Nm):
        return None
    return (
        f"with {beside_Nm:g} Nm that push the same way it is {sum_Nm:g}; in all {words}"
        if beside_Nm
        else words
    )
