"""A serial port over the network as RFC 2217 has it: baud, break and modem lines beside the bytes."""
