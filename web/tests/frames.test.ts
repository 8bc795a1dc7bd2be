import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { onFrames } from "../src/parts/frames";

describe("frames", () => {
  let asked = 0;

  beforeEach(() => {
    vi.useFakeTimers();
    vi.stubGlobal("window", globalThis);
    asked = 0;
    vi.stubGlobal("requestAnimationFrame", (frame: (at_ms: number) => void) => {
      asked++;
      return setTimeout(() => frame(performance.now()), 16);
    });
  });

  afterEach(() => {
    vi.unstubAllGlobals();
    vi.useRealTimers();
  });

  it("are asked for only where something is due", () => {
    let isDue = false;
    let drawn = 0;
    const end = onFrames({ isDue: () => isDue, draw: () => void drawn++ });
    vi.advanceTimersByTime(1000);
    expect([asked, drawn]).toEqual([1, 0]);
    isDue = true;
    vi.advanceTimersByTime(1000);
    expect(drawn).toBeGreaterThanOrEqual(25);
    expect(drawn).toBeLessThanOrEqual(31);
    end();
    const before = asked;
    vi.advanceTimersByTime(1000);
    expect(asked - before).toBeLessThanOrEqual(1);
    const again = onFrames({ isDue: () => true, draw: () => void drawn++ });
    const then = drawn;
    vi.advanceTimersByTime(100);
    expect(drawn).toBeGreaterThan(then);
    again();
  });
});
