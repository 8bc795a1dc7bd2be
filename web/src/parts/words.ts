/** Words of the page with their meanings, as docs/glossary.md has them; and the page's keys. */

export const WORDS: [string, string][] = [
  ["bench", "The devices, segments and doors that one configuration describes and one daemon serves."],
  ["device", "One board of the bench under its name: a twin, which hil emulates, or a real board."],
  ["axis", "One motor with its control law, driver, load and encoder."],
  ["port", "Where bytes of clients enter a board: a pseudo-terminal, a socket, a serial port. Each program that has it open is a client."],
  ["verb", "Something that can be asked of a device beside typing at it, with parameters in units and limits."],
  ["set-point", "Where the axis is told to be."],
  ["effort", "What the motor does about it: its torque on the shaft, in Nm."],
  ["gains", "Numbers of the control law. A step response shows what they do: how fast the shaft follows a step, and how far it overshoots."],
  ["pins", "Named inputs and outputs of a board, each low (0) or high (1)."],
  ["field", "A number of an axis under a name with a unit, such as position_deg."],
  ["run", "A document that moves several axes together. It is checked whole before anything moves."],
  ["following error", "How far a shaft is from where a run wants it."],
  ["fault", "Something that you break on purpose: a wire, a byte, a shaft. It lasts until it is cleared, or for its time."],
  ["simulated time", "The bench's own clock. All plots have it on their axis; it stands while the bench is late."],
  ["late", "How far the simulated time is behind the wall clock."],
  ["lag", "How far a board's firmware is behind the simulated time, in ms; and in the status, how late its work was done."],
  ["ok / late / failed", "Health of the bench: it keeps up and all boards run; answers come late; or something has stopped. A click says what, and what helps."],
  ["segment", "An RS485 wire with several stations."],
  ["role", "What you may do here: a viewer looks, an operator moves axes and starts runs, an admin also injects faults."],
];

export const KEYS: [string, string][] = [
  ["?", "this help"],
  ["1 … 9", "the views, from the left"],
  ["Tab", "from one control to the next; in a terminal Ctrl-] leaves it"],
  ["Space", "in a plot: pause, and go on"],
  ["+ / −", "in a plot: a shorter or longer time"],
  ["← / →", "in a plot: move cursor A; with Shift cursor B"],
  ["Home", "in a plot: back to the present"],
];
