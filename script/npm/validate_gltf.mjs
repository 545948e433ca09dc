// Runs the Khronos glTF validator on files: one line each, the first errors below it. Exit 1 when a file has errors.
//   node script/npm/validate_gltf.mjs FILE...
import { readFile } from 'node:fs/promises';
import { dirname, resolve } from 'node:path';
import validator from 'gltf-validator';

const files = process.argv.slice(2);
if (files.length === 0) {
  console.error('usage: node script/npm/validate_gltf.mjs FILE...');
  process.exit(2);
}

let bad = 0;
for (const file of files) {
  const report = await validator.validateBytes(new Uint8Array(await readFile(file)), {
    uri: file,
    maxIssues: 100,
    externalResourceFunction: (uri) => readFile(resolve(dirname(file), decodeURIComponent(uri))).then((b) => new Uint8Array(b)),
  });
  const { numErrors, numWarnings, messages } = report.issues;
  console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings`);
  for (const m of messages.filter((m) => m.severity === 0).slice(0, 10)) console.log(`  ${m.code} at ${m.pointer ?? m.offset}: ${m.message}`);
  if (numErrors > 0) bad += 1;
}
process.exit(bad === 0 ? 0 : 1);
