/** A layout as the part of an address, and back: "1.", then its JSON, deflated, in base64url. */

import { type Layout, LAYOUT_VERSION, readLayout, Unreadable } from "./layout";

/** A longer text in an address was not made here. */
const MOST_BYTES = 1_000_000;

/** True where a part of an address is meant to be a layout. */
export function isLayoutText(text: string): boolean {
  return /^\d+\./.test(text);
}

export async function textOfLayout(layout: Layout): Promise<string> {
  const plain = new TextEncoder().encode(JSON.stringify(layout));
  const packed = await through(plain, new CompressionStream("deflate-raw"), Infinity);
  return `${LAYOUT_VERSION}.${toBase64(packed)}`;
}

/** Read what `textOfLayout` wrote. Throws Unreadable, with words for people. */
export async function layoutOfText(text: string): Promise<Layout> {
  const [, version, data] = /^(\d+)\.([A-Za-z0-9_-]*)$/.exec(text) ?? [];
  if (version !== undefined && Number(version) !== LAYOUT_VERSION) {
    throw new Unreadable(`This address has a layout of version ${version.slice(0, 20)}; this page reads version ${LAYOUT_VERSION}.`);
  }
  let raw: unknown;
  try {
    if (!data) throw new Error("none");
    const plain = await through(fromBase64(data), new DecompressionStream("deflate-raw"), MOST_BYTES);
    raw = JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(plain));
  } catch (error) {
    if (error instanceof Unreadable) throw error;
    throw new Unreadable("This address has no layout that can be read: a part of it is missing, or was changed.");
  }
  return readLayout(raw);
}

async function through(bytes: Uint8Array<ArrayBuffer>, stream: CompressionStream | DecompressionStream, most_bytes: number): Promise<Uint8Array<ArrayBuffer>> {
  const reader = new Blob([bytes]).stream().pipeThrough(stream).getReader();
  const pieces: Uint8Array<ArrayBuffer>[] = [];
  let length = 0;
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    length += value.length;
    if (length > most_bytes) {
      await reader.cancel();
      throw new Unreadable("The layout of this address is too large.");
    }
    pieces.push(value as Uint8Array<ArrayBuffer>);
  }
  return new Uint8Array(await new Blob(pieces).arrayBuffer());
}

function toBase64(bytes: Uint8Array): string {
  let text = "";
  for (const byte of bytes) text += String.fromCharCode(byte);
  return btoa(text).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

function fromBase64(text: string): Uint8Array<ArrayBuffer> {
  const plain = atob(text.replaceAll("-", "+").replaceAll("_", "/"));
  return Uint8Array.from(plain, (character) => character.charCodeAt(0));
}
