"""Numbers of the blocks of a register map. They are a promise: what is there keeps its number, and what is
new takes a free one."""

VERSION = 1
"""Version of this layout, input register 0."""

# Input registers.
FIELDS_AT = 1000
"""Fields of the axis, each at this plus half of its offset in the binary layout; those that may be set are
holding registers of the same number."""

# Holding registers.
CONTROL_AT = 0
COMMAND_AT = 11
ARGUMENTS_AT = 12
ARGUMENT_REGISTERS = 32
PARAMETERS_AT = 2000
PER_VERB = 32
"""Registers of a verb's parameters: verb n begins at ``PARAMETERS_AT + n * PER_VERB``."""
PER_PARAMETER = 2

# Coils.
STARTS_AT = 0
RESET_AT = 99
VERBS = 96
"""Maximum number of verbs: their coils end before that of ``RESET_AT``."""
INPUTS_AT = 100
PINS = 100

# Discrete inputs.
DONE_AT = 0
PINS_AT = 100
STATUS_AT = 200
REFUSED_AT = 300

CONTROL = ("enable", "disable", "stop", "reset")
"""Verbs that a bit of the control word starts, from bit 0 on."""
STATUS = (
    ("on", "it would move if it were told to: its loop, if it has one, is on"),
    ("moving", "it moves by what it was given"),
    ("under_way", "a motion with an end has not ended"),
    ("keeps_angle", "a loop keeps the shaft at an angle"),
    ("stopped", "the board's firmware has stopped"),
    ("busy", "the motion of a verb that was started here has not ended"),
    ("refused", "a verb that was started here was refused, or something else ended its motion"),
)
"""Bits of the status word, from bit 0 on, with their meanings."""
