"""A stepper motor with a TMCL module: a real one, or a twin that is a closed-loop servo."""
