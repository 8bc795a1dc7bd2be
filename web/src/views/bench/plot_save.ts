/** What plots show, as files. */

import { csvOf } from "../../model/samples_csv";
import { type Layer, samplingText } from "../../model/sampling";
import { notify, notifyError } from "../../parts/notices";
import { trouble } from "../../past";
import { besideOf, neededFields } from "./axis_fields";
import { download, fileName, type Picture, pngOf } from "./export";
import { allOf } from "./past_samples";
import type { PlotPane } from "./plot_pane";
import type { PlotModel } from "./plot_model";

/** Samples of an axis, and where its fields stand in them. */
interface Source {
  layer: Layer;
  columnOf(field: string): number;
}

/** Save the rows that are shown. */
export function saveShown(model: PlotModel): void {
  const now_ms = performance.now();
  const [from_s, to_s] = [model.left_s(now_ms), model.right_s(now_ms)];
  save(model, (axis) => model.sourceOf(axis, from_s), from_s, to_s);
}

/** Save each control step of what is shown, of all axes, from the recording. */
export async function saveAll(model: PlotModel): Promise<void> {
  const now_ms = performance.now();
  const [from_s, to_s] = [model.left_s(now_ms), model.right_s(now_ms)];
  try {
    const wanted = wantedOf(model);
    const found = await allOf(wanted, from_s, to_s);
    if (!found.has(model.axis)) return notify(trouble.peek() || "the recording has nothing of this time", true);
    const sourceOf = (axis: string) => {
      const layer = found.get(axis);
      return layer ? { layer, columnOf: (field: string) => wanted.get(axis)!.indexOf(field) + 1 } : null;
    };
    save(model, sourceOf, from_s, to_s);
  } catch (error) {
    notifyError(error);
  }
}

/** Fields to be had for what is drawn, by axis. */
export function wantedOf(model: PlotModel): Map<string, string[]> {
  const wanted = new Map([[model.axis, neededFields(model.device, model.chosen.peek())]]);
  for (const name of model.others.peek()) {
    const { axis, field } = besideOf(name)!;
    wanted.set(axis, [...new Set([...(wanted.get(axis) ?? []), field, ...(model.isByMode(name) ? ["mode"] : [])])]);
  }
  return wanted;
}

function save(model: PlotModel, sourceOf: (axis: string) => Source | null, from_s: number, to_s: number): void {
  const source = sourceOf(model.axis);
  if (!source) return;
  const own = neededFields(model.device, model.chosen.peek()).map((name) => ({
    name: model.labelOf(name),
    units: model.unitsOf(name, model.device.fields.find((field) => field.name === name)?.unit ?? ""),
    column: source.columnOf(name),
  }));
  const others = model.otherFields().flatMap(({ name, unit }) => {
    const { axis, field } = besideOf(name)!;
    const other = sourceOf(axis);
    return other ? [{ name, units: model.unitsOf(name, unit), column: other.columnOf(field), of: other.layer.ring }] : [];
  });
  const csv = csvOf(source.layer, [...own, ...others], from_s, to_s);
  download(fileName(model.id, "csv"), new Blob([csv], { type: "text/csv" }));
}

/** Save the panes, and an x-y plot, as a picture. */
export async function savePng(model: PlotModel, panes: PlotPane[], xy?: HTMLCanvasElement): Promise<void> {
  const title = `${model.id}: ${samplingText(model.shownLayer(performance.now()).sampling)}`;
  const pictures: Picture[] = panes.map(({ plot, pane }) => ({ canvas: plot.ctx.canvas, names: pane.fields.map(({ name }) => model.labelOf(name)) }));
  if (xy) pictures.push({ canvas: xy, names: [] });
  const png = pictures.length ? await pngOf(title, pictures) : null;
  if (png) download(fileName(model.id, "png"), png);
  else notify("there is no plot to save", true);
}
