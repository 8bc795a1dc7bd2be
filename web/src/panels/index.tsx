/** The view of panels that one arranges. */

import { whenLoaded } from "../parts/when_loaded";
import type { ViewEntry } from "../views/view";

const Room = whenLoaded(async () => (await import("./room")).Room);

export const layoutView: ViewEntry = { id: "layout", title: "Layout", View: ({ path }) => <Room address={path} /> };
