// Version of the page: a checksum of all that the build reads. tests/test_web_build.py computes the same without Node.
import { createHash } from "node:crypto";
import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";

const SINGLE = ["build_version.mjs", "index.html", "package-lock.json", "package.json", "tsconfig.json", "vite.config.mjs"];

/** List the sources below `folder` as paths with slashes, sorted by their bytes. */
function sources(folder) {
  const below = readdirSync(join(folder, "src"), { recursive: true, withFileTypes: true })
    .filter((entry) => entry.isFile())
    .map((entry) =>
      join(entry.parentPath, entry.name)
        .slice(folder.length + 1)
        .replaceAll("\\", "/"),
    );
  return [...SINGLE, ...below].sort((a, b) => Buffer.compare(Buffer.from(a), Buffer.from(b)));
}

/** Compute the version of the sources below `folder`: 64 hexadecimal digits. */
export function buildVersion(folder) {
  const hash = createHash("sha256");
  for (const path of sources(folder)) {
    const content = readFileSync(join(folder, path));
    hash.update(`${path}\0${content.length}\0`).update(content);
  }
  return hash.digest("hex");
}
