"""CAN: all that this bus alone has, from bits on its wire to drives on it.

``frames`` are frames, as values, on an adapter's serial line and in files; ``bus`` is a wire with nodes, in
simulated time; ``canopen`` what CANopen makes of frames, on each side. ``cards`` are a bench's stations:
cards of axes, taps, nodes of channels; ``channels`` join programs and CAN interfaces outside to its bus, and
``bridge.py`` is the bridge that has these. ``can_drive_address.py`` reads where a real drive is.

May import: hil.core, hil.drives, hil.firmware, hil.net, hil.sim, hil.vocab, hil.wire, the standard library,
any package.
"""
