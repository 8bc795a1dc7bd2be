"""Driver that steps by its pins, and its motor, without an encoder."""
