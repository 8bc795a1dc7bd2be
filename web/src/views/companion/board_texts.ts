/** Texts of a SAC as data: screens, files of its companion, rows of a spreadsheet. Its profile reads them, at
 * the bench; a text in the place of data says what is wrong. */

import { notify, notifyError } from "../../parts/notices";
import { link as door } from "../../store";
import { LinkError } from "./board_link";
import type { QueueRow } from "./queue_row";

/** Listing of a queue; `at`: the running row, or else where the next command goes. */
export interface Listing {
  readonly rows: readonly QueueRow[];
  readonly at: number;
}

/** Values of the configure screen that the companion needs. */
export interface Configuration {
  readonly steps_per_rev: number;
  readonly microstep_exponent: number;
  readonly interrupt_overhead_us: number;
  readonly clock_correction_us: number;
  readonly slow_rpm: number;
  readonly is_network_swapped: boolean;
}

export interface Speed {
  readonly rpm: number;
  readonly period_us: number;
}

/** Screens by the line that shows them. */
export interface Screens {
  q: Listing;
  cc: Configuration;
  /** Session's defaults and flags, by their names. */
  cf: Readonly<Record<string, string>>;
  vd: Speed;
}

/** Texts by the profile's readers. */
interface Readers extends Screens {
  queue: { readonly rows: readonly QueueRow[] };
  one_shots: { readonly lines: readonly string[] };
  pasted: { readonly rows: readonly QueueRow[] };
  /** Lines that move the motor, of a text whose first line is the motor's steps a turn. */
  long_file: { readonly moves: readonly string[] };
}

const LARGEST_BYTES = 100_000;
/** A page's message has 1 MB. */
const LARGEST_LONG_BYTES = 900_000;
const PIECE_BYTES = 10_000;

/** Read a text of the board at a port. Throws LinkError: the bench does not answer. */
export async function readText<Name extends keyof Readers>(port: string, reader: Name, text: string, file = ""): Promise<Readers[Name] | string> {
  try {
    return (await door.ask("read_text", port.split(".", 1)[0], { reader, text, file })) as Readers[Name] | string;
  } catch (error) {
    throw new LinkError((error as Error).message);
  }
}

/** Read a text that the user gave, a file or the clipboard's; undefined: what is wrong was told. */
export async function readGiven<Name extends keyof Readers>(port: string, reader: Name, text: string, file = ""): Promise<Readers[Name] | undefined> {
  try {
    const read = await readText(port, reader, text, file);
    if (typeof read !== "string") return read;
    notify(shortened(read, file !== ""), true);
  } catch (error) {
    notifyError(error);
  }
  return undefined;
}

/** Read a file of the companion; undefined: what is wrong was told. */
export async function readFile<Name extends keyof Readers>(port: string, reader: Name, data: Uint8Array, file: string): Promise<Readers[Name] | undefined> {
  if (data.length <= LARGEST_BYTES) return readGiven(port, reader, String.fromCharCode(...data), file);
  notify(`${file}:1:1: ${data.length.toLocaleString("en")} bytes; a file of the companion has some thousand`, true);
  return undefined;
}

/** Read a long file of the companion for a motor; undefined: what is wrong was told. */
export async function readLongFile(port: string, stepsPerRev: number, data: Uint8Array, file: string): Promise<Readers["long_file"] | undefined> {
  if (data.length > LARGEST_LONG_BYTES) {
    notify(`${file}: ${data.length.toLocaleString("en")} bytes; hil sac stream takes a file of this length`, true);
    return undefined;
  }
  let text = `${stepsPerRev}\n`;
  for (let at = 0; at < data.length; at += PIECE_BYTES) text += String.fromCharCode(...data.subarray(at, at + PIECE_BYTES));
  return readGiven(port, "long_file", text, file);
}

/** First problems of a text, and how many more a file has. */
function shortened(problems: string, isFile: boolean): string {
  const lines = problems.split("\n");
  const rest = isFile ? lines.length - 5 : 0;
  return lines.slice(0, 5).join("\n") + (rest > 0 ? `\nand ${rest} more` : "");
}
