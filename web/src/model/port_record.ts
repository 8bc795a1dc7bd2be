/** What a port said, with times, and what was sent to it, up to a limit: all that its terminal shows is made of it. Pure. */

export interface Piece {
  /** Simulated time at which the bench had it. */
  at_s: number;
  bytes: Uint8Array;
  /** True of what was sent to the port: its time is not known. */
  isSent?: boolean;
}

const MOST_BYTES = 1024 * 1024;
/** Pieces of single bytes take as much as bytes do. */
const MOST_PIECES = 50_000;

export class PortRecord {
  readonly pieces: Piece[] = [];
  /** Bytes of what it said that were kept and are gone. */
  gone = 0;
  private size = 0;

  add(piece: Piece): void {
    this.pieces.push(piece);
    this.size += piece.bytes.length;
    let first = 0;
    while (this.size > MOST_BYTES || this.pieces.length - first > MOST_PIECES) {
      const { bytes, isSent } = this.pieces[first++]!;
      this.size -= bytes.length;
      if (!isSent) this.gone += bytes.length;
    }
    if (first) this.pieces.splice(0, first);
  }

  clear(): void {
    this.pieces.length = 0;
    this.size = this.gone = 0;
  }
}
