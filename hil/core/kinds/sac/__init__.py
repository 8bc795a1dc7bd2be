"""Stepper: a motion engine that makes step pulses for a driver, without an encoder."""
