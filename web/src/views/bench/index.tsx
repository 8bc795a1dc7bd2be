import { keptText } from "../../kept";
import { href } from "../../router";
import { devices } from "../../store";
import { whenLoaded } from "../../parts/when_loaded";
import type { ViewEntry } from "../view";
import { figuresOf } from "./figures";
import { Overview } from "./overview";
import "./bench.css";
import "./past_samples";

const Detail = whenLoaded(async () => (await import("./detail")).Detail);
const filter = keptText("bench.filter");

function BenchView({ path }: { path: string[] }) {
  const name = path[0];
  const device = name === undefined ? undefined : devices.value.get(name);
  if (name === undefined) {
    return (
      <>
        <h2 class="out-of-sight">All devices</h2>
        <Overview />
      </>
    );
  }
  return (
    <div class="bench">
      <DeviceList current={name} />
      {device ? <Detail key={device.name} device={device} /> : <p class="empty">There is no device “{name}” on this bench.</p>}
    </div>
  );
}

function DeviceList({ current }: { current: string }) {
  const shown = [...devices.value.values()].filter((device) => device.name.toLowerCase().includes(filter.value.toLowerCase()));
  return (
    <nav class="device-list" aria-label="Devices">
      <a href={href("bench")}>← All devices</a>
      {devices.value.size > 8 && (
        <input
          type="search"
          placeholder="filter"
          aria-label="Filter the devices by name"
          value={filter.value}
          onInput={(event) => (filter.value = event.currentTarget.value)}
        />
      )}
      <ul>
        {shown.map((device) => {
          const figures = figuresOf(device.name);
          return (
            <li key={device.name}>
              <a href={href("bench", device.name)} aria-current={device.name === current ? "page" : undefined} title={device.name}>
                <span class={`dot is-${figures.state}`} aria-hidden="true" />
                <span class="device-name">{device.name}</span>
                <span class="soft">{figures.state === "ok" ? device.profile : figures.stateText}</span>
              </a>
            </li>
          );
        })}
      </ul>
    </nav>
  );
}

export const benchView: ViewEntry = { id: "bench", title: "Bench", View: BenchView };
