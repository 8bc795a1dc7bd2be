"""Configuration that ``hil init`` writes: it runs as it is, and says in comments what else there is."""

from string import Template

_TEXT = """\
# yaml-language-server: $$schema=$SCHEMA
# A bench of hil: virtual boards behind real serial ports. The line above tells editors of the keys.
#   hil check FILE    lists what is wrong with it
#   hil serve FILE    runs it until Ctrl-C
#   hil docs ports    describes ports; hil docs lists all pages

# The bench's name: commands find it by that, and ports stand in a folder of that name.
bench: $NAME

devices:
  # A Mechaduino, a servo motor with a terminal. Its port is a pseudo-terminal; hil list says where.
  m1:
    profile: mechaduino # hil profile list names all kinds of boards
    # port: {kind: tcp, port: 7001} # a TCP port instead, for socket://127.0.0.1:7001
    # flash: {table: identity} # calibrated from the start
    # axis: {load_torque_Nm: 0.02} # what is at its shaft; hil docs reference has all keys

  # A stepper controller with a command line of its own.
  s1:
    profile: sac
    # baud: 38400

# What goes wrong from the start on; hil fault inject does it in a running bench. hil fault kinds lists all.
# faults:
#   - {fault: byte_drop, target: m1, rate: 0.01}

# Other programs reach the axes through bridges: zenoh, Modbus, metrics, CAN.
# bridges:
#   modbus: {}

# Same seed and same inputs, same bytes.
# seed: 0
"""


def first_bench(name: str, schema: str) -> str:
    """Write a configuration of a bench. ``schema``: name of the schema's file beside it."""
    return Template(_TEXT).substitute(NAME=name, SCHEMA=schema)
