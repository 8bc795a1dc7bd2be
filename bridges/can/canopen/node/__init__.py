"""CANopen nodes: what a device on a CAN bus answers, sends and keeps, in simulated time.

``canopen_node.py`` is a node; ``application.py`` the seam between it and its device profile: entries of the
object dictionary, and what the profile is told. Behind the node, ``network_management.py`` has its states
and joins its services, each in a file of its name; ``object_dictionary.py`` has the values,
``communication_entries.py`` the objects that every node has, ``parameter_store.py`` what is kept without
power.

Pure: frames and times come in as arguments, frames go out by a call. The node knows no axis.

Source: CiA 301 version 4.2.0 (application layer), CiA 305 version 2.2.0 (LSS), CiA 306-1 version 1.3.0 (EDS).

May import: bridges.can.canopen, bridges.can.frames, hil.vocab, hil.wire, the pure standard library.
"""
