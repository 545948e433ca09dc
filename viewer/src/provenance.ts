/** How a value came about: the letters of the protocol, and what the page says of them. */

export type Letter = "m" | "i" | "p" | "h" | "a" | "n" | "?";

export interface Provenance {
  letter: Letter;
  name: string;
  meaning: string;
}

/** In the order in which legends show them. The colours and patterns are `--prov-LETTER` and `.prov-LETTER` in theme.css. */
export const PROVENANCES: readonly Provenance[] = [
  { letter: "m", name: "measured", meaning: "Sensors that sent in time tell this shape." },
  { letter: "i", name: "interpolated", meaning: "A short gap was filled between samples on both sides." },
  { letter: "p", name: "predicted", meaning: "Guessed: the sensors that are there tell too little of this shape." },
  { letter: "a", name: "audio", meaning: "Heard in the voice." },
  { letter: "h", name: "held", meaning: "Nothing new for too long: the last value is kept." },
  { letter: "n", name: "neutral", meaning: "Not known: the resting face is shown." },
];

const UNKNOWN: Provenance = { letter: "?", name: "unknown", meaning: "The session sent a letter that this page does not know." };

export function provenanceOf(letter: string): Provenance {
  return PROVENANCES.find((one) => one.letter === letter) ?? UNKNOWN;
}

export function letterOf(text: string, index: number): Letter {
  return provenanceOf(text.charAt(index)).letter;
}

/** How many shapes have each letter. */
export function countLetters(text: string): Map<Letter, number> {
  const counts = new Map<Letter, number>();
  for (let i = 0; i < text.length; ++i) {
    const letter = letterOf(text, i);
    counts.set(letter, (counts.get(letter) ?? 0) + 1);
  }
  return counts;
}

/** What a face deserves to be called as a whole. */
export type Standing = "live" | "held" | "neutral" | "resting";

/**
 * `live` while at least one shape rests on something heard; else `held` (nothing but kept values), `neutral` (nothing
 * but the resting face), or `resting` (a mixture of the two).
 */
export function standingOf(text: string): Standing {
  let held = 0;
  let neutral = 0;
  for (let i = 0; i < text.length; ++i) {
    const letter = letterOf(text, i);
    if (letter === "h") ++held;
    else if (letter === "n" || letter === "?") ++neutral;
    else return "live";
  }
  if (neutral === 0 && held > 0) return "held";
  return held === 0 ? "neutral" : "resting";
}
