"""Servo: a closed loop with an encoder, driven by step and direction or by set-points."""
