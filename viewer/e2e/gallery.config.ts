import { defineConfig } from "vitest/config";

// Takes the pictures of docs/gallery.md: `npm run gallery`, or one with `npm run gallery -- -t "Figure 5"`.
export default defineConfig({
  test: {
    root: import.meta.dirname,
    include: ["gallery.ts"],
    environment: "node",
    fileParallelism: false,
    testTimeout: 300_000,
    hookTimeout: 120_000,
  },
});
