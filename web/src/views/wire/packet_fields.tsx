/** A packet's fields as a tree, beside its bytes: pointing at one marks the other. */

import { useEffect, useState } from "preact/hooks";
import type { FieldsAnswer, PacketFieldRow } from "../../model/door";
import { Refused } from "../../net/protocol";
import { link } from "../../store";
import { fieldAt, fieldContext } from "./field_context";
import { bytesOf, type WirePacket } from "./packet_log";
import { placeOf } from "./shown_packets";
import type { WireFeed } from "./wire_feed";

export function PacketFields({ feed, packet }: { feed: WireFeed; packet: WirePacket }) {
  const [fields, setFields] = useState<readonly PacketFieldRow[]>([]);
  const [why, setWhy] = useState("");
  const [pointed, setPointed] = useState<{ begin: number; end: number } | undefined>(undefined);
  useEffect(() => {
    setPointed(undefined);
    setWhy("");
    const { log } = feed.source;
    const packets = fieldContext(feed.kind, log, placeOf(log, packet.number), packet);
    if (!packets.length) {
      setFields([]);
      return;
    }
    let isThere = true;
    link
      .request<FieldsAnswer>({ do: "fields", wire: feed.place.name, packets })
      .then((told) => isThere && setFields(told.fields))
      .catch((error: unknown) => isThere && setWhy(error instanceof Refused ? error.message : String(error)));
    return () => void (isThere = false);
  }, [feed, packet.number]);
  const bytes = packet.hex.match(/../g)?.slice(0, bytesOf(packet)) ?? [];
  const isMarked = (begin: number, end: number) => pointed !== undefined && begin < pointed.end && end > pointed.begin;
  const pointAt = (byte: number) => {
    const field = fields[fieldAt(fields, byte)];
    setPointed(field ? { begin: field.begin, end: field.end } : { begin: byte, end: byte + 1 });
  };
  return (
    <div class="packet-parts">
      {why && <p class="problem">{why}</p>}
      <ul class="packet-fields" aria-label="Fields of the packet">
        {fields.map((field, at) => (
          <li key={at} class={`level-${Math.min(field.level, 3)}`}>
            <button
              type="button"
              class={isMarked(field.begin, field.end) ? "field is-marked" : "field"}
              onMouseEnter={() => setPointed(field)}
              onMouseLeave={() => setPointed(undefined)}
              onFocus={() => setPointed(field)}
              onBlur={() => setPointed(undefined)}
            >
              <span class="soft">{field.name}</span> <span class="mono">{field.text}</span>
            </button>
          </li>
        ))}
      </ul>
      {bytes.length > 0 && (
        <ol class="packet-bytes" aria-label="Bytes of the packet">
          {bytes.map((byte, at) => (
            <li key={at}>
              <button
                type="button"
                class={isMarked(at, at + 1) ? "mono byte is-marked" : "mono byte"}
                title={`byte ${at}`}
                aria-label={`Byte ${at}: ${byte}`}
                onMouseEnter={() => pointAt(at)}
                onMouseLeave={() => setPointed(undefined)}
                onFocus={() => pointAt(at)}
                onBlur={() => setPointed(undefined)}
              >
                {byte}
              </button>
            </li>
          ))}
        </ol>
      )}
    </div>
  );
}
