/** What a headset's cameras tell of a face, in words and figures: which shapes each sees, and where the face comes from. */
import type { Frame, RigSensor } from "./protocol";
import { countLetters, type Letter } from "./provenance";
import { SHAPES, shapeIndex } from "./shapes";

/** Sensors of this kind look at the face from afar. */
const CAMERA_KIND = "camera";

export function isCamera(sensor: RigSensor): boolean {
  return sensor.kind === CAMERA_KIND && sensor.position !== null;
}

/** A headset that covers the eyes: who wears it cannot read this page. */
export function seesAnEye(sensors: readonly RigSensor[]): boolean {
  return sensors.some((sensor) => isCamera(sensor) && sensor.site === "eye");
}

/** ICT's names begin with the part of the face, as in mien/face/shape_region.h. */
const UPPER = /^(brow|eye)/;

export type Half = "upper" | "lower";

export const HALVES: readonly { half: Half; name: string }[] = [
  { half: "upper", name: "Upper face" },
  { half: "lower", name: "Lower face" },
];

function shapesOf(half: Half): number[] {
  return SHAPES.flatMap((name, index) => (UPPER.test(name) === (half === "upper") ? [index] : []));
}

const OF_HALF: Readonly<Record<Half, number[]>> = { upper: shapesOf("upper"), lower: shapesOf("lower") };

const WORDS: Readonly<Record<Letter, string>> = {
  m: "measured", i: "interpolated", p: "predicted", h: "held", a: "from sound", n: "neutral", "?": "unknown",
};

/** How half of a face came about: as most of its shapes did. Of equally many the more modest one. */
export function originOf(provenance: string, half: Half): { letter: Letter; word: string } {
  const counts = countLetters(OF_HALF[half].map((index) => provenance.charAt(index)).join(""));
  let best: Letter = "n";
  for (const letter of ["n", "h", "a", "p", "i", "m"] as const) {
    if ((counts.get(letter) ?? 0) > (counts.get(best) ?? 0)) best = letter;
  }
  return { letter: best, word: WORDS[best] };
}

/** The shapes that a camera is there for: of its half of the face those of its side; of one before the middle all. */
export function shapesSeen(sensor: RigSensor): number[] {
  const half = OF_HALF[sensor.site === "mouth" ? "lower" : "upper"];
  if (sensor.side !== "L" && sensor.side !== "R") return half;
  return half.filter((index) => (SHAPES[index] ?? "").endsWith(`_${sensor.side}`));
}

/** How sure the session is of what a camera sees, 0 to 1. */
export function confidenceOf(seen: readonly number[], frame: Pick<Frame, "confidence">): number {
  if (seen.length === 0) return 0;
  return seen.reduce((sum, index) => sum + (frame.confidence[index] ?? 0), 0) / seen.length;
}

/** Above this a view is shown as bright as it is. */
const SURE = 0.8;
const DIMMEST = 0.3;

/** How bright a view is shown, 0 to 1: dimmer the less is known by it, and never gone. */
export function brightnessOf(confidence: number): number {
  return DIMMEST + (1 - DIMMEST) * Math.min(1, Math.max(0, confidence) / SURE);
}

const BLINKS = [shapeIndex("eyeBlink_L"), shapeIndex("eyeBlink_R")] as const;

/** How far the left and the right eye are open, 0 to 1, as the face shows them. */
export function opennessOf(frame: Pick<Frame, "weights">): [number, number] {
  const open = (index: number) => 1 - Math.min(1, Math.max(0, frame.weights[index] ?? 0));
  return [open(BLINKS[0]), open(BLINKS[1])];
}
