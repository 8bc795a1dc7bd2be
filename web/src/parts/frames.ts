/** One loop of animation frames for all that is drawn, 30 times a second at most: nobody sees more of a plot that moves. A
 * frame is asked for only where something has to be drawn: it costs, however little is drawn in it. Each has a budget: what does
 * not fit waits for the next, in turn, so that a page full of plots stays usable on a slow computer. */

export interface Drawer {
  /** False while it is out of sight or nothing has changed: it is passed over. It is asked often. */
  isDue(): boolean;
  draw(now_ms: number): void;
}

const BUDGET_MS = 10;
/** Rest after a round, to the frame with which the next begins: a screen with 60 Hz has one each 16.7 ms. */
const REST_MS = 1000 / 30 - 16;

const drawers: Drawer[] = [];
let next = 0;
/** Number of the frame or of the timer that comes next, 0: nothing is drawn. */
let request = 0;
/** Drawers that have not had their turn in this round. */
let waiting = 0;

/** Draw something from now on; answers the function that ends it. */
export function onFrames(drawer: Drawer): () => void {
  drawers.push(drawer);
  if (!request) request = requestAnimationFrame(frame);
  return () => {
    const at = drawers.indexOf(drawer);
    if (at >= 0) drawers.splice(at, 1);
  };
}

function frame(now_ms: number): void {
  if (!waiting) waiting = drawers.length;
  drawInTurn(now_ms);
  if (!drawers.length) request = 0;
  else if (waiting) request = requestAnimationFrame(frame);
  else request = window.setTimeout(look, REST_MS);
}

/** Ask for a frame where something is due, else look again. */
function look(): void {
  if (drawers.some((drawer) => drawer.isDue())) request = requestAnimationFrame(frame);
  else request = drawers.length ? window.setTimeout(look, REST_MS) : 0;
}

function drawInTurn(now_ms: number): void {
  const begin = performance.now();
  waiting = Math.min(waiting, drawers.length);
  while (waiting > 0) {
    waiting--;
    if (next >= drawers.length) next = 0;
    const drawer = drawers[next++]!;
    if (!drawer.isDue()) continue;
    drawer.draw(now_ms);
    if (performance.now() - begin > BUDGET_MS) break;
  }
}

/** Number of the present interval of this length: what is drawn once in each is drawn in the same frames. */
export function slot(every_ms: number): number {
  return Math.floor(performance.now() / every_ms);
}

/** Whether an element is in sight, kept up to date. */
export class Sight {
  isIn = false;
  private readonly observer: IntersectionObserver;

  constructor(element: Element) {
    this.observer = new IntersectionObserver((entries) => {
      this.isIn = entries[entries.length - 1]?.isIntersecting ?? false;
    });
    this.observer.observe(element);
  }

  end(): void {
    this.observer.disconnect();
  }
}
