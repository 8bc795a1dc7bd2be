/** Values of fields for panels: by their addresses, of the time that the page shows. */

import { useEffect } from "preact/hooks";
import { devices } from "../store";
import { type AxisFeed, feedOf } from "../views/bench/axis_feed";
import { besideOf, fieldAt } from "../views/bench/axis_fields";
import { pastAt } from "../past";

/** Newest value of a field, or that of the time that the page looks back at; NaN: there is none. */
export function valueNow(feed: AxisFeed, field: string): number {
  const { ring } = feed;
  const column = feed.column(field);
  if (!column || !ring.total) return NaN;
  return pastAt.peek() === null ? ring.at(column, ring.total - 1) : ring.nearest(column, feed.edge_s(performance.now()));
}

/** Value at an address: "m1.yw". */
export function valueAt(address: string): number {
  const parts = besideOf(address);
  return parts ? valueNow(feedOf(parts.axis), parts.field) : NaN;
}

/** Watch fields while a component is there. */
export function useFields(addresses: readonly string[]): void {
  const key = addresses.join("\n");
  useEffect(() => {
    const byAxis = new Map<string, string[]>();
    for (const address of addresses) {
      const found = fieldAt(devices.peek(), address);
      if (found) byAxis.set(found.device.name, [...(byAxis.get(found.device.name) ?? []), found.field.name]);
    }
    const ends = [...byAxis].map(([axis, fields]) => feedOf(axis).want(fields));
    return () => {
      for (const end of ends) end();
    };
  }, [key]);
}

/** Names of devices and axes with a shaft. */
export function shaftNames(): string[] {
  return [...devices.value.values()].filter(({ fields }) => fields.some(({ name }) => name === "position_deg")).map(({ name }) => name);
}
