/** One device: its plots, and beside them verbs, gains, pins, terminals and all fields. */

import { Tabs, type Tab } from "../../parts/tabs";
import type { DeviceRow } from "../../model/door";
import { href } from "../../router";
import { hello } from "../../store";
import { detailTab } from "./detail_tab";
import { pinsOf } from "./axis_fields";
import { figuresOf } from "./figures";
import { Gains, hasGains } from "./gains";
import { Fields } from "./fields";
import { Pins } from "./pins";
import { plotModelOf } from "./plot_model";
import { Plots } from "./plots";
import { areWide, Terminals } from "./terminals";
import { Verbs } from "./verbs";

export function Detail({ device }: { device: DeviceRow }) {
  const model = plotModelOf(device);
  const ports = portsOf(device);
  const tabs: Tab[] = [
    { id: "verbs", title: "Verbs" },
    ...(ports.length ? [{ id: "terminal", title: "Terminal" }] : []),
    ...(hasGains(device) ? [{ id: "gains", title: "Gains" }] : []),
    ...(pinsOf(device).length ? [{ id: "pins", title: "Pins" }] : []),
    ...(device.fields.length ? [{ id: "fields", title: "Fields" }] : []),
  ];
  const tab = tabs.find((each) => each.id === detailTab.value)?.id ?? "verbs";
  const hasPlots = device.fields.length > 0;
  const isWide = tab === "terminal" && (areWide() || !hasPlots);
  const classes = ["detail-parts", tab === "terminal" && "has-terminal", isWide && "is-wide"];
  return (
    <div class="detail">
      <DeviceHead device={device} />
      <div class={classes.filter(Boolean).join(" ")}>
        {hasPlots && !isWide && <Plots key={device.name} model={model} />}
        <Tabs label={`Of ${device.name}`} tabs={tabs} current={tab} onChange={(id) => (detailTab.value = id)}>
          {tab === "verbs" && <Verbs device={device} />}
          {tab === "terminal" && <Terminals ports={ports} hasPlots={hasPlots} />}
          {tab === "gains" && <Gains device={device} />}
          {tab === "pins" && <Pins device={device} />}
          {tab === "fields" && <Fields device={device} />}
        </Tabs>
      </div>
    </div>
  );
}

function DeviceHead({ device }: { device: DeviceRow }) {
  const figures = figuresOf(device.name);
  return (
    <div class="row detail-head">
      <h2 class="device-name" title={device.name}>
        {device.name}
      </h2>
      <span class="soft">
        {device.profile}
        {device.is_real && " · real"}
      </span>
      <span class={`pill is-${figures.state}`}>{figures.stateText}</span>
      {figures.why && figures.why !== figures.stateText && <span class="soft">{figures.why}</span>}
      {!device.is_real && (
        <a class="button" href={href("faults", device.name)}>
          Break…
        </a>
      )}
    </div>
  );
}

/** Ports of a device's UARTs. An axis of a device has those of the device. */
function portsOf(device: DeviceRow): string[] {
  const owner = device.name.split(".")[0] ?? device.name;
  return (hello.value?.ports ?? []).filter((port) => port === owner || port.startsWith(`${owner}.`));
}
