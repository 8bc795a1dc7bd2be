/** Dials of shafts: a hand for the angle, a ring that grows with whole turns, a mark where it is to be. */

import { shown } from "../../model/numbers";
import { palette } from "../../parts/palette";

export interface Shaft {
  name: string;
  at_deg: number;
  /** Set-point; NaN: none is known. */
  to_deg: number;
}

const LEAST_PX = 84;
const TEXT_PX = 30;
const TICKS = 12;

/** Columns in which dials are largest. */
export function columnsFor(count: number, width: number, height: number): number {
  let [best, size] = [1, 0];
  for (let columns = 1; columns <= count; columns++) {
    const rows = Math.ceil(count / columns);
    const fits = Math.min(width / columns, height / rows - TEXT_PX);
    if (fits > size) [best, size] = [columns, fits];
  }
  return size >= LEAST_PX - TEXT_PX ? best : Math.max(Math.floor(width / LEAST_PX), 1);
}

export function drawShafts(context: CanvasRenderingContext2D, width: number, height: number, shafts: readonly Shaft[]): void {
  const columns = columnsFor(shafts.length, width, height);
  const rows = Math.ceil(shafts.length / columns);
  const [wide, high] = [width / columns, height / rows];
  const radius = Math.max(Math.min(wide, high - TEXT_PX) / 2 - 6, 6);
  shafts.forEach((shaft, at) => {
    const [x, y] = [((at % columns) + 0.5) * wide, Math.floor(at / columns) * high + (high - TEXT_PX) / 2];
    drawDial(context, x, y, radius, shaft);
    drawText(context, x, y + radius + 4, wide, shaft);
  });
}

function drawDial(context: CanvasRenderingContext2D, x: number, y: number, radius: number, { at_deg, to_deg }: Shaft): void {
  const colours = palette();
  const at = (deg: number, share: number): [number, number] => {
    const angle = ((deg - 90) * Math.PI) / 180;
    return [x + Math.cos(angle) * radius * share, y + Math.sin(angle) * radius * share];
  };
  const line = (deg: number, from: number, to: number, colour: string, width: number) => {
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.beginPath();
    context.moveTo(...at(deg, from));
    context.lineTo(...at(deg, to));
    context.stroke();
  };
  context.lineWidth = 1.5;
  context.strokeStyle = colours.line;
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.stroke();
  for (let tick = 0; tick < TICKS; tick++) line((tick * 360) / TICKS, tick % 3 ? 0.92 : 0.85, 1, colours.line, 1.5);
  if (Number.isFinite(to_deg)) line(to_deg, 0.78, 1.05, colours.traces[1]!, 3);
  if (!Number.isFinite(at_deg)) return;
  // The shaft with its flat, and a hand.
  context.fillStyle = colours.grid;
  context.beginPath();
  context.arc(x, y, radius * 0.42, ((at_deg - 90 + 40) * Math.PI) / 180, ((at_deg - 90 - 40 + 360) * Math.PI) / 180);
  context.closePath();
  context.fill();
  line(at_deg, 0, 0.82, colours.traces[0]!, Math.max(radius / 16, 2.5));
  context.fillStyle = colours.traces[0]!;
  context.beginPath();
  context.arc(x, y, Math.max(radius / 12, 3), 0, 2 * Math.PI);
  context.fill();
}

function drawText(context: CanvasRenderingContext2D, x: number, top: number, wide: number, { name, at_deg }: Shaft): void {
  const colours = palette();
  context.textAlign = "center";
  context.textBaseline = "top";
  context.font = `12px ${colours.mono}`;
  context.fillStyle = colours.soft;
  context.fillText(name, x, top, wide - 4);
  context.fillStyle = colours.ink;
  context.fillText(`${shown(at_deg, 1)}°`, x, top + 14, wide - 4);
}
