"""CAN: all that this bus alone has, from bits on its wire to drives on it.

``frames`` are frames, as values, on an adapter's serial line and in files; ``bus`` is a wire with nodes, in
simulated time; ``canopen`` what CANopen makes of frames, on each side. ``cards`` are a bench's stations:
cards of axes, taps, nodes of channels; ``channels`` join programs and CAN interfaces outside to its bus, and
``bridge.py`` is the bridge that has these, ``cli.py`` its commands. ``address`` reads where a real drive is;
``testing`` are its faces for the test kit. ``can_logs.py`` reads and writes logs of other programs, and puts
the frames of captures into words.
``bus_kind.py`` is what hil asks this folder for: keys of a configuration, their checks, their
wires.

May import: hil.config, hil.core, hil.drives, hil.firmware, hil.net, hil.sim, hil.testing, hil.vocab,
hil.wire, the standard library, any package.

Tests may import too: hil.compose.
"""
