import type { ComponentType } from "preact";
import type { Hello } from "../net/protocol";

/** A view: its part of the address, its tab's text, and the component that gets the rest of the address. */
export interface ViewEntry {
  id: string;
  title: string;
  View: ComponentType<{ path: string[] }>;
  /** Whether this bench has something to show there; without it every bench has. */
  isShown?: (bench: Hello) => boolean;
}
