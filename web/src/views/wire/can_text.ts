/** Frames of CAN to send, as a person writes them; the text is that of can-utils: 123#0011, 0000CAFE#R2. Pure. */

import { hexOf, readHex } from "./packet_text";

const STANDARD_MOST = 0x7ff;
const EXTENDED_MOST = 0x1fffffff;
const MOST_BYTES = 8;

export interface TypedFrame {
  readonly id: string;
  readonly isExtended: boolean;
  readonly isRemote: boolean;
  /** Bytes, hexadecimal; of a remote frame how many it asks for. */
  readonly data: string;
}

/** Make a frame of what was typed; a text says what is wrong. */
export function canFrame(typed: TypedFrame): { frame: string } | { fault: string } {
  const id = typed.id.trim().replace(/^0x|h$/gi, "");
  if (!/^[0-9a-f]{1,8}$/i.test(id)) return { fault: "write the identifier in hexadecimal digits, as 605" };
  const number = Number.parseInt(id, 16);
  if (number > EXTENDED_MOST) return { fault: "an identifier has at most 29 bits: up to 1FFFFFFF" };
  if (!typed.isExtended && number > STANDARD_MOST) return { fault: "an identifier of 11 bits goes up to 7FF; choose 29 bits for this one" };
  const name = number
    .toString(16)
    .toUpperCase()
    .padStart(typed.isExtended ? 8 : 3, "0");
  const data = typed.data.trim();
  if (typed.isRemote) {
    if (!/^[0-8]?$/.test(data)) return { fault: "a remote frame asks for 0 to 8 bytes: write how many" };
    return { frame: `${name}#R${data === "0" ? "" : data}` };
  }
  if (!data) return { frame: `${name}#` };
  const bytes = readHex(data);
  if (!(bytes instanceof Uint8Array)) return bytes;
  if (bytes.length > MOST_BYTES) return { fault: `a frame has at most ${MOST_BYTES} bytes, this has ${bytes.length}` };
  return { frame: `${name}#${hexOf(bytes).toUpperCase()}` };
}
