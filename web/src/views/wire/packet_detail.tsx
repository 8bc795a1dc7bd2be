/** All that is known of a packet. */

import { timeText } from "./columns";
import { conversationOf } from "./conversation";
import { withWord } from "./packet_filter";
import { PacketFields } from "./packet_fields";
import type { WirePacket } from "./packet_log";
import type { WireFeed } from "./wire_feed";

export function PacketDetail({ feed, packet, close }: { feed: WireFeed; packet: WirePacket; close(): void }) {
  const talk = conversationOf(feed.kind, packet);
  const isFollowed = talk !== "" && feed.filter.value.split(/\s+/).includes(talk);
  const marked = feed.marked.value;
  const rows: [string, string][] = [
    ["at", `${packet.at_s.toFixed(9)} s`],
    ["on the wire", timeText(packet.duration_s)],
    ["driven by", packet.by.join(" and ") || "unknown"],
    ["meaning", packet.text],
    ["error", packet.error ?? "none"],
  ];
  return (
    <div class="packet-detail" role="region" aria-label="The chosen packet">
      <dl>
        {rows.map(([name, value]) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd class={name === "error" && packet.error !== null ? "mono problem" : "mono"}>{value}</dd>
          </div>
        ))}
      </dl>
      <PacketFields feed={feed} packet={packet} />
      <div class="row">
        <button type="button" aria-pressed={isFollowed} disabled={!talk} title={talk} onClick={() => (feed.filter.value = withWord(feed.filter.value, talk))}>
          Follow this conversation
        </button>
        <button
          type="button"
          aria-pressed={marked === packet}
          title="Times can be told from it"
          onClick={() => (feed.marked.value = marked === packet ? undefined : packet)}
        >
          Mark
        </button>
        <button type="button" class="plain push" aria-label="Close the packet" onClick={close}>
          ×
        </button>
      </div>
    </div>
  );
}
