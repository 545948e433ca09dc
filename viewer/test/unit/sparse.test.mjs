// Morph targets without what they do not move, and the names of software renderers.
import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./load.mjs";

const { sparse, addSparse } = await load("scene/sparse.ts");
const { isSoftware } = await load("scene/software.ts");

test("a target keeps only what it moves, and adds it by weight", () => {
  const target = sparse(Float32Array.of(0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, -4));
  assert.deepEqual([...target.vertices], [1, 3]);
  const surface = new Float32Array(12).fill(1);
  addSparse(target, 0.5, surface);
  assert.deepEqual([...surface], [1, 1, 1, 1, 2, 1, 1, 1, 1, 1.5, 1, -1]);
  addSparse(target, 0, surface);
  assert.equal(surface[4], 2);
});

test("a target that moves nothing is empty", () => {
  assert.equal(sparse(new Float32Array(9)).vertices.length, 0);
});

test("software renderers are told by their names", () => {
  for (const name of ["ANGLE (Google, Vulkan 1.3.0 (SwiftShader Device (Subzero)), SwiftShader driver)",
    "llvmpipe (LLVM 15.0.6, 256 bits)", "ANGLE (Microsoft, Microsoft Basic Render Driver)"]) assert.ok(isSoftware(name), name);
  for (const name of ["ANGLE (NVIDIA, NVIDIA GeForce RTX 3060)", "Apple M2", "Mesa Intel(R) UHD Graphics 620", ""]) {
    assert.ok(!isSoftware(name), name);
  }
});
