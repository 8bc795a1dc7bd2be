/** Place of a cursor in a YAML document: the keys that it is below, and whether a key or a value is written there.
 * It reads unfinished text, as it is typed; pure. */

export interface YamlPlace {
  /** Keys from the document's top to the mapping, or the list, that the cursor is in; items of lists are left out. */
  path: string[];
  /** Key whose value is written; null: a key is written, or an item of a list. */
  key: string | null;
  /** What is written of it so far. */
  typed: string;
  /** True in `{ }` and `[ ]`. */
  isFlow: boolean;
}

interface Level {
  indent: number;
  /** null: an item of a list. */
  key: string | null;
}

interface Flow {
  opened: "{" | "[";
  key: string | null;
}

/** A cursor is looked for from so many characters before it. */
const MOST_LOOKED_AT = 50_000;
const KEY = /^("[^"]*"|'[^']*'|[^\s{}[\],#:"'][^{}[\],#]*?)\s*:(?=\s|$)\s*/;

/** Place at the end of a text. */
export function placeAtEnd(before: string): YamlPlace {
  const levels: Level[] = [];
  const flows: Flow[] = [];
  let typed = "";
  let isValue = false;
  for (const line of before.slice(-MOST_LOOKED_AT).split("\n")) {
    let rest = line;
    isValue = false;
    if (flows.length === 0) {
      rest = withoutDashes(line, levels);
      const key = KEY.exec(rest);
      const column = line.length - rest.length;
      if (rest.trim() || rest === "") leave(levels, column, false);
      if (key) {
        levels.push({ indent: column, key: unquoted(key[1]!) });
        rest = rest.slice(key[0].length);
        isValue = true;
      }
    }
    typed = flowOf(rest, flows);
  }
  const path = levels.map(({ key }) => key).filter((key) => key !== null);
  if (flows.length) {
    const inner = flows.slice(0, -1).map(({ key }) => key);
    const last = flows[flows.length - 1]!;
    return { path: [...path, ...inner.filter((key) => key !== null)], key: last.key, typed: typed.trimStart(), isFlow: true };
  }
  const key = isValue ? (path.pop() ?? null) : null;
  return { path, key, typed: typed.trimStart(), isFlow: false };
}

/** Take the dashes before an item; each is a level of its own. */
function withoutDashes(line: string, levels: Level[]): string {
  let rest = line.trimStart();
  let dash = /^-(\s+|$)/.exec(rest);
  while (dash) {
    const column = line.length - rest.length;
    leave(levels, column, true);
    levels.push({ indent: column, key: null });
    rest = rest.slice(dash[0].length);
    dash = /^-(\s+|$)/.exec(rest);
  }
  return rest;
}

/** Leave the levels that something at a column is not in. A dash may stand below the very column of its key. */
function leave(levels: Level[], column: number, isDash: boolean): void {
  for (let last = levels.at(-1); last && (last.indent > column || (last.indent === column && (!isDash || last.key === null))); last = levels.at(-1))
    levels.pop();
}

/** Follow the brackets of a text; answers what stands behind the last mark. */
function flowOf(text: string, flows: Flow[]): string {
  let begin = 0;
  for (let at = 0; at < text.length; at++) {
    const char = text[at]!;
    const last = flows[flows.length - 1];
    if (char === '"' || char === "'") {
      const end = text.indexOf(char, at + 1);
      if (end < 0) break;
      at = end;
    } else if (char === "#" && (at === 0 || /\s/.test(text[at - 1]!))) {
      return "";
    } else if (char === "{" || char === "[") {
      flows.push({ opened: char, key: null });
      begin = at + 1;
    } else if (last && (char === "}" || char === "]")) {
      flows.pop();
      begin = at + 1;
    } else if (last && char === ",") {
      last.key = null;
      begin = at + 1;
    } else if (last?.opened === "{" && char === ":" && /\s|$/.test(text[at + 1] ?? "")) {
      last.key = unquoted(text.slice(begin, at).trim());
      begin = at + 1;
    }
  }
  return text.slice(begin);
}

function unquoted(key: string): string {
  return /^["'].*["']$/.test(key) ? key.slice(1, -1) : key;
}
