/** Bytes of a board as text that is safe to show: control characters and escape sequences as pictures of
 * themselves, invalid UTF-8 as its bytes. Pure; a character that is cut between two frames waits for its rest. */

const DIM_ON = "\x1b[7m";
const DIM_OFF = "\x1b[27m";
/** Controls that a terminal carries out: bell, backspace, tab, line feed, return. All others are shown. */
const CARRIED_OUT = new Set([0x08, 0x09, 0x0a, 0x0d]);
const DELETE = 0x7f;
/** Characters that turn or hide what stands beside them. */
const HIDING = /[\u0080-\u009f\u00ad\u061c\u200b-\u200f\u2028-\u202e\u2060-\u2069\ufeff]/u;

/** Bytes of hexadecimal digits. */
export function bytesOf(hex: string): Uint8Array {
  return Uint8Array.from(hex.match(/../g) ?? [], (digits) => parseInt(digits, 16));
}

export class TerminalText {
  private waiting: number[] = [];

  /** Decode the next bytes; what is shown in the place of something stands in reverse. */
  next(bytes: Uint8Array): string {
    const all = this.waiting.length ? [...this.waiting, ...bytes] : bytes;
    this.waiting = [];
    let text = "";
    for (let at = 0; at < all.length; ) {
      const byte = all[at]!;
      if (byte < 0x80) {
        text += ascii(byte);
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
        text += character(decodeAt(all, at, length));
        at += length;
      } else {
        text += marked(`\\x${hex(byte)}`);
        at++;
      }
    }
    return text;
  }
}

function ascii(byte: number): string {
  if (CARRIED_OUT.has(byte) || (byte >= 0x20 && byte !== DELETE)) return String.fromCharCode(byte);
  return marked(byte === DELETE ? "\u2421" : String.fromCharCode(0x2400 + byte));
}

function marked(text: string): string {
  return DIM_ON + text + DIM_OFF;
}

function hex(byte: number): string {
  return byte.toString(16).padStart(2, "0");
}

function character(code: number): string {
  const text = String.fromCodePoint(code);
  return HIDING.test(text) ? marked(`\\u${code.toString(16).padStart(4, "0")}`) : text;
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
