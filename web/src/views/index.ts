/** The views of the page, in the order of their tabs. All but the first are loaded when they are shown. */

import { layoutView } from "../panels";
import { whenLoaded } from "../parts/when_loaded";
import { benchView } from "./bench";
import { packetEars } from "./bench/packet_ears";
import { eventsView } from "./events";
import type { ViewEntry } from "./view";
import { hearPackets } from "./wire/heard_packets";

const runsView: ViewEntry = { id: "runs", title: "Runs", View: whenLoaded(async () => (await import("./runs")).RunsView) };

const faultsView: ViewEntry = { id: "faults", title: "Faults", View: whenLoaded(async () => (await import("./faults")).FaultsView) };

const pathView: ViewEntry = {
  id: "path",
  title: "Path",
  View: whenLoaded(async () => (await import("./path")).PathView),
  isShown: (bench) => "drawing" in bench.operations,
};

const wireView: ViewEntry = {
  id: "wire",
  title: "Wire",
  View: whenLoaded(async () => (await import("./wire")).WireView),
  isShown: (bench) => bench.segments.length > 0 || bench.buses.length > 0,
};

const companionView: ViewEntry = {
  id: "companion",
  title: "Companion",
  View: whenLoaded(async () => (await import("./companion")).CompanionView),
  isShown: (bench) => bench.devices.some(({ profile }) => profile === "sac"),
};

export const VIEWS: ViewEntry[] = [benchView, layoutView, runsView, faultsView, eventsView, pathView, wireView, companionView];

packetEars.hear = hearPackets;
