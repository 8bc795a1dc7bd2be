/** Packets of a wire for others than this view: those that have some words, as they pass. */

import { hello, link } from "../../store";
import { packetFilter } from "./packet_filter";
import { readPacket } from "./packet_log";

/** Hear the times at which packets pass that the filter's words let through; answers the function that ends it. */
export function hearPackets(line: string, words: string, heard: (at_s: number) => void): () => void {
  const isFit = packetFilter(words);
  const isSegment = hello.peek()?.segments.some((name) => name === line);
  const watch = link.watch(
    { what: isSegment ? "packets" : "frames", target: line },
    {
      items: (items) => {
        for (const item of items) {
          const packet = readPacket(item, 0);
          if (packet && !packet.isUnfinished && isFit(packet)) heard(packet.at_s);
        }
      },
    },
  );
  return () => watch.close();
}
