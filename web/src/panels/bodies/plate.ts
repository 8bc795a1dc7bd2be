/** An x-y plate from above: beam, carriage, and where it was. */

import { niceRange } from "../../model/decimate";
import { shown } from "../../model/numbers";
import type { PlateAxis } from "../../model/plate";
import { palette } from "../../parts/palette";

export interface Plate {
  at: [number, number];
  trail: readonly [number, number][];
  x: PlateAxis;
  y: PlateAxis;
}

const MARGIN_PX = 34;
const LEAST_MM = 40;

export function drawPlate(context: CanvasRenderingContext2D, width: number, height: number, { at, trail, x, y }: Plate): void {
  const colours = palette();
  const [left, right] = rangeOf(trail.map(([mm]) => mm).concat(at[0]), x);
  const [bottom, top] = rangeOf(trail.map(([, mm]) => mm).concat(at[1]), y);
  const scale = Math.min((width - 2 * MARGIN_PX) / (right - left), (height - 2 * MARGIN_PX) / (top - bottom));
  if (!(scale > 0)) return;
  const [wide, high] = [(right - left) * scale, (top - bottom) * scale];
  const [x0, y0] = [(width - wide) / 2, (height + high) / 2];
  const px = ([a, b]: readonly [number, number]): [number, number] => [x0 + (a - left) * scale, y0 - (b - bottom) * scale];
  context.fillStyle = colours.grid;
  context.fillRect(x0, y0 - high, wide, high);
  context.strokeStyle = colours.line;
  context.lineWidth = 1;
  context.strokeRect(x0, y0 - high, wide, high);
  context.font = `12px ${colours.mono}`;
  context.fillStyle = colours.soft;
  context.textBaseline = "top";
  context.textAlign = "left";
  context.fillText(`${left} mm`, x0, y0 + 4);
  context.textAlign = "center";
  context.fillText(`x: ${x.name}`, x0 + wide / 2, y0 + 4);
  context.textAlign = "right";
  context.fillText(`${right} mm`, x0 + wide, y0 + 4);
  context.textAlign = "left";
  context.textBaseline = "bottom";
  context.fillText(`y: ${y.name}, ${bottom} to ${top} mm`, x0, y0 - high - 4);
  if (trail.length > 1) {
    context.strokeStyle = colours.traces[2]!;
    context.lineWidth = 1.5;
    context.beginPath();
    for (const point of trail) context.lineTo(...px(point));
    context.stroke();
  }
  if (!Number.isFinite(at[0]) || !Number.isFinite(at[1])) return;
  const [ax, ay] = px(at);
  context.fillStyle = colours.line;
  context.fillRect(ax - 5, y0 - high, 10, high);
  context.fillStyle = colours.traces[0]!;
  context.fillRect(ax - 9, ay - 9, 18, 18);
  context.fillStyle = colours.panel;
  context.fillRect(ax - 2, ay - 2, 4, 4);
  context.fillStyle = colours.ink;
  context.textBaseline = "middle";
  context.textAlign = ax > width / 2 ? "right" : "left";
  context.fillText(`${shown(at[0], 1)}, ${shown(at[1], 1)} mm`, ax + (ax > width / 2 ? -14 : 14), ay - 16 < y0 - high ? ay + 16 : ay - 16);
}

/** What is shown: the machine's range, more where an axis was beyond it; without a machine whole steps about where it was. */
function rangeOf(values: readonly number[], { range_mm }: PlateAxis): [number, number] {
  const sound = values.filter(Number.isFinite);
  if (range_mm) return [Math.floor(Math.min(range_mm[0], ...sound)), Math.ceil(Math.max(range_mm[1], ...sound))];
  const range: [number, number] = [0, 1];
  niceRange(Math.min(0, ...sound), Math.max(0, ...sound), LEAST_MM, range);
  return range;
}
