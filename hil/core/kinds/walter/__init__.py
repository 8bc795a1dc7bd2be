"""Joint that pulses turn through a gear, or a servo at once; a board has several, and one main loop."""
