/** Types of what the door tells and takes. Written by `make web-types` from page_rows.py of the
 * door, the table of operations and hil/net/answers.py: change those. */

export const SAMPLES = 1;
export const SAMPLES_HEAD = 16;
export const TERMINAL = 2;
export const TERMINAL_HEAD = 8;
export const TIMED = 3;
export const TIMED_HEAD = 16;

export type Role = "viewer" | "operator" | "admin";
export type WatchKind = "samples" | "packets" | "frames" | "bytes" | "runs" | "events" | "status" | "faults" | "clock";

/** Parameter of a verb, a fault or an operation. ``text``: values, unit and default, in one line. */
export interface ParameterRow {
  name: string;
  summary: string;
  unit: string;
  type: "number" | "whole" | "text" | "choice" | "other";
  form?: string;
  choices?: string[];
  minimum?: number;
  maximum?: number;
  limits?: string;
  default: number | string | null;
  is_optional: boolean;
  text: string;
}

/** Verb of a device. */
export interface VerbRow {
  summary: string;
  role: Role;
  parameters: ParameterRow[];
}

/** Field of an axis. */
export interface FieldRow {
  name: string;
  type: string;
  unit: string;
  meaning: string;
  is_settable: boolean;
  is_state: boolean;
}

/** Device, with its first axis, or a further axis of one. ``inputs``: pins that may be driven, and the
 * field that tells each one's level, or a bit of one (``pin_levels.13``); empty: none does. */
export interface DeviceRow {
  name: string;
  profile: string;
  is_real: boolean;
  is_seen: boolean;
  verbs: Record<string, VerbRow>;
  fields: FieldRow[];
  inputs: Record<string, string>;
}

/** Kind of fault. ``title``: what happens, in a few words; ``on``: its target in words. */
export interface FaultKindRow {
  name: string;
  title: string;
  layer: string;
  target: string;
  on: string;
  summary: string;
  is_once: boolean;
  parameters: ParameterRow[];
}

/** Segment. ``framing``: sac, modbus_rtu, or another that a profile brings. */
export interface LineRow {
  name: string;
  framing: string;
  baud: number;
  format: string;
}

/** Operation of the table. */
export interface OperationRow {
  target: string;
  target_summary: string;
  summary: string;
  role: Role;
  takes_time: boolean;
  parameters: ParameterRow[];
}

/** Description of a bench without its devices. */
export interface BenchRow {
  protocol: number;
  version: string;
  bench: string;
  segments: LineRow[];
  buses: string[];
  ports: string[];
  operations: Record<string, OperationRow>;
  fault_kinds: FaultKindRow[];
}

/** First message to a page. ``instance``: another one for each start of the bench; ``message_bytes``:
 * limit of a page's messages. */
export interface Greeting {
  protocol: number;
  version: string;
  bench: string;
  segments: LineRow[];
  buses: string[];
  ports: string[];
  operations: Record<string, OperationRow>;
  fault_kinds: FaultKindRow[];
  instance: string;
  message_bytes: number;
  user: string;
  role: Role;
  devices: DeviceRow[];
}

/** Answer of ``watch``: its number. */
export interface WatchAnswer {
  watch: number;
}

/** Answer of ``open``: number of the terminal, and of other programs that have the port open. */
export interface TerminalAnswer {
  terminal: number;
  clients: number;
}

/** Answer of ``export``: a capture, and the number of its records. */
export interface ExportAnswer {
  pcapng_base64: string;
  events: number;
}

/** Field of a packet: its value in words, and the bytes from ``begin`` to before ``end``; equal: none. One
 * of a higher ``level`` is a part of the field before it. */
export interface PacketFieldRow {
  name: string;
  text: string;
  begin: number;
  end: number;
  level: number;
}

/** Answer of ``fields``. */
export interface FieldsAnswer {
  fields: PacketFieldRow[];
}

