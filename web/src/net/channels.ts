/** What the link offers: watches and terminals, and who hears what they tell. */

import type { TerminalAnswer, WatchKind } from "../model/door";
import type { Refused } from "./protocol";

export type LinkState = "connecting" | "open" | "lost" | "login";

export interface LoginKind {
  login: "none" | "token" | "password";
}

export interface SampleSink {
  /** Take rows of at_s and the fields in the order asked; `lost`: samples lost since the beginning. */
  samples?(values: Float64Array, rows: number, columns: number, lost: number): void;
  items?(items: unknown[], lost: number): void;
  value?(value: unknown): void;
  /** The bench refused the watch, now or after a connection came back. */
  refused?(error: Refused): void;
  /** A new connection: the watch begins again, and there is a gap in what it told. */
  again?(): void;
}

export interface WatchRequest {
  what: WatchKind;
  target?: string;
  fields?: string[];
  rate_Hz?: number;
  /** Looks in each interval of which two samples have the smallest and the largest value; 1: samples of moments. */
  points?: number;
}

export interface WatchHandle {
  /** Number of the watch at the server, for `export`; 0: not begun. */
  readonly number: number;
  close(): void;
}

export interface TerminalSink {
  /** `at_s`: simulated time at which the bench had them; NaN: it was not asked for. */
  bytes(bytes: Uint8Array, at_s: number): void;
  /** The port is open, for the first time or again. */
  opened(answer: TerminalAnswer): void;
  closed(why: string): void;
  /** The port has taken so many bytes of what was sent since it was opened. With it the door tells times, too. */
  taken?(bytes: number): void;
}

export interface TerminalHandle {
  /** Send bytes; answers whether there was a way to. */
  send(bytes: Uint8Array): boolean;
  close(): void;
}
