/** Problems of a file, each with its place. */

export interface FileProblem {
  readonly file: string;
  readonly line: number;
  readonly column: number;
  readonly text: string;
}

/** File that cannot be read, with all that is wrong in it. */
export class FileRefusal extends Error {
  constructor(readonly problems: readonly FileProblem[]) {
    super(problems.map((p) => `${p.file}:${p.line}:${p.column}: ${p.text}`).join("\n"));
    this.name = "FileRefusal";
  }
}

const LARGEST_BYTES = 100_000;

export interface FileLines {
  readonly lines: readonly string[];
  /** False: the file ends within its last line. */
  readonly isWhole: boolean;
}

/** Split a file of the companion into lines, which end CR LF or LF.
 * Throws FileRefusal: it is too long, or has other bytes than printable ASCII and TABs. */
export function fileLines(data: Uint8Array, file: string): FileLines {
  if (data.length > LARGEST_BYTES) {
    const text = `${data.length.toLocaleString("en")} bytes; a file of the companion has some thousand`;
    throw new FileRefusal([{ file, line: 1, column: 1, text }]);
  }
  const hasMark = data[0] === 0xef && data[1] === 0xbb && data[2] === 0xbf;
  const bytes = hasMark ? data.subarray(3) : data;
  const problems: FileProblem[] = [];
  let line = 1;
  let column = 1;
  bytes.forEach((byte, at) => {
    const isEnd = byte === 10 || (byte === 13 && bytes[at + 1] === 10);
    if (!isEnd && byte !== 9 && (byte < 0x20 || byte > 0x7e) && problems.length < 10) {
      const hex = byte.toString(16).padStart(2, "0");
      problems.push({ file, line, column, text: `the byte 0x${hex} is not ASCII text; take it out` });
    }
    column += 1;
    if (byte === 10) [line, column] = [line + 1, 1];
  });
  if (problems.length) throw new FileRefusal(problems);
  const text = String.fromCharCode(...bytes);
  const isWhole = text === "" || text.endsWith("\n");
  const lines = text.replaceAll("\r\n", "\n").replace(/\n$/, "");
  return { lines: text === "" ? [] : lines.split("\n"), isWhole };
}
