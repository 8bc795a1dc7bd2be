/** Samples of the past for all axes that are in sight, fetched as the shown time moves: one request at a time, and the
 * newest time next. */

import { effect, signal } from "@preact/signals";
import type { Operations } from "../../model/door";
import { readRows } from "../../model/past";
import { Ring } from "../../model/ring";
import type { Layer } from "../../model/sampling";
import { notifyError } from "../../parts/notices";
import { askPast, LANE, pastAt } from "../../past";
import { type AxisFeed, wantedFeeds, wantsChanged } from "./axis_feed";

type Series = Operations["past_samples"]["answer"]["series"][number];

const POINTS = 2400;
/** A recording is written once a second. */
const TURNS = 5;
const TURN_MS = 500;
const END_s = 0.01;
/** The most that can be asked for. */
const MOST_POINTS = 20_000;
/** Grows when other samples of the past are there. */
export const pastNews = signal(0);

let isBusy = false;
let isAgain = false;

async function fetchAll(): Promise<void> {
  if (isBusy) {
    isAgain = true;
    return;
  }
  isBusy = true;
  try {
    do {
      isAgain = false;
      const at_s = pastAt.peek();
      if (at_s === null) break;
      const feeds = wantedFeeds().filter((feed) => feed.fields.length);
      for (const window_s of new Set(feeds.map((feed) => feed.pastWindow_s))) {
        const some = feeds.filter((feed) => feed.pastWindow_s === window_s);
        await fetchSome(some, at_s, window_s);
      }
      pastNews.value = pastNews.peek() + 1; // an effect that asks must not hear of it
    } while (isAgain);
  } catch (error) {
    notifyError(error);
  } finally {
    isBusy = false;
  }
}

async function fetchSome(feeds: AxisFeed[], at_s: number, window_s: number): Promise<void> {
  const names = feeds.flatMap((feed) => feed.fields.map((field) => `${feed.axis}.${field}`));
  const points = feeds.length > 2 ? POINTS / 4 : POINTS;
  const told = await askPast("past_samples", { fields: names, from_s: Math.max(at_s - window_s, 0), to_s: at_s, points, lane: `${LANE} ${window_s}` });
  for (const series of told?.series ?? []) {
    const feed = feeds.find((each) => each.axis === series.axis);
    if (feed) feed.past = layerOf(series, feed.fields, told?.interval_ns ?? 0);
  }
}

/** Arrange a series of the past as an axis has its fields. */
function layerOf({ fields, rows, data, is_summed }: Series, wanted: string[], interval_ns: number): Layer {
  const given = new Ring(Math.max(rows, 1), fields.length + 1);
  given.push(readRows(data), rows, fields.length + 1);
  const ring = given.rearranged([0, ...wanted.map((field) => fields.indexOf(field) + 1 || -1)]);
  const interval_s = is_summed ? (2 * (ring.last_s - ring.first_s)) / Math.max(rows - 1, 1) : interval_ns / 1e9;
  return { ring, sampling: { interval_s, isExtremes: is_summed } };
}

/** Ask the recording for all that there is of a window, of the fields of axes: each control step, of a long one the extremes of
 * intervals. What is about now is in it a moment later. Answers samples by axis, of those of which it has some. */
export async function allOf(wanted: ReadonlyMap<string, string[]>, from_s: number, to_s: number): Promise<Map<string, Layer>> {
  let found = new Map<string, Layer>();
  for (let turn = 0; turn < TURNS; turn++) {
    if (turn) await new Promise((resolve) => setTimeout(resolve, TURN_MS));
    found = await askAll(wanted, from_s, to_s);
    if (found.size && [...found.values()].every(({ ring }) => ring.last_s >= to_s - END_s)) break;
  }
  return found;
}

async function askAll(wanted: ReadonlyMap<string, string[]>, from_s: number, to_s: number): Promise<Map<string, Layer>> {
  const names = [...wanted].flatMap(([axis, fields]) => fields.map((field) => `${axis}.${field}`));
  const told = await askPast("past_samples", { fields: names, from_s: Math.max(from_s, 0), to_s, points: MOST_POINTS, lane: `${LANE} all` });
  return new Map(
    (told?.series ?? []).flatMap((series) => (wanted.has(series.axis) ? [[series.axis, layerOf(series, wanted.get(series.axis)!, told!.interval_ns)]] : [])),
  );
}

effect(() => {
  void wantsChanged.value;
  if (pastAt.value !== null) void fetchAll();
});
