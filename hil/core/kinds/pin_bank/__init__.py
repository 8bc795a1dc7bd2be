"""Pins of a microcontroller, each an input or an output, and no motor."""
