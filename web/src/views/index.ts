/** The views of the page, in the order of their tabs: one line each. */

import { benchView } from "./bench";
import { packetEars } from "./bench/plot_trigger";
import { companionView } from "./companion";
import { eventsView } from "./events";
import { faultsView } from "./faults";
import { layoutView } from "../panels";
import { pathView } from "./path";
import { runsView } from "./runs";
import type { ViewEntry } from "./view";
import { wireView } from "./wire";
import { hearPackets } from "./wire/heard_packets";

export const VIEWS: ViewEntry[] = [benchView, layoutView, runsView, faultsView, eventsView, pathView, wireView, companionView];

packetEars.hear = hearPackets;
