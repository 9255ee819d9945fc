import { defineConfig } from "vitest/config";

// Takes the small pictures of the scenes: `npm run thumbs`, or one with `npm run thumbs -- -t egg`.
export default defineConfig({
  test: {
    root: import.meta.dirname,
    include: ["thumbs.ts"],
    environment: "node",
    fileParallelism: false,
    testTimeout: 300_000,
    hookTimeout: 120_000,
  },
});
