// Bundles the page: node build.js <node_modules> <output folder>. Writes page.html, page.js and
// page.css.
import { copyFile, mkdir } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { fileURLToPath } from 'node:url';
import path from 'node:path';

const sources = path.join(path.dirname(fileURLToPath(import.meta.url)), 'src');
const [modules, output] = process.argv.slice(2).map((folder) => path.resolve(folder));
const { build } = createRequire(path.join(modules, 'build.js'))('esbuild');

await mkdir(output, { recursive: true });
const common = {
  outdir: output,
  bundle: true,
  minify: true,
  nodePaths: [modules],
  logLevel: 'warning',
  legalComments: 'inline',
};
await build({
  ...common,
  entryPoints: { page: path.join(sources, 'main.js') },
  format: 'iife',
  target: ['es2022'],
});
await build({ ...common, entryPoints: { page: path.join(sources, 'page.css') } });
await copyFile(path.join(sources, 'page.html'), path.join(output, 'page.html'));
