/** Numbers that a board prints, drawn over simulated time, as a serial plotter does. */

import { useEffect, useRef, useState } from "preact/hooks";
import uPlot from "uplot";
import type { Piece } from "../../model/port_record";
import { PrintedNumbers } from "../../model/printed_numbers";
import { shown } from "../../model/numbers";
import { palette } from "../../parts/palette";
import { theme } from "../../theme";
import type { TerminalPort } from "./terminal_port";

const DRAWN_EVERY_MS = 100;
const FONT_PX = 11;

/** Read the numbers of all that a port said. */
export function numbersOf(port: TerminalPort): PrintedNumbers {
  const numbers = new PrintedNumbers();
  numbers.add({ at_s: 0, bytes: Uint8Array.of(0x0a) }); // what is kept begins with a whole line, mostly
  for (const piece of port.record.pieces) numbers.add(piece);
  return numbers;
}

export function NumberPlot({ port }: { port: TerminalPort }) {
  const place = useRef<HTMLDivElement>(null);
  const numbers = useRef<PrintedNumbers | null>(null);
  const [told, setTold] = useState({ rows: 0, others: 0, names: [] as string[] });
  useEffect(() => {
    const known = { of: (numbers.current = numbersOf(port)) };
    let isNew = true;
    const hear = (piece: Piece | null) => {
      if (piece) known.of.add(piece);
      else known.of = numbers.current = numbersOf(port);
      isNew = true;
    };
    port.listeners.add(hear);
    const draw = () => {
      if (!isNew || document.hidden) return;
      isNew = false;
      const { times_s, others, names } = known.of;
      setTold({ rows: times_s.length, others, names: [...names] });
    };
    draw();
    const timer = window.setInterval(draw, DRAWN_EVERY_MS);
    return () => {
      window.clearInterval(timer);
      port.listeners.delete(hear);
    };
  }, [port]);
  const plot = useRef<uPlot | null>(null);
  const names = told.names.join("\n");
  useEffect(() => {
    if (!place.current || !names) return;
    const box = place.current;
    const made = made_plot(box, names.split("\n"));
    plot.current = made;
    const resize = new ResizeObserver(() => made.setSize(sizeOf(box)));
    resize.observe(box);
    return () => {
      resize.disconnect();
      made.destroy();
      plot.current = null;
    };
  }, [names, theme.value]);
  useEffect(() => {
    const known = numbers.current;
    if (plot.current && known) plot.current.setData([known.times_s, ...known.columns], !isZoomed(plot.current));
  }, [told, theme.value]);
  const last = (at: number) => shown(numbers.current?.columns[at]?.at(-1), 3);
  return (
    <div class="terminal-plot">
      {told.names.length > 0 && (
        <p class="pane-legend">
          {told.names.map((name, at) => (
            <span key={name} class={`trace trace-${(at % 6) + 1}`}>
              {/^\d+$/.test(name) ? `number ${name}` : name} <span class="mono trace-value">{last(at)}</span>
            </span>
          ))}
        </p>
      )}
      <div ref={place} class="number-plot" role="img" aria-label={`Numbers that ${port.port} prints: ${told.names.join(", ") || "none yet"}`} />
      <p class="soft">
        {told.names.length
          ? `${told.rows} lines of numbers${told.others ? `, and ${told.others} of other text` : ""}. Drag: zoom. Double click: all.`
          : "Lines of numbers are drawn: 20.5,40 or in:20.5 out:40, with commas, spaces or tabs between. None came yet."}
      </p>
    </div>
  );
}

function sizeOf(box: HTMLElement): { width: number; height: number } {
  return { width: Math.max(box.clientWidth, 100), height: Math.max(box.clientHeight, 60) };
}

/** Whether somebody looks at a part, which what comes leaves alone. */
function isZoomed({ data, scales }: uPlot): boolean {
  const { min, max } = scales["x"] ?? {};
  const times_s = data[0];
  return times_s.length > 1 && min !== undefined && max !== undefined && (min > times_s[0]! || max < times_s.at(-1)!);
}

function made_plot(box: HTMLElement, names: string[]): uPlot {
  const colours = palette();
  const font = `${FONT_PX}px ${colours.mono}`;
  const axis = { stroke: colours.soft, font, grid: { stroke: colours.grid, width: 1 }, ticks: { stroke: colours.line, width: 1, size: 4 } };
  return new uPlot(
    {
      ...sizeOf(box),
      legend: { show: false },
      scales: { x: { time: false } },
      axes: [
        { ...axis, size: 26, space: 70, values: (_plot, splits) => splits.map((value) => `${+value.toFixed(6)} s`) },
        { ...axis, size: 64, space: 26 },
      ],
      series: [
        {},
        ...names.map((label, at) => ({ label, stroke: colours.traces[at % colours.traces.length]!, width: 1.25, points: { show: false }, spanGaps: true })),
      ],
      cursor: { drag: { x: true, y: false } },
    },
    [[], ...names.map(() => [])],
    box,
  );
}
