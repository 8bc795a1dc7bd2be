"""The AS5047D: a magnetic encoder on a shaft, which a board reads over SPI.

``profile.yaml`` describes the chip, ``board.py`` what hil asks it for. The native law ``as5047d`` has its
pins, its frames and its registers.
"""
