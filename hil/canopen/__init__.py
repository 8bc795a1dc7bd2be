"""CANopen nodes: what a device on a CAN bus answers, sends and keeps, in simulated time.

``application.py`` is the seam between a node and its device profile: entries of the object dictionary, and
what the profile is told. ``abort_codes.py`` says why an SDO transfer ends.

Pure: frames and times come in as arguments, frames go out by a call. The node knows no axis.

Source: CiA 301 version 4.2.0 (application layer), CiA 305 version 2.2.0 (LSS), CiA 306-1 version 1.3.0 (EDS).

May import: hil.vocab, hil.wire, the pure standard library.
"""
