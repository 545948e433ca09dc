/**
 * The 53 shapes: their names, how a person calls them, which belong together, and which names in other people's files
 * stand for them.
 *
 * Left and right are the performer's own. Everything in the page that has one number a shape is in the order of `SHAPES`,
 * whatever order the session sends.
 */

/** The order of ICT-FaceKit, as in mien/face/profile.h. */
export const SHAPES = [
  "browDown_L", "browDown_R", "browInnerUp_L", "browInnerUp_R", "browOuterUp_L", "browOuterUp_R",
  "cheekPuff_L", "cheekPuff_R", "cheekSquint_L", "cheekSquint_R",
  "eyeBlink_L", "eyeBlink_R", "eyeLookDown_L", "eyeLookDown_R", "eyeLookIn_L", "eyeLookIn_R",
  "eyeLookOut_L", "eyeLookOut_R", "eyeLookUp_L", "eyeLookUp_R", "eyeSquint_L", "eyeSquint_R", "eyeWide_L", "eyeWide_R",
  "jawForward", "jawLeft", "jawOpen", "jawRight",
  "mouthClose", "mouthDimple_L", "mouthDimple_R", "mouthFrown_L", "mouthFrown_R", "mouthFunnel", "mouthLeft",
  "mouthLowerDown_L", "mouthLowerDown_R", "mouthPress_L", "mouthPress_R", "mouthPucker", "mouthRight",
  "mouthRollLower", "mouthRollUpper", "mouthShrugLower", "mouthShrugUpper", "mouthSmile_L", "mouthSmile_R",
  "mouthStretch_L", "mouthStretch_R", "mouthUpperUp_L", "mouthUpperUp_R", "noseSneer_L", "noseSneer_R",
] as const;

export const SHAPE_COUNT = SHAPES.length;

/** The number that stands for the tongue, which is sent beside the 53. */
export const TONGUE = SHAPE_COUNT;

const indices = new Map<string, number>(SHAPES.map((name, index) => [name, index]));

/** The place of a shape in `SHAPES`, or -1. */
export function shapeIndex(name: string): number {
  return indices.get(name) ?? -1;
}

/** The name of a shape or of the tongue. */
export function shapeName(index: number): string {
  return index === TONGUE ? "tongueOut" : (SHAPES[index] ?? "");
}

/** What a person calls it where nothing around it says which part of the face is meant: "Lower lip down, left". */
export function shapeLabel(index: number): string {
  for (const region of REGIONS) {
    for (const row of region.rows) {
      if (row.right === index && row.left === index) return row.full;
      if (row.right === index) return `${row.full}, right`;
      if (row.left === index) return `${row.full}, left`;
    }
  }
  return shapeName(index);
}

/** One line of the list of weights: a pair, drawn as one sees the performer (their right on the left), or one shape. */
export interface ShapeRow {
  /** Below the heading of its region. */
  label: string;
  /** By itself. */
  full: string;
  right: number;
  /** The same as `right` where the shape has no sides. */
  left: number;
}

export interface Region {
  name: string;
  rows: ShapeRow[];
}

function pair(label: string, stem: string, full = label): ShapeRow {
  return { label, full, right: shapeIndex(`${stem}_R`), left: shapeIndex(`${stem}_L`) };
}
function sides(label: string, stem: string, full: string): ShapeRow {
  return { label, full, right: shapeIndex(`${stem}Right`), left: shapeIndex(`${stem}Left`) };
}
function single(label: string, name: string, full = label): ShapeRow {
  const index = name === "tongueOut" ? TONGUE : shapeIndex(name);
  return { label, full, right: index, left: index };
}

/** All shapes and the tongue, each once. */
export const REGIONS: readonly Region[] = [
  {
    name: "Brows",
    rows: [
      pair("Inner up", "browInnerUp", "Inner brow up"), pair("Outer up", "browOuterUp", "Outer brow up"),
      pair("Down", "browDown", "Brow down"),
    ],
  },
  {
    name: "Eyes",
    rows: [
      pair("Blink", "eyeBlink"), pair("Squint", "eyeSquint", "Eye squint"), pair("Wide", "eyeWide", "Eye wide"),
      pair("Look up", "eyeLookUp"),
      pair("Look down", "eyeLookDown"), pair("Look in", "eyeLookIn"), pair("Look out", "eyeLookOut"),
    ],
  },
  {
    name: "Cheeks and nose",
    rows: [pair("Cheek puff", "cheekPuff"), pair("Cheek squint", "cheekSquint"), pair("Nose sneer", "noseSneer")],
  },
  {
    name: "Jaw",
    rows: [
      single("Open", "jawOpen", "Jaw open"), sides("Sideways", "jaw", "Jaw sideways"),
      single("Forward", "jawForward", "Jaw forward"),
    ],
  },
  {
    name: "Mouth",
    rows: [
      pair("Smile", "mouthSmile"), pair("Frown", "mouthFrown"), pair("Dimple", "mouthDimple"),
      pair("Stretch", "mouthStretch", "Mouth stretch"), pair("Upper up", "mouthUpperUp", "Upper lip up"),
      pair("Lower down", "mouthLowerDown", "Lower lip down"), pair("Press", "mouthPress", "Lips press"),
      sides("Sideways", "mouth", "Mouth sideways"), single("Close", "mouthClose", "Mouth close"),
      single("Funnel", "mouthFunnel"), single("Pucker", "mouthPucker"),
      single("Roll upper", "mouthRollUpper", "Upper lip roll"), single("Roll lower", "mouthRollLower", "Lower lip roll"),
      single("Shrug upper", "mouthShrugUpper", "Upper lip shrug"),
      single("Shrug lower", "mouthShrugLower", "Lower lip shrug"), single("Tongue out", "tongueOut"),
    ],
  },
];

/** Lower case without separators: "Eye_Blink-Left" becomes "eyeblinkleft". */
function plain(name: string): string {
  return name.toLowerCase().replace(/[^a-z0-9]/g, "");
}

const spellings = new Map<string, readonly number[]>();
SHAPES.forEach((name, index) => {
  spellings.set(plain(name), [index]);
  const side = /^(.*)_([LR])$/.exec(name);
  if (side) spellings.set(plain(`${side[1]}${side[2] === "L" ? "Left" : "Right"}`), [index]);
});
spellings.set("browinnerup", [shapeIndex("browInnerUp_L"), shapeIndex("browInnerUp_R")]);
spellings.set("cheekpuff", [shapeIndex("cheekPuff_L"), shapeIndex("cheekPuff_R")]);
spellings.set("tongueout", [TONGUE]);

/**
 * The shapes that a morph target's or an expression's name stands for: "jawOpen", "JawOpen", "eyeBlinkLeft",
 * "EyeBlink_L", "Face.eyeBlink_L", "blendShape1.eyeBlinkLeft". `browInnerUp` and `cheekPuff` in one piece give both
 * sides. Empty when it is none of them.
 */
export function shapesOfName(name: string): readonly number[] {
  const whole = spellings.get(plain(name));
  if (whole) return whole;
  const dot = name.lastIndexOf(".");
  if (dot >= 0) return spellings.get(plain(name.slice(dot + 1))) ?? [];
  return [];
}
