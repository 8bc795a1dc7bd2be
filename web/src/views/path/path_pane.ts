/** One view of a path on a canvas: two of the machine's axes. It can be zoomed and moved. */

import type { Drawing } from "../../model/drawing";
import { palette } from "../../parts/palette";
import { theme } from "../../theme";
import type { Followed } from "./path_followed";

const MARGIN_PX = 34;
/** Room that a number at the edge needs. */
const EDGE_PX = 24;
const FONT_PX = 11;
const LEAST_SPAN = 0.01;

interface Window {
  x: number;
  y: number;
  /** Pixels for a unit. */
  scale: number;
}

export class PathPane {
  private view: Window = { x: 0, y: 0, scale: 1 };
  private isFitted = true;
  private timer = 0;
  private drawn = "";
  private made: Drawing | null = null;
  private followed: Followed | null = null;
  /** The grid and the path asked for, and what was followed so far. */
  private readonly base = document.createElement("canvas");
  private readonly trail = document.createElement("canvas");
  private ground = "";
  private drawnPoints = 0;
  private readonly observer: ResizeObserver;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly across: number,
    private readonly up: number,
  ) {
    this.observer = new ResizeObserver(() => (this.isFitted ? this.fit() : this.changed()));
    this.observer.observe(canvas);
    canvas.addEventListener("wheel", this.onWheel, { passive: false });
    canvas.addEventListener("pointerdown", this.onDown);
    const loop = () => {
      this.timer = requestAnimationFrame(loop);
      this.draw();
    };
    this.timer = requestAnimationFrame(loop);
  }

  close(): void {
    cancelAnimationFrame(this.timer);
    this.observer.disconnect();
    this.canvas.removeEventListener("wheel", this.onWheel);
    this.canvas.removeEventListener("pointerdown", this.onDown);
  }

  show(made: Drawing | null, followed: Followed | null): void {
    const isOther = made !== this.made;
    [this.made, this.followed] = [made, followed];
    if (isOther) this.fit();
    this.changed();
  }

  /** Show the whole path. */
  fit(): void {
    const ends = this.ends();
    const [width, height] = [this.canvas.clientWidth - 2 * MARGIN_PX, this.canvas.clientHeight - 2 * MARGIN_PX];
    if (!ends || width <= 0 || height <= 0) return this.changed();
    const [left, right, bottom, top] = ends;
    const scale = Math.min(width / Math.max(right - left, LEAST_SPAN), height / Math.max(top - bottom, LEAST_SPAN));
    this.view = { x: (left + right) / 2, y: (bottom + top) / 2, scale };
    this.isFitted = true;
    this.changed();
  }

  /** Zoom around the middle, or around a place of the canvas in pixels. */
  zoom(factor: number, atX = this.canvas.clientWidth / 2, atY = this.canvas.clientHeight / 2): void {
    const [x, y] = this.placeAt(atX, atY);
    const scale = Math.min(Math.max(this.view.scale * factor, 1e-3), 1e6);
    this.view = { scale, x: x - (atX - this.canvas.clientWidth / 2) / scale, y: y + (atY - this.canvas.clientHeight / 2) / scale };
    this.isFitted = false;
    this.changed();
  }

  move(acrossPx: number, upPx: number): void {
    this.view = { ...this.view, x: this.view.x - acrossPx / this.view.scale, y: this.view.y + upPx / this.view.scale };
    this.isFitted = false;
    this.changed();
  }

  private changed(): void {
    this.drawn = "";
  }

  private placeAt(xPx: number, yPx: number): [number, number] {
    const { x, y, scale } = this.view;
    return [x + (xPx - this.canvas.clientWidth / 2) / scale, y - (yPx - this.canvas.clientHeight / 2) / scale];
  }

  private ends(): [number, number, number, number] | null {
    const { made } = this;
    if (!made?.count) return null;
    const ends: [number, number, number, number] = [Infinity, -Infinity, Infinity, -Infinity];
    for (let point = 0; point < made.count; point++) {
      const x = made.places[point * made.axes.length + this.across]!;
      const y = made.places[point * made.axes.length + this.up]!;
      if (x < ends[0]) ends[0] = x;
      if (x > ends[1]) ends[1] = x;
      if (y < ends[2]) ends[2] = y;
      if (y > ends[3]) ends[3] = y;
    }
    return ends;
  }

  private readonly onWheel = (event: WheelEvent): void => {
    event.preventDefault();
    this.zoom(Math.exp(-event.deltaY * 0.0015), event.offsetX, event.offsetY);
  };

  private readonly onDown = (event: PointerEvent): void => {
    this.canvas.setPointerCapture(event.pointerId);
    const onMove = (moved: PointerEvent): void => this.move(moved.movementX, moved.movementY);
    const onUp = (): void => {
      this.canvas.removeEventListener("pointermove", onMove);
      this.canvas.removeEventListener("pointerup", onUp);
      this.canvas.removeEventListener("pointercancel", onUp);
    };
    this.canvas.addEventListener("pointermove", onMove);
    this.canvas.addEventListener("pointerup", onUp);
    this.canvas.addEventListener("pointercancel", onUp);
  };

  private draw(): void {
    const { canvas, made, followed } = this;
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const ground = `${width} ${height} ${ratio} ${theme.peek()}`;
    const state = `${ground} ${followed?.changes ?? 0}`;
    if (state === this.drawn || width <= 0) return;
    if (this.drawn === "" || ground !== this.ground) {
      for (const each of [canvas, this.base, this.trail]) {
        each.width = Math.round(width * ratio);
        each.height = Math.round(height * ratio);
        each.getContext("2d")?.scale(ratio, ratio);
      }
      this.drawnPoints = 0;
      const base = this.base.getContext("2d")!;
      this.drawGrid(base, width, height);
      if (made) this.drawAsked(base, made, palette().soft);
    }
    [this.ground, this.drawn] = [ground, state];
    const context = canvas.getContext("2d");
    if (!context) return;
    context.clearRect(0, 0, width, height);
    context.drawImage(this.base, 0, 0, width, height);
    if (followed?.count) this.drawFollowed(context, followed, width, height);
  }

  /** Draw what was followed: a long path is drawn once, and then what is new of it. */
  private drawFollowed(context: CanvasRenderingContext2D, followed: Followed, width: number, height: number): void {
    const trail = this.trail.getContext("2d")!;
    if (followed.count < this.drawnPoints) {
      trail.clearRect(0, 0, width, height);
      this.drawnPoints = 0;
    }
    const colour = palette().traces[1]!;
    trail.strokeStyle = colour;
    trail.lineWidth = 1.6;
    trail.beginPath();
    const last = this.line(trail, followed.places, followed.axes, this.drawnPoints - 1, followed.count);
    trail.stroke();
    this.drawnPoints = followed.count;
    context.drawImage(this.trail, 0, 0, width, height);
    context.fillStyle = colour;
    context.beginPath();
    context.arc(last[0], last[1], 4, 0, 2 * Math.PI);
    context.fill();
  }

  private drawAsked(context: CanvasRenderingContext2D, made: Drawing, soft: string): void {
    const colours = palette();
    context.lineWidth = 1;
    context.strokeStyle = soft;
    context.setLineDash([2, 4]);
    context.beginPath();
    for (const [from, to] of made.rapids) this.line(context, made.places, made.axes.length, from - 1, to);
    context.stroke();
    context.setLineDash([]);
    context.strokeStyle = colours.accent;
    context.lineWidth = 1.2;
    context.beginPath();
    let from = 0;
    for (const [begin, end] of [...made.rapids, [made.count, made.count] as [number, number]]) {
      if (begin - from > 1) this.line(context, made.places, made.axes.length, from, begin);
      from = end - 1;
    }
    context.stroke();
  }

  /** Add points to a path, those nearer than half a pixel to the one before left out; answers the last. */
  private line(context: CanvasRenderingContext2D, places: ArrayLike<number>, axes: number, from: number, to: number): [number, number] {
    const { x, y, scale } = this.view;
    const [middleX, middleY] = [this.canvas.clientWidth / 2, this.canvas.clientHeight / 2];
    let [lastX, lastY] = [NaN, NaN];
    let [atX, atY] = [0, 0];
    for (let point = Math.max(from, 0); point < to; point++) {
      atX = middleX + (places[point * axes + this.across]! - x) * scale;
      atY = middleY - (places[point * axes + this.up]! - y) * scale;
      if (Number.isNaN(lastX)) context.moveTo(atX, atY);
      else if (Math.abs(atX - lastX) + Math.abs(atY - lastY) < 0.5 && point < to - 1) continue;
      else context.lineTo(atX, atY);
      [lastX, lastY] = [atX, atY];
    }
    return [atX, atY];
  }

  private drawGrid(context: CanvasRenderingContext2D, width: number, height: number): void {
    const colours = palette();
    const step = niceStep(60 / this.view.scale);
    const [left, top] = this.placeAt(0, 0);
    const [right, bottom] = this.placeAt(width, height);
    context.font = `${FONT_PX}px ${colours.mono}`;
    context.fillStyle = colours.soft;
    context.lineWidth = 1;
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    for (let at = Math.ceil(left / step) * step; at <= right; at += step) {
      const px = Math.round((at - left) * this.view.scale) + 0.5;
      context.strokeStyle = Math.abs(at) < step / 2 ? colours.line : colours.grid;
      segment(context, px, 0, px, height);
      context.textAlign = "center";
      if (px > EDGE_PX && px < width - EDGE_PX) context.fillText((Math.abs(at) < step / 2 ? 0 : at).toFixed(digits), px, height - 4);
    }
    for (let at = Math.ceil(bottom / step) * step; at <= top; at += step) {
      const px = Math.round((top - at) * this.view.scale) + 0.5;
      context.strokeStyle = Math.abs(at) < step / 2 ? colours.line : colours.grid;
      segment(context, 0, px, width, px);
      context.textAlign = "left";
      if (px > EDGE_PX) context.fillText((Math.abs(at) < step / 2 ? 0 : at).toFixed(digits), 3, px - 3);
    }
    context.fillText(this.axisName(this.up), 3, 12);
    context.textAlign = "right";
    context.fillText(this.axisName(this.across), width - 4, height - 18);
  }

  /** Letter and unit of an axis: "X in mm". */
  private axisName(index: number): string {
    const axis = this.made?.axes[index];
    return axis ? `${axis.letter.toUpperCase()} in ${axis.unit}` : "";
  }
}

function segment(context: CanvasRenderingContext2D, fromX: number, fromY: number, toX: number, toY: number): void {
  context.beginPath();
  context.moveTo(fromX, fromY);
  context.lineTo(toX, toY);
  context.stroke();
}

/** Least of 1, 2, 5 times a power of ten that is this or more. */
export function niceStep(least: number): number {
  const power = 10 ** Math.floor(Math.log10(least));
  return power * (least / power <= 1 ? 1 : least / power <= 2 ? 2 : least / power <= 5 ? 5 : 10);
}
