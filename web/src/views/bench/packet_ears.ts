/** Hears packets of a wire for triggers: put here by what knows how packets are read. */
export const packetEars = {
  hear:
    (_line: string, _words: string, _heard: (at_s: number) => void): (() => void) =>
    () =>
      undefined,
};
