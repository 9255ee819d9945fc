// Gzips the files of a folder where that saves a tenth or more: FILE becomes FILE.gz.
import { readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { gzipSync } from "node:zlib";

for (const entry of readdirSync(process.argv[2], { recursive: true, withFileTypes: true })) {
  if (!entry.isFile()) continue;
  const path = join(entry.parentPath ?? entry.path, entry.name);
  const whole = readFileSync(path);
  const small = gzipSync(whole, { level: 9 });
  if (small.length > 0.9 * whole.length) continue;
  writeFileSync(`${path}.gz`, small);
  rmSync(path);
}
