import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { defineConfig } from "vite";
import { buildVersion } from "./build_version.mjs";

const here = import.meta.dirname;
const out = process.env.HIL_WEB_OUT ?? join(here, "../bridges/web/static");
const version = buildVersion(here);

/** Write build.json beside the page: the server tells it, and the page compares it with its own. */
const tellVersion = {
  name: "tell-version",
  apply: "build",
  closeBundle() {
    writeFileSync(join(out, "build.json"), `${JSON.stringify({ version })}\n`);
  },
};

export default defineConfig({
  base: "./",
  define: { BUILD_VERSION: JSON.stringify(version) },
  plugins: [tellVersion],
  build: {
    outDir: out,
    emptyOutDir: true,
    target: "es2022",
    cssCodeSplit: false,
    modulePreload: { polyfill: false },
    assetsInlineLimit: 0,
    rolldownOptions: {
      output: {
        entryFileNames: "page.js",
        // All of the first view is in the page's script, also what is shared with the parts that are loaded later.
        codeSplitting: { groups: [{ name: "page", tags: ["$initial"] }] },
        // A page that stays over a new version must not get half of another one: its parts have names of their own.
        chunkFileNames: "[name]-[hash].js",
        assetFileNames: "page[extname]",
      },
    },
  },
});
