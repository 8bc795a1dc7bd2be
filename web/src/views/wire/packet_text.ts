/** Bytes to send, as a person writes them. */

/** Largest burst that can be sent at once. */
const MOST_BYTES = 1024;

/** Read hexadecimal bytes, as in `02 55 01`, with or without blanks, commas and 0x; a text says what is wrong. */
export function readHex(text: string): Uint8Array | { fault: string } {
  const digits = text.replace(/0x|[\s,:;]/gi, "");
  if (!digits) return { fault: "write bytes as 02 55 01" };
  const strange = /[^0-9a-f]/i.exec(digits);
  if (strange) return { fault: `"${strange[0]}" is no hexadecimal digit` };
  if (digits.length % 2) return { fault: "a byte has two digits; one is missing" };
  if (digits.length / 2 > MOST_BYTES) return { fault: `at most ${MOST_BYTES} bytes at once` };
  return Uint8Array.from(digits.match(/../g)!, (pair) => Number.parseInt(pair, 16));
}

export function hexOf(bytes: Uint8Array): string {
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}

/** Format hexadecimal digits in pairs: `02 55 01`. */
export function hexPairs(hex: string): string {
  return hex
    .replace(/[^0-9a-f]/gi, "")
    .toLowerCase()
    .replace(/(..)(?=.)/g, "$1 ");
}

/** CRC of a SAC's packet (Dallas/Maxim), over its data. */
export function sacCrc(data: Uint8Array): number {
  let crc = 0;
  for (const byte of data) {
    crc ^= byte;
    for (let bit = 0; bit < 8; bit++) crc = crc & 1 ? (crc >> 1) ^ 0x8c : crc >> 1;
  }
  return crc;
}

/** Make a SAC's packet: STX, destination, origin, data, ETX, CRC, NUL. */
export function sacPacket(destination: number, origin: number, text: string): Uint8Array {
  const data = new TextEncoder().encode(text);
  return Uint8Array.from([2, destination, origin, ...data, 3, sacCrc(data), 0]);
}

/** CRC of a Modbus RTU frame, low byte first. */
export function modbusCrc(data: Uint8Array): [number, number] {
  let crc = 0xffff;
  for (const byte of data) {
    crc ^= byte;
    for (let bit = 0; bit < 8; bit++) crc = crc & 1 ? (crc >> 1) ^ 0xa001 : crc >> 1;
  }
  return [crc & 0xff, crc >> 8];
}
