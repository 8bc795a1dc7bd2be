/** Plots as files: a PNG of the shown panes. */

import { palette } from "../../parts/palette";

/** Offer a file for download. */
export function download(name: string, content: Blob): void {
  const url = URL.createObjectURL(content);
  const anchor = document.createElement("a");
  anchor.href = url;
  anchor.download = name;
  anchor.click();
  window.setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

/** A device's name as the beginning of a file's name. */
export function fileName(device: string, ending: string): string {
  const safe = device.replace(/[^\p{L}\p{N}._-]+/gu, "_").slice(0, 80) || "axis";
  return `${safe}.${ending}`;
}

const TITLE_PX = 18;

/** A plot that is drawn, and the names of its lines. */
export interface Picture {
  canvas: HTMLCanvasElement;
  names: string[];
}

/** Draw plots below one another, with their titles, as a PNG. */
export async function pngOf(title: string, panes: Picture[]): Promise<Blob | null> {
  const scale = devicePixelRatio;
  const width = Math.max(...panes.map((pane) => pane.canvas.width));
  const heights = panes.map((pane) => pane.canvas.height + TITLE_PX * scale);
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = heights.reduce((sum, height) => sum + height, TITLE_PX * scale);
  const context = canvas.getContext("2d");
  if (!context) return null;
  const colours = palette();
  context.fillStyle = colours.panel;
  context.fillRect(0, 0, canvas.width, canvas.height);
  const write = (text: string, x: number, y: number, colour: string) => {
    context.fillStyle = colour;
    context.fillText(text, x * scale, y);
  };
  context.font = `bold ${12 * scale}px ${colours.mono}`;
  write(title, 8, 13 * scale, colours.ink);
  context.font = `${11 * scale}px ${colours.mono}`;
  let top = TITLE_PX * scale;
  panes.forEach((pane, at) => {
    let left = 8;
    pane.names.forEach((name, number) => {
      write(name, left, top + 13 * scale, colours.traces[number % colours.traces.length]!);
      left += context.measureText(name).width / scale + 12;
    });
    context.drawImage(pane.canvas, 0, top + TITLE_PX * scale);
    top += heights[at]!;
  });
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}
