"""Texts of the board, apart from numbers. CR LF is added where a line is printed.

Titles, prompts, labels and everything else that a program could look for are the board's, letter for letter;
lines of plain explanation are our own words, one for each of the board's.
"""

BANNER = ("", "", "----- Mechaduino 0.X -----", "Firmware: 0.1.5")
MENU_HEAD = ("", "Main menu", "")
SPI_START = "Beginning SPI communication with AS5047 encoder..."
EMPTY_TABLE = "WARNING: Lookup table is empty! Run calibration"

K_HINT = "kept in RAM only, so they are back at their defaults after the next power-up"
"""Explanation behind the menu's entry for k."""

MAIN_EDIT_MENU = (
    "",
    "Edit parameters:",
    "",
    "p ----- position loop",
    "v ----- velocity loop",
    "o ----- other",
    "q ----- quit",
    "",
)
DONE = ("", "done...", "")

SINE_INTRO = (
    "",
    "What follows is a sine table for the commutation of the two coils, one entry for each 0.1 degree.",
    "Other wave shapes can be tried by changing its entries.",
    "In the firmware's sources it is the array sine_1.",
    "",
)
SINE_HEAD = ("Printing sine look up table:...", "")

STEP_RESPONSE_INTRO = (
    "",
    "--------------------------------",
    "",
    "Get ready for step response!",
    "Close Serial Monitor and open Tools>>Serial Plotter",
    "You have 10 seconds...",
)

ANTICOGGING_BEGIN = " -----------------BEGIN ANTICOGGING CALIBRATION!----------------"
ANTICOGGING_REVERSE = " -----------------REVERSE!----------------"
ANTICOGGING_DONE = " -----------------DONE!----------------"

CALIBRATION_BEGIN = "Beginning calibration routine..."
WIRED_BACKWARDS = "Wired backwards"
CALIBRATION_DONE = (
    " ",
    " ",
    "Calibration complete!",
    "The calibration table has been written to non-volatile Flash memory!",
    " ",
    " ",
)

DIAGNOSTICS_INTRO = (
    "------------------------------------------------",
    "Checking AS5047 diagnostic and error registers",
    "See AS5047 datasheet for details",
    " ",
)
DIAAGC_HEAD = "Check DIAAGC register (0x3FFC) ...   "
ERRFL_HEAD = "Check ERRFL register (0x0001) ...   "
ERROR_BIT = 14
"""Bit EF in a frame: the encoder saw an error (AS5047D data sheet, SPI read frame)."""
DIAAGC_LINES = {
    ERROR_BIT: "  Error occurred  ",
    11: "  MAGH - the magnet's field is too strong, the gain control is at 0x00; angles may be less linear",
    10: "  MAGL - the magnet's field is too weak, the gain control is at 0xFF; angles may be noisier",
    9: "  COF - overflow in the CORDIC; the measured angle cannot be trusted",
    8: "  LF - the offset compensation that starts at power-up has finished",
}
"""Lines by bit of the DIAAGC frame, in the board's order."""
DIAAGC_FAULTS = (ERROR_BIT, 11, 10, 9)
ERRFL_LINES = {
    ERROR_BIT: "  Error occurred  ",
    2: "  parity error ",
    1: "  invalid register  ",
    0: "  framing error  ",
}
LOOKS_GOOD = "Looks good!"
