import { spawnSync } from "node:child_process";
import { copyFileSync, mkdirSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { afterAll, describe, expect, it } from "vitest";

const WEB = join(import.meta.dirname, "..");
const folder = mkdtempSync(join(tmpdir(), "hil-imports-"));
afterAll(() => rmSync(folder, { recursive: true }));

/** Tell what the page's linter says of a text, as if it stood in a file of the page. */
function told(path, text) {
  const file = join(folder, path);
  mkdirSync(dirname(file), { recursive: true });
  copyFileSync(join(WEB, "biome.jsonc"), join(folder, "biome.jsonc"));
  writeFileSync(file, `${text}\n`);
  const rules = ["noRestrictedImports", "noRestrictedGlobals"].map((rule) => `--only=style/${rule}`);
  const { stdout, stderr, status } = spawnSync(join(WEB, "node_modules/.bin/biome"), ["lint", ...rules, path], { cwd: folder, encoding: "utf8" });
  return status === 0 ? "" : stdout + stderr;
}

describe("the rules of imports", () => {
  it.each([
    ["src/model/ring.ts", 'import type { Link } from "../net/link";', "model is pure"],
    ["src/model/ring.ts", 'import { signal } from "@preact/signals";', "model is pure"],
    ["src/model/ring.ts", 'export const later = () => import("../store");', "model is pure"],
    ["src/model/ring.ts", "export const now = () => document.title;", "no page"],
    ["src/net/link.ts", 'import { notify } from "../parts/notices";', "net imports"],
    ["src/net/link.ts", 'import { runsView } from "../views/runs";', "net imports"],
    ["src/parts/help.tsx", 'import { link } from "../store";', "parts import"],
    ["src/views/path/index.tsx", 'import { text } from "../runs/run_text";', "no other view"],
    ["src/views/path/index.tsx", 'import "../runs/runs.css";', "no other view"],
    ["src/store.ts", 'import { notify } from "./parts/notices";', "no view and no part"],
  ])("%s: %s is refused", (path, text, why) => {
    expect(told(path, text)).toContain(why);
  });

  it("lets a view import what all share", () => {
    const shared = ["../view", "../../kept", "../../model/ring", "../../net/channels", "../../parts/notices", "../../store", "./path_state", "uplot"];
    expect(told("src/views/path/index.tsx", shared.map((from) => `import "${from}";`).join("\n"))).toBe("");
  });
});
