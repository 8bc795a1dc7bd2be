/** Bytes of a board as text that is safe to show: colours are let through, all other control characters and escape
 * sequences stand there as what one would write for them, invalid UTF-8 as its bytes. Pure; a character or a colour
 * that is cut between two frames waits for its rest. */

const ESCAPE = 0x1b;
const REVERSE_ON = "\x1b[7m";
const REVERSE_OFF = "\x1b[27m";
/** Sequences that set colours and weights; longer ones are none. */
const MOST_SEQUENCE = 48;
const COLOURS = /\x1b\[[\d;]*m/g;
/** What they may set: weights, underline, reverse and colours. Not what hides text (8), and not what blinks. */
const HARMLESS = new Set([0, 1, 2, 3, 4, 7, 22, 23, 24, 27, 39, 49, ...range(30, 37), ...range(40, 47), ...range(90, 97), ...range(100, 107)]);
/** Parameters of a colour by number (38;5;N) and by red, green and blue (38;2;R;G;B). */
const COLOUR_PARAMETERS = new Map([
  [5, 1],
  [2, 3],
]);
const MOST_STYLE = 200;
/** Controls that a terminal carries out: backspace, tab, line feed, return. All others are shown. */
const CARRIED_OUT = new Set([0x08, 0x09, 0x0a, 0x0d]);
const DELETE = 0x7f;
/** Characters that turn or hide what stands beside them. */
const HIDING = /[\u0080-\u009f\u00ad\u061c\u200b-\u200f\u2028-\u202e\u2060-\u2069\ufeff]/u;

/** Bytes of hexadecimal digits. */
export function bytesOf(hex: string): Uint8Array {
  return Uint8Array.from(hex.match(/../g) ?? [], (digits) => parseInt(digits, 16));
}

/** A text without its colours. */
export function plainOf(text: string): string {
  return text.replace(COLOURS, "");
}

export class TerminalText {
  /** Sequences that set the colours which are in force. */
  style = "";
  private waiting: number[] = [];
  private isReversed = false;

  /** Decode the next bytes; what is shown in the place of something stands in reverse. */
  next(bytes: Uint8Array): string {
    const all = this.waiting.length ? [...this.waiting, ...bytes] : bytes;
    this.waiting = [];
    let text = "";
    for (let at = 0; at < all.length; ) {
      const byte = all[at]!;
      const sequence = byte === ESCAPE ? colourAt(all, at) : "";
      if (sequence === null) {
        this.waiting = Array.from(all.slice(at));
        break;
      }
      if (sequence) {
        this.setStyle(sequence);
        text += sequence;
        at += sequence.length;
        continue;
      }
      if (byte < 0x80) {
        text += this.ascii(byte);
        at++;
        continue;
      }
      const length = sequenceLength(byte);
      const known = validPart(all, at, length);
      if (length && known < length && at + known === all.length) {
        this.waiting = Array.from(all.slice(at));
        break;
      }
      if (length && known === length) {
        text += this.character(decodeAt(all, at, length));
        at += length;
      } else {
        text += this.marked(`\\x${hex(byte)}`);
        at++;
      }
    }
    return text;
  }

  private setStyle(sequence: string): void {
    const codes = codesOf(sequence);
    const isNew = codes[0] === 0 || this.style.length > MOST_STYLE;
    this.style = isNew ? sequence : this.style + sequence;
    for (const code of codes) {
      if (code === 7) this.isReversed = true;
      if (code === 0 || code === 27) this.isReversed = false;
    }
  }

  private ascii(byte: number): string {
    if (CARRIED_OUT.has(byte) || (byte >= 0x20 && byte !== DELETE)) return String.fromCharCode(byte);
    return this.marked(`\\x${hex(byte)}`);
  }

  private character(code: number): string {
    const text = String.fromCodePoint(code);
    return HIDING.test(text) ? this.marked(`\\u${code.toString(16).padStart(4, "0")}`) : text;
  }

  /** What stands in the place of something stands the other way round than what is beside it. */
  private marked(text: string): string {
    return this.isReversed ? REVERSE_OFF + text + REVERSE_ON : REVERSE_ON + text + REVERSE_OFF;
  }
}

/** The sequence that sets colours at a place; empty: there is none that may be carried out; null: it may go on. */
function colourAt(bytes: ArrayLike<number>, at: number): string | null {
  let text = "\x1b";
  for (let next = at + 1; next < at + MOST_SEQUENCE; next++) {
    if (next >= bytes.length) return null;
    const byte = bytes[next]!;
    const fits = next === at + 1 ? byte === 0x5b : (byte >= 0x30 && byte <= 0x39) || byte === 0x3b || byte === 0x6d;
    if (!fits) return "";
    text += String.fromCharCode(byte);
    if (byte === 0x6d) return isHarmless(codesOf(text)) ? text : "";
  }
  return "";
}

function codesOf(sequence: string): number[] {
  return sequence.slice(2, -1).split(";").map(Number);
}

function isHarmless(codes: number[]): boolean {
  for (let at = 0; at < codes.length; at++) {
    if (codes[at] === 38 || codes[at] === 48) {
      const count = COLOUR_PARAMETERS.get(codes[at + 1] ?? NaN) ?? NaN;
      const parts = codes.slice(at + 2, at + 2 + count);
      if (parts.length !== count || parts.some((part) => part > 255)) return false;
      at += 1 + count;
    } else if (!HARMLESS.has(codes[at]!)) return false;
  }
  return true;
}

function range(from: number, to: number): number[] {
  return Array.from({ length: to - from + 1 }, (_, index) => from + index);
}

function hex(byte: number): string {
  return byte.toString(16).padStart(2, "0");
}

/** Length of the UTF-8 sequence that a byte begins; 0: it begins none. */
function sequenceLength(byte: number): number {
  if (byte >= 0xc2 && byte <= 0xdf) return 2;
  if (byte >= 0xe0 && byte <= 0xef) return 3;
  return byte >= 0xf0 && byte <= 0xf4 ? 4 : 0;
}

/** Number of bytes from `at` on that are a valid beginning of a sequence. */
function validPart(bytes: ArrayLike<number>, at: number, length: number): number {
  let known = 1;
  while (known < length && at + known < bytes.length && continues(bytes[at]!, bytes[at + known]!, known)) known++;
  return known;
}

/** Whether a byte may follow: no overlong forms, no surrogates, nothing above U+10FFFF. */
function continues(lead: number, byte: number, place: number): boolean {
  if (byte < 0x80 || byte > 0xbf) return false;
  if (place > 1) return true;
  if (lead === 0xe0) return byte >= 0xa0;
  if (lead === 0xed) return byte <= 0x9f;
  if (lead === 0xf0) return byte >= 0x90;
  return lead !== 0xf4 || byte <= 0x8f;
}

function decodeAt(bytes: ArrayLike<number>, at: number, length: number): number {
  let code = bytes[at]! & (0xff >> (length + 1));
  for (let place = 1; place < length; place++) code = (code << 6) | (bytes[at + place]! & 0x3f);
  return code;
}
