"""Fields of a board's own: those of a board without a motor, and those beside an axis's."""
