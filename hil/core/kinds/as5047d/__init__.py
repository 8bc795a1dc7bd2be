"""Encoder without a motor: it reads a magnet on the shaft of another axis."""