/** Operations by name: what each is given, and what it answers. */
export interface Operations {
  /** the bench's devices, with the addresses of their ports */
  list: { given: Record<string, never>; answer: { bench: string; pid: number; devices: ({ device: string; profile: string; hardware: string; port: string | null; greeting: string; address: string | null; clients: number; network: null; ports: Record<string, { kind: string; address: string; clients: number }>; axes: string[]; failed: string | null } | { device: string; profile: string; hardware: string; port: string | null; greeting: string; address: string | null; clients: number; network: string; ports: Record<string, { kind: string; address: string; clients: number }>; axes: string[]; failed: string | null; network_clients: number })[]; taps: { tap: string; kind: string; port: string; clients: number }[]; nodes: { node: string; id: number; bus: string }[] } };
  /** health, ticks, missed wakes, histograms, and for each device counters and a snapshot */
  status: { given: Record<string, never>; answer: { bench: string; pid: number; devices: ({ device: string; profile: string; hardware: string; port: string | null; greeting: string; address: string | null; clients: number; network: string | null; ports: Record<string, { kind: string; address: string; clients: number }>; axes: string[]; failed: string | null; rx_bytes: number; tx_bytes: number; dropped_bytes: number; overrun_bytes: number; note: string | null; port_failure: string | null; flash: string; snapshot: null | { position_deg: number; velocity_rpm: number; motion_state: 0 | 1 | 2 | 3 | 4 } | { position_deg: number; velocity_rpm: number; mode: 0 | 32 | 33 | 34 | 35 | 36 | 37 | 38 | 39 | 40 | 41 | 42 | 43 | 44 | 45 | 46 | 47 | 48 | 49 | 50 | 51 | 52 | 53 | 54 | 55 | 56 | 57 | 58 | 59 | 60 | 61 | 62 | 63 | 64 | 65 | 66 | 67 | 68 | 69 | 70 | 71 | 72 | 73 | 74 | 75 | 76 | 77 | 78 | 79 | 80 | 81 | 82 | 83 | 84 | 85 | 86 | 87 | 88 | 89 | 90 | 91 | 92 | 93 | 94 | 95 | 96 | 97 | 98 | 99 | 100 | 101 | 102 | 103 | 104 | 105 | 106 | 107 | 108 | 109 | 110 | 111 | 112 | 113 | 114 | 115 | 116 | 117 | 118 | 119 | 120 | 121 | 122 | 123 | 124 | 125 | 126; loop_on: number } | { position_deg: number; velocity_rpm: number; to_be_deg: number; is_enabled: 0 | 1 } | { position_deg: number; velocity_rpm: number; outputs_on: number; microsteps: number } | { enabled: number; age_ms: number }; snapshots: Record<string, null | { position_deg: number; velocity_rpm: number; motion_state: 0 | 1 | 2 | 3 | 4 } | { position_deg: number; velocity_rpm: number; mode: 0 | 32 | 33 | 34 | 35 | 36 | 37 | 38 | 39 | 40 | 41 | 42 | 43 | 44 | 45 | 46 | 47 | 48 | 49 | 50 | 51 | 52 | 53 | 54 | 55 | 56 | 57 | 58 | 59 | 60 | 61 | 62 | 63 | 64 | 65 | 66 | 67 | 68 | 69 | 70 | 71 | 72 | 73 | 74 | 75 | 76 | 77 | 78 | 79 | 80 | 81 | 82 | 83 | 84 | 85 | 86 | 87 | 88 | 89 | 90 | 91 | 92 | 93 | 94 | 95 | 96 | 97 | 98 | 99 | 100 | 101 | 102 | 103 | 104 | 105 | 106 | 107 | 108 | 109 | 110 | 111 | 112 | 113 | 114 | 115 | 116 | 117 | 118 | 119 | 120 | 121 | 122 | 123 | 124 | 125 | 126; loop_on: number } | { position_deg: number; velocity_rpm: number; to_be_deg: number; is_enabled: 0 | 1 } | { position_deg: number; velocity_rpm: number; outputs_on: number; microsteps: number } | { enabled: number; age_ms: number }> })[]; taps: { tap: string; kind: string; port: string; clients: number }[]; nodes: { node: string; id: number; bus: string }[]; health: { state: string; late_ms: number; problems: { kind: string; about: string; what: string; remedy: string }[] }; bridges: Record<string, { root: string; listen: string[]; connect: string[]; links: number; commands: number; rejected: number; dropped: number; insecure: true | false }>; echoes: Record<string, { state: string; bytes: number; collisions: number }>; segments: ({ segment: string; stations: Record<string, unknown>; load: number; packets: number; collisions: number; errors: Record<string, number>; nodes: Record<string, { unit: number; requests: number; answers: number; exceptions: number; refusal: string | null }>; notes: string[] })[]; buses: { bus: string; bit_rate: number; load_percent: number; frames: number; errors: Record<string, number>; nodes: Record<string, { sent: number; heard: number; transmit_errors: number; receive_errors: number; state: string; errors: Record<string, number> }>; drives: Record<string, { id: number; state: string }>; notes: string[] }[]; switches: ({ switch: string; axis: string; to: string | null; is_active: true | false })[]; faults: { number: number; kind: string; target: string; parameters: Record<string, unknown>; begin_ns: number }[]; runs: ({ run: string; state: string; step: number; steps: number; why: string | null; left_s: number | null })[]; recording: { forked_from: string | null; path: string | null; problem: string | null; before: null | { path: string; end: string; show: string } }; is_paused: true | false; rt_line: string; speed: number; wake_latency: number[]; lag: number[]; lease: null | { user: string; why: string; doors: string[]; closed: string[]; undelivered: Record<string, number>; since_wall_ns: number; until_wall_ns: number; left_s: number }; rate_hz: number; sim_ns: number; elapsed_ns: number; ticks: number; missed: number; overruns: number } };
  /** whether the bench is well, and what is wrong */
  health: { given: Record<string, never>; answer: { state: string } };
  /** each segment's stations, taps and counters */
  segments: { given: Record<string, never>; answer: ({ segment: string; stations: Record<string, unknown>; load: number; packets: number; collisions: number; errors: Record<string, number>; nodes: Record<string, { unit: number; requests: number; answers: number; exceptions: number; refusal: string | null }>; notes: string[] })[] };
  /** each CAN bus's nodes, taps and counters */
  buses: { given: Record<string, never>; answer: { bus: string; bit_rate: number; load_percent: number; frames: number; errors: Record<string, number>; nodes: Record<string, { sent: number; heard: number; transmit_errors: number; receive_errors: number; state: string; errors: Record<string, number> }>; drives: Record<string, { id: number; state: string }>; notes: string[] }[] };
  /** what the bench is and how it does: versions, host, labels, devices, health, runs, who commands */
  about: { given: Record<string, never>; answer: { bench: string; version: string; host: string; config_digest: string; protocol: number; labels: Record<string, string>; devices: Record<string, { profile: string; axes: string[]; is_real: true | false }>; lease: null | { user: string; why: string; since_wall_ns: number; until_wall_ns: number }; health: { state: string; problems: { kind: string; about: string; what: string; remedy: string }[]; problems_left_out: number }; runs: ({ run: string; state: string; step: number; steps: number; why: string | null })[]; commanders: { who: string; what: string; of: string; wall_ns: number }[]; metrics: string; recording: string | null } };
  /** the other benches that are joined, and their clocks */
  benches: { given: Record<string, never>; answer: ({ bench: string; why: string } | { bench: string; why: null; version: string; clock_offset_ns: number; clock_error_ns: number })[] };
  /** verbs of a device, with their parameters */
  verbs: { given: Record<string, never>; answer: { verb: string; about: string; parameters: Record<string, string>; texts: string[] }[] };
  /** all fields of an axis, now */
  state: { given: Record<string, never>; answer: Record<string, number | null> };
  /** read a text of a board as data: what its terminal says, or a file of its own; answers what is wrong, as a text, if it is none */
  read_text: { given: { reader: string; text: string; file?: string }; answer: string | Record<string, unknown> };
  /** the register map that doors of Modbus have of a device */
  registers: { given: Record<string, never>; answer: { device: string; profile: string; version: number; crc: number; notes: string[]; rows: ({ table: string; type: string; name: string; unit: string; about: string; address: number; registers: number; is_writable: true | false })[] } };
  /** the electronic data sheet of an axis's CANopen node */
  eds: { given: Record<string, never>; answer: { node: string; text: string } };
  /** switch the power off and on; what is in the flash stays */
  reset: { given: Record<string, never>; answer: Record<string, unknown> };
  /** drive an input */
  pin: { given: { pin: string; level: number }; answer: Record<string, unknown> };
  /** set a load, an encoder register or a gain (see Fields of an axis) */
  set: { given: { field: string; value: unknown }; answer: Record<string, unknown> };
  /** let the shaft's angle, position_deg, be 0 here; nothing turns, and the board knows nothing of it */
  zero: { given: Record<string, never>; answer: { effective_at_ns: number; was_deg: number; board_deg: number | null } };
  /** type at the board's serial interface, as a client does */
  type: { given: { text: string }; answer: Record<string, unknown> };
  /** type bytes at a serial interface (s1.network: the second one), as a client does */
  send: { given: { data: string }; answer: Record<string, unknown> };
  /** carry out a verb of the device (see Verbs); the verb's role counts */
  do: { given: { name: string; parameters: Record<string, unknown> }; answer: Record<string, string | number | true | false | null | unknown[] | Record<string, unknown>> };
  /** wait until a verb's motion has ended; answers whether something else ended it */
  wait: { given: { effective_at_ns: number; ends_after_ns?: number; set_point?: number; at_most_s?: number }; answer: { interrupted: true | false } };
  /** play a pulse train on the step/dir inputs */
  drive: { given: { train: unknown }; answer: { effective_at_ns: number; length_ns: number } };
  /** send bursts on a segment, or to the adapter on a CAN bus */
  play: { given: { bursts: unknown }; answer: Record<string, unknown> };
  /** what is in a device's processor: its program, registers, SRAM, pins, and who is wired to those */
  processor: { given: Record<string, never>; answer: { device: string; program: string; flash: string; data: string; crystal_Hz: number; cycles: number; pc: number; stack_lowest: number; is_running: true | false; is_halted: true | false; pins: Record<string, { level: number; is_output: true | false; has_pull_up: true | false; duty: number | null; wired: string[] }>; symbols: ((string | number)[])[] } };
  /** load a program into a device's processor and memory; it starts as after a power-up */
  load_program: { given: { program: string; file?: string }; answer: { effective_at_ns: number; program: string } };
  /** count from now on where a processor's time goes; meanwhile it takes the computer more time */
  count: { given: { starts: unknown; lap_at?: number }; answer: Record<string, unknown> };
  /** cycles since `count`, those in each function with its calls, and cycles from one time at lap_at to the next, the latest 1,024 */
  counted: { given: Record<string, never>; answer: { cycles: number; rows: number[][]; laps: number[] } };
  /** put a node without a device on a CAN bus; answers its address, and how many frames it takes */
  attach: { given: { node: string }; answer: { effective_at_ns: number; node: string; free: number } };
  /** take such a node off its bus */
  detach: { given: Record<string, never>; answer: Record<string, unknown> };
  /** send frames from such a node; answers how many were refused, and how many it takes now */
  transmit: { given: { frames: string[] }; answer: { effective_at_ns: number; refused: number; free: number } };
  /** the recording of this run: its length, and marks of what happened, unless `revision` is theirs */
  past: { given: { revision?: number; most?: number }; answer: { end_ns: number; ready_ns: number; is_growing: true | false; problem: string; begun: string | null; speed: number; revision: number; marks: ({ lane: string; from_ns: number; to_ns: number | null; of: string; text: string })[] } | { end_ns: number; ready_ns: number; is_growing: true | false; problem: string; begun: string | null; speed: number; revision: number; marks?: undefined } };
  /** all axes, and the faults, at a time of this run */
  past_state: { given: { at_s: number; lane?: string }; answer: { at_ns: number; axes: Record<string, Record<string, number | null>>; failed: Record<string, string>; faults: { number: number; kind: string; target: string; parameters: Record<string, unknown>; begin_ns: number }[] } };
  /** fields over a window of this run: each step, or the smallest and the largest of each interval */
  past_samples: { given: { fields: string[]; from_s: number; to_s: number; points?: number; lane?: string }; answer: { at_ns: number; from_ns: number; interval_ns: number; series: ({ axis: string; fields: string[]; is_summed: true | false; rows: number; data: string })[] } };
  /** the last bytes at a port before a time of this run, both ways */
  past_bytes: { given: { port: string; at_s: number; lane?: string }; answer: { at_ns: number; items: ({ at_s: number; to: "board" | "client"; hex: string })[] } };
  /** the last packets or frames of a wire before a time of this run */
  past_packets: { given: { wire: string; at_s: number; lane?: string }; answer: { at_ns: number; items: Record<string, unknown>[]; left_out: number } };
  /** the time at which a condition begins to hold, within ten minutes of this run */
  past_find: { given: { condition: string; from_s: number; back?: boolean; lane?: string }; answer: { found_ns: number | null; looked_from_ns: number; looked_to_ns: number; end_ns: number } };
  /** inject a fault; answers its number */
  inject: { given: { fault: string; parameters: Record<string, unknown> }; answer: { number: number } };
  /** clear a fault */
  clear: { given: { number: number | "all"; on?: string }; answer: Record<string, unknown> };
  /** the faults that are active */
  faults: { given: Record<string, never>; answer: { number: number; kind: string; target: string; parameters: Record<string, unknown>; begin_ns: number }[] };
  /** the places where faults can be, each with the kinds that fit it */
  fault_places: { given: Record<string, never>; answer: { place: string; sort: string; of: string; wire: string; kinds: string[] }[] };
  /** submit a multi-axis run, or only check it */
  run: { given: { text: string; file?: string; check?: boolean; points?: number; name?: string; fresh?: boolean }; answer: { run: string; state: "queued" | "running" | "done" | "failed" | "cancelled"; step: number; steps: number; submissions: number; planned_end_ns: number | null; why: string | null; axes: Record<string, { target_deg: number; at_end: null | "stands" | "moves" | "off" | "failed" | "unknown"; commanded_deg: number | null; position_deg: number | null; error_max_deg: number | null; error_rms_deg: number | null }>; benches: Record<string, { state: string; clock_offset_ns: number; clock_error_ns: number }> } | { problems: string } | { run: string; steps: number; state?: undefined; plan?: undefined } | { run: string; steps: number; state?: undefined; plan: { duration_s: number; is_exact: true | false; axes: Record<string, { at_s: number[]; position_deg: number[] }>; steps: ((number | string)[])[]; steps_left_out: number } } };
  /** read, check and plan a program in G-code; answers its problems, or its path and runs to submit, each with a digest that its progress has too */
  drawing: { given: { text?: string; machine?: string; file?: string; machine_file?: string; feed_percent?: number; check?: boolean }; answer: { problems: string[]; of: "machine" | "program" } | { problems: string[]; remarks: string[]; machine: string; figures: { lines: number; duration_s: number; feed_mm: number; rapid_mm: number }; axes: { letter: string; axis: string; deg_per_unit: number; zero_deg: number; range: number[] }[]; path: { places: number[]; count: number }; runs: { text: string; duration_s: number; timeline: number[][] }[] } | { problems: string[]; remarks: string[]; machine: string; figures: { lines: number; duration_s: number; feed_mm: number; rapid_mm: number }; path?: undefined } };
  /** the state of a run; with an empty name all runs that are remembered */
  runs: { given: Record<string, never>; answer: ({ run: string; state: "queued" | "running" | "done" | "failed" | "cancelled"; step: number; steps: number; submissions: number; planned_end_ns: number | null; why: string | null; axes: Record<string, { target_deg: number; at_end: null | "stands" | "moves" | "off" | "failed" | "unknown"; commanded_deg: number | null; position_deg: number | null; error_max_deg: number | null; error_rms_deg: number | null }>; benches: Record<string, { state: string; clock_offset_ns: number; clock_error_ns: number }> })[] };
  /** end a run */
  cancel_run: { given: { how: "grace" | "prejudice" }; answer: { run: string; state: "queued" | "running" | "done" | "failed" | "cancelled"; step: number; steps: number; submissions: number; planned_end_ns: number | null; why: string | null; axes: Record<string, { target_deg: number; at_end: null | "stands" | "moves" | "off" | "failed" | "unknown"; commanded_deg: number | null; position_deg: number | null; error_max_deg: number | null; error_rms_deg: number | null }>; benches: Record<string, { state: string; clock_offset_ns: number; clock_error_ns: number }> } };
  /** slow a run down along its paths: 1 is as planned, 0 pauses it; moves of SACs are not slowed */
  pace_run: { given: { pace: number }; answer: { run: string; state: "queued" | "running" | "done" | "failed" | "cancelled"; step: number; steps: number; submissions: number; planned_end_ns: number | null; why: string | null; axes: Record<string, { target_deg: number; at_end: null | "stands" | "moves" | "off" | "failed" | "unknown"; commanded_deg: number | null; position_deg: number | null; error_max_deg: number | null; error_rms_deg: number | null }>; benches: Record<string, { state: string; clock_offset_ns: number; clock_error_ns: number }> } };
  /** stop all that moves on this bench and on all that it is joined with; answers who has confirmed */
  stop_site: { given: { how?: "grace" | "prejudice"; within_s?: number }; answer: { benches: ({ bench: string; state: "confirmed" | "refused" | "silent"; why: string | null; took_s: number | null; stopped: string[]; runs: string[]; refused: Record<string, string> })[] } };
  /** stop all axes that move, and end all runs; answers what was stopped, and what was not, with why. It overtakes what waits */
  halt: { given: { how?: "grace" | "prejudice"; axes?: string[] }; answer: { stopped: string[]; runs: string[]; refused: Record<string, string> } };
  /** what happened to the bench, and who asked for it, the oldest first */
  events: { given: { after?: number }; answer: { events: ({ kind: "verbs" | "typed" | "faults" | "motors" | "runs" | "refusals" | "clients" | "reloads" | "lateness" | "trouble" | "log"; number: number; revision: number; at_ns: number; to_ns: number; count: number; of: string; who: string; text: string })[]; left_out: number; revision: number } };
  /** who has the bench, until when and why, and which doors are closed to commands meanwhile */
  lease: { given: Record<string, never>; answer: { lease: null | { user: string; why: string; doors: string[]; closed: string[]; undelivered: Record<string, number>; since_wall_ns: number; until_wall_ns: number; left_s: number } } };
  /** take a lease of the bench: until it ends, others may look and not command */
  take_lease: { given: { why: string; for_s?: number; until_wall_ns?: number; doors?: string[] }; answer: { lease: null | { user: string; why: string; doors: string[]; closed: string[]; undelivered: Record<string, number>; since_wall_ns: number; until_wall_ns: number; left_s: number } } };
  /** let the asker's lease end at another time */
  renew_lease: { given: { for_s?: number; until_wall_ns?: number }; answer: { lease: null | { user: string; why: string; doors: string[]; closed: string[]; undelivered: Record<string, number>; since_wall_ns: number; until_wall_ns: number; left_s: number } } };
  /** give the asker's lease back */
  give_lease: { given: Record<string, never>; answer: { lease: null | { user: string; why: string; doors: string[]; closed: string[]; undelivered: Record<string, number>; since_wall_ns: number; until_wall_ns: number; left_s: number } } };
  /** end a lease of somebody else; log and events say who did */
  break_lease: { given: Record<string, never>; answer: { lease: null | { user: string; why: string; doors: string[]; closed: string[]; undelivered: Record<string, number>; since_wall_ns: number; until_wall_ns: number; left_s: number } } };
  /** hold the bench's time: boards answer nothing, and what clients send waits until `resume` */
  pause: { given: Record<string, never>; answer: { sim_ns: number } };
  /** let the bench's time go on from where it stands */
  resume: { given: Record<string, never>; answer: { sim_ns: number } };
  /** read the configuration again; answers devices kept, restarted, added and removed */
  reload: { given: Record<string, never>; answer: { problems: string } | { removed: string[]; restarted: string[]; added: string[]; kept: string[] } };
  /** end the daemon as SIGTERM does */
  stop: { given: Record<string, never>; answer: Record<string, unknown> };
}
