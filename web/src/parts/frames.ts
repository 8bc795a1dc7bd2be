/** One loop of animation frames for all that is drawn, 30 times a second: nobody sees more of a plot that moves. Each
 * frame has a budget: what does not fit waits for the next, in turn, so that a page full of plots stays usable on a slow
 * computer. */

export interface Drawer {
  /** False while it is out of sight or nothing has changed: it is passed over. */
  isDue(): boolean;
  draw(now_ms: number): void;
}

const BUDGET_MS = 5;
/** A round begins so long after the one before; frames of a screen with 60 Hz come a little early or late. */
const ROUND_MS = 1000 / 30 - 6;

const drawers: Drawer[] = [];
let next = 0;
let request = 0;
let roundBegan_ms = -Infinity;
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
  request = drawers.length ? requestAnimationFrame(frame) : 0;
  if (!waiting) {
    if (now_ms - roundBegan_ms < ROUND_MS) return;
    roundBegan_ms = now_ms;
    waiting = drawers.length;
  }
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
