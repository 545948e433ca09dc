// Pieces of one mesh, as an exported face has them: pictures on the skin, colours at the vertices of all else.
import assert from "node:assert/strict";
import { test } from "node:test";
import { BufferGeometry, Float32BufferAttribute, Group, Mesh, MeshStandardMaterial } from "three";
import { load } from "./load.mjs";

const { mergePieces } = await load("scene/merge.ts");

test("joined pieces have the attributes of all of them", () => {
  const position = new Float32BufferAttribute([0, 0, 0, 1, 0, 0, 0, 1, 0], 3);
  const piece = (attributes) => {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", position);
    for (const [name, size] of attributes) geometry.setAttribute(name, new Float32BufferAttribute(new Float32Array(3 * size).fill(0.5), size));
    geometry.setIndex([0, 1, 2]);
    return new Mesh(geometry, new MeshStandardMaterial());
  };
  const root = new Group();
  root.add(piece([["uv", 2], ["_color_0", 4]]), piece([["uv", 2], ["color", 4]]));
  mergePieces(root);
  assert.equal(root.children.length, 1);
  const { geometry, material } = root.children[0];
  assert.deepEqual(Object.keys(geometry.attributes).sort(), ["_color_0", "color", "position", "uv"]);
  assert.equal(geometry.attributes.color.getX(1), 0.5);
  assert.equal(geometry.groups.length, 2);
  assert.equal(material.length, 2);
});
