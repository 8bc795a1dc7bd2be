/** What passed at a port before the time of the past that is shown: the board's words, and what was typed. */

import { useEffect, useRef, useState } from "preact/hooks";
import { bytesOf, plainOf, TerminalText } from "../../model/terminal_text";
import { askPast, LANE, pastAt } from "../../past";

interface Piece {
  isTyped: boolean;
  text: string;
}

/** Text of both ways, pieces of one way together. */
function piecesOf(items: { to: string; hex: string }[]): Piece[] {
  const boards = new TerminalText();
  const typed = new TerminalText();
  const pieces: Piece[] = [];
  for (const { to, hex } of items) {
    const isTyped = to === "board";
    const text = plainOf((isTyped ? typed : boards).next(bytesOf(hex))).replace(RETURNS, "\n");
    const last = pieces.at(-1);
    if (last?.isTyped === isTyped) last.text += text;
    else pieces.push({ isTyped, text });
  }
  return pieces;
}

const RETURNS = /\r\n?/g;

export function PastTerminal({ port }: { port: string }) {
  const [pieces, setPieces] = useState<Piece[]>([]);
  const [why, setWhy] = useState("");
  const end = useRef<HTMLPreElement>(null);
  const at_s = pastAt.value;
  useEffect(() => {
    let isThere = true;
    if (at_s === null) return;
    askPast("past_bytes", { port, at_s, lane: LANE })
      .then((told) => {
        if (told && isThere) setPieces(piecesOf(told.items));
      })
      .catch((error: Error) => isThere && setWhy(error.message));
    return () => void (isThere = false);
  }, [port, at_s]);
  useEffect(() => end.current?.scrollTo(0, end.current.scrollHeight), [pieces]);
  return (
    <>
      {why && <p class="problem">{why}</p>}
      <pre class="past-terminal mono" ref={end} tabIndex={0} role="region" aria-label={`Words at ${port} until then`}>
        {pieces.map(({ isTyped, text }, at) =>
          isTyped ? (
            <span key={at} class="typed">
              {text}
            </span>
          ) : (
            text
          ),
        )}
      </pre>
      <p class="soft">What the board said, and in colour what was typed, until the shown time.</p>
    </>
  );
}
