// Sensors of the rigs that the mock session has, as `hello` lists them.
import { readFileSync } from "node:fs";

/** One entry a sensor: the values of its keys, by `words` and `numbers`. */
function sensorsOf(rig, entryOf) {
  const text = readFileSync(new URL(`../../rigs/${rig}`, import.meta.url), "utf8");
  return text.split("[[sensor]]").slice(1).map((part) => {
    const words = (key) => new RegExp(`^${key} = "(.*)"`, "m").exec(part)?.[1] ?? "";
    const numbers = (key) => JSON.parse(new RegExp(`^${key} = (\\[.*\\])`, "m").exec(part)[1]);
    const sensor = { name: words("name"), kind: words("kind"), site: words("site"), side: words("side"), role: "face" };
    return { ...sensor, position_m: numbers("position_m"), ...entryOf(numbers) };
  });
}

export function eyewearSensors() {
  return sensorsOf("eyewear.toml", (numbers) => ({ aim: numbers("aim") }));
}

export function headsetSensors() {
  return sensorsOf("headset.toml", (numbers) => {
    const [position, target] = [numbers("position_m"), numbers("look_at_m")];
    const sight = target.map((value, i) => value - position[i]);
    return { aim: sight.map((value) => value / Math.hypot(...sight)) };
  });
}
