"""Values of a drive, with their meanings."""

TOLD = {
    "position_deg": "angle of the shaft",
    "velocity_rpm": "speed of the shaft",
    "current_A": "current of the motor",
    "fault_code": "number of a fault; 0: none",
}
"""Values that a drive tells, with their meanings."""
TAKEN = {
    "set_point_deg": "target of a move, or the set-point that is followed",
    "set_velocity_rpm": "largest speed on the way to a target",
    "acceleration_rpm_per_s": "acceleration of the ramps on the way to a target",
}
"""Values that a drive takes, with their meanings."""
