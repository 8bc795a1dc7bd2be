"""The Mechaduino closed-loop stepper servo with firmware 0.1.5.

``profile.yaml`` describes the board, its motor and encoder; ``firmware.py`` is its program.
"""
