/** Which part of a camera's pictures the network sees, how it is turned, and what each button makes of that. */

/** Shares of the picture as it comes: left, top, width, height. */
export type Crop = [number, number, number, number];

/** What is cut out is turned clockwise, then mirrored. */
export interface PictureView {
  crop: Crop;
  turnDeg: number;
  mirror: boolean;
}

/** Crops are told in thousandths: their sums then leave no picture by rounding. */
const FINE = 1000;
/** Less of a picture the session refuses. */
const LEAST = 0.05 * FINE;
/** How far one press moves what is seen, and how much it shows less or more. */
const STEP = 0.02 * FINE;
const CLOSER = 0.92;

const within = (value: number, least: number, most: number) => Math.min(most, Math.max(least, value));

function cropOf(left: number, top: number, width: number, height: number): Crop {
  return [left, top, width, height].map((edge) => Math.round(edge) / FINE) as Crop;
}

/** Null where it is none. */
export function readView(value: unknown): PictureView | null {
  if (typeof value !== "object" || value === null) return null;
  const { crop, turn_deg: turnDeg, mirror } = value as Record<string, unknown>;
  const isCrop = Array.isArray(crop) && crop.length === 4 && crop.every((edge) => typeof edge === "number" && Number.isFinite(edge));
  if (!isCrop || typeof turnDeg !== "number" || typeof mirror !== "boolean") return null;
  return { crop: crop as Crop, turnDeg, mirror };
}

/** What is shown moves by so many steps of the crop, right and down as one looks at it. */
export function moved(view: PictureView, right: number, down: number): Crop {
  let [x, y] = [view.mirror ? -right : right, down];
  for (let turn = 0; turn < view.turnDeg; turn += 90) [x, y] = [y, -x];
  const [left, top, width, height] = view.crop.map((edge) => Math.round(edge * FINE)) as Crop;
  return cropOf(within(left + STEP * x, 0, FINE - width), within(top + STEP * y, 0, FINE - height), width, height);
}

/** Less of the picture, around the same middle; or more, as far as there is any. */
export function zoomed(view: PictureView, closer: boolean): Crop {
  const [left, top, width, height] = view.crop.map((edge) => Math.round(edge * FINE)) as Crop;
  let factor = closer ? CLOSER : 1 / CLOSER;
  // Both sides by the same, so that nothing is stretched otherwise than before.
  factor = Math.max(Math.min(factor, FINE / width, FINE / height), Math.min(1, Math.max(LEAST / width, LEAST / height)));
  const [wide, high] = [Math.round(width * factor), Math.round(height * factor)];
  return cropOf(within(Math.round(left + (width - wide) / 2), 0, FINE - wide), within(Math.round(top + (height - high) / 2), 0, FINE - high), wide, high);
}

/** What is shown is turned clockwise by a quarter: before it is mirrored that is the other way round. */
export function turned(view: PictureView): number {
  return (view.turnDeg + (view.mirror ? 270 : 90)) % 360;
}

/** For people: "62 % × 62 %, turned 90°, mirrored". */
export function describe(view: PictureView): string {
  const percent = (share: number) => `${Math.round(100 * share)} %`;
  const [, , width, height] = view.crop;
  const words = [width === 1 && height === 1 ? "whole picture" : `${percent(width)} × ${percent(height)} of the picture`];
  if (view.turnDeg !== 0) words.push(`turned ${view.turnDeg}°`);
  if (view.mirror) words.push("mirrored");
  return words.join(", ");
}
