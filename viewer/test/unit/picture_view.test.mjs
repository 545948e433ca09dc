import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./load.mjs";

const { describe, moved, readView, turned, zoomed } = await load("picture_view.ts");

const PLAIN = { crop: [0.3, 0.3, 0.4, 0.4], turnDeg: 0, mirror: false };

/** A view of a picture of numbers, as mien/headset/network_view.h has it: cut out, turned clockwise, mirrored. */
function seen(picture, { crop, turnDeg, mirror }) {
  const size = picture.length;
  const [left, top, width, height] = crop.map((edge) => Math.round(edge * size));
  let rows = picture.slice(top, top + height).map((row) => row.slice(left, left + width));
  for (let turn = 0; turn < turnDeg; turn += 90) rows = rows[0].map((_, x) => rows.map((row) => row[x]).reverse());
  return mirror ? rows.map((row) => [...row].reverse()) : rows;
}
const PICTURE = Array.from({ length: 50 }, (_, y) => Array.from({ length: 50 }, (_, x) => 100 * y + x));

test("what is shown moves as its buttons say, however it is turned and mirrored", () => {
  for (const turnDeg of [0, 90, 180, 270]) {
    for (const mirror of [false, true]) {
      const view = { ...PLAIN, turnDeg, mirror };
      const before = seen(PICTURE, view);
      const right = seen(PICTURE, { ...view, crop: moved(view, 1, 0) });
      assert.deepEqual(right.map((row) => row.slice(0, -1)), before.map((row) => row.slice(1)), `right, ${turnDeg} ${mirror}`);
      const down = seen(PICTURE, { ...view, crop: moved(view, 0, 1) });
      assert.deepEqual(down.slice(0, -1), before.slice(1), `down, ${turnDeg} ${mirror}`);
    }
  }
});

test("a turn is clockwise as one sees it", () => {
  for (const turnDeg of [0, 90, 180, 270]) {
    for (const mirror of [false, true]) {
      const view = { ...PLAIN, turnDeg, mirror };
      const before = seen(PICTURE, view);
      const clockwise = before[0].map((_, x) => before.map((row) => row[x]).reverse());
      assert.deepEqual(seen(PICTURE, { ...view, turnDeg: turned(view) }), clockwise, `${turnDeg} ${mirror}`);
    }
  }
});

test("no number of presses leaves the picture, or leaves less of it than the session takes", () => {
  const legal = ([left, top, width, height]) => left >= 0 && top >= 0 && width >= 0.05 && height >= 0.05 && left + width <= 1 && top + height <= 1;
  for (const crop of [[0.1, 0.18, 0.82, 0.82], [0, 0, 1, 1], [0.333, 0.1, 0.5, 0.9], [0.05, 0.9, 0.06, 0.1]]) {
    let view = { ...PLAIN, crop };
    let presses = 7;
    for (let i = 0; i < 400; ++i) {
      presses = (presses * 48271) % 2147483647;
      const [right, down] = [[1, 0], [-1, 0], [0, 1], [0, -1]][presses % 4];
      const next = presses % 3 === 0 ? zoomed(view, (presses >> 5) % 2 === 0) : moved(view, right, down);
      assert.ok(legal(next), JSON.stringify([view.crop, next]));
      view = { ...view, crop: next };
    }
    for (let i = 0; i < 60; ++i) view = { ...view, crop: zoomed(view, true) };
    assert.ok(legal(view.crop) && Math.min(view.crop[2], view.crop[3]) <= 0.06);
    for (let i = 0; i < 90; ++i) view = { ...view, crop: zoomed(view, false) };
    assert.ok(legal(view.crop) && Math.max(view.crop[2], view.crop[3]) === 1, JSON.stringify(view.crop));
  }
});

test("a view is read, and what is none is none", () => {
  assert.deepEqual(readView({ crop: [0, 0, 1, 1], turn_deg: 90, mirror: true }), { crop: [0, 0, 1, 1], turnDeg: 90, mirror: true });
  for (const none of [null, undefined, 7, {}, { crop: [0, 0, 1], turn_deg: 0, mirror: false }, { crop: [0, 0, 1, "1"], turn_deg: 0, mirror: false },
    { crop: [0, 0, 1, 1], turn_deg: "0", mirror: false }, { crop: [0, 0, 1, 1], turn_deg: 0 }]) assert.equal(readView(none), null);
});

test("a view in words", () => {
  assert.equal(describe({ crop: [0, 0, 1, 1], turnDeg: 0, mirror: false }), "whole picture");
  assert.equal(describe({ crop: [0.1, 0.18, 0.82, 0.8], turnDeg: 90, mirror: true }), "82 % × 80 % of the picture, turned 90°, mirrored");
});
