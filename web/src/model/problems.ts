/** Problems of a document, as the bench lists them: "file:line:column: text". Pure. */

export interface DocumentProblem {
  /** Line and column from 1 on; 0: of no line. */
  line: number;
  column: number;
  text: string;
}

/** Read the bench's text, or its list; lines that continue a problem belong to it. */
export function readProblems(told: unknown): DocumentProblem[] {
  const lines = typeof told === "string" ? told.split("\n") : Array.isArray(told) ? told.map(asText) : [];
  const problems: DocumentProblem[] = [];
  for (const line of lines) {
    if (!line.trim()) continue;
    const match = /^[^\s].*?:(\d+):(\d+): (.*)$/.exec(line);
    const last = problems[problems.length - 1];
    if (match) problems.push({ line: Number(match[1]), column: Number(match[2]), text: match[3] ?? "" });
    else if (last && /^\s/.test(line)) last.text += `\n${line}`;
    else problems.push({ line: 0, column: 0, text: line });
  }
  return problems;
}

function asText(told: unknown): string {
  if (typeof told === "string") return told;
  const problem = (told ?? {}) as Record<string, unknown>;
  if (typeof problem["line"] === "number") {
    const text = String(problem["text"] ?? problem["message"] ?? "");
    return `file:${problem["line"]}:${Number(problem["column"] ?? 1)}: ${text}`;
  }
  return JSON.stringify(told);
}
