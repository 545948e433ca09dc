/** Links in words and figures, as the table of sensors has them. */
import { fixed, milliseconds, percentage, sensorLabel } from "../format";
import { healthOf, type Severity } from "../health";
import type { Link } from "../protocol";

/** More sensors in one trouble are counted instead of named: the table below names them all. */
const NAMED = 2;
const MISSING = "–";

/** How many are well, and what ails the others: the worst first. */
export function linkSummary(links: readonly Link[]): string {
  const of = (severity: Severity) => links.filter((link) => healthOf(link.state).severity === severity);
  const good = of("good").length;
  const troubles = troublesOf([...of("bad"), ...of("warn")]);
  if (troubles.length === 0) return `${good} of ${links.length} sensors are well.`;
  return `${good} of ${links.length} well; ${troubles.join(", ")}.`;
}

function troublesOf(links: readonly Link[]): string[] {
  const named = new Map<string, string[]>();
  for (const link of links) {
    const { label } = healthOf(link.state);
    named.set(label, [...(named.get(label) ?? []), sensorLabel(link.sensor)]);
  }
  return [...named].flatMap(([label, names]) =>
    names.length > NAMED ? [`${names.length} ${label}`] : names.map((name) => `${name} ${label}`),
  );
}

/** Whether its figures are of now: of one that is not heard they are what it once said, or of nothing. */
export function isHeard(link: Pick<Link, "state">): boolean {
  return link.state !== "lost" && link.state !== "silent" && link.state !== "unbound";
}

/**
 * Rate, age, loss, offset, drift and battery. Of a sensor that is not heard only rate and age are known, and the
 * battery as it last was, which may be why.
 */
export function linkFigures(link: Link): string[] {
  const heard = isHeard(link);
  return [
    fixed(link.rateHz, 0),
    milliseconds(link.ageMs),
    heard ? percentage(link.loss) : MISSING,
    heard ? milliseconds(link.offsetMs) : MISSING,
    heard ? fixed(link.driftPpm, 1) : MISSING,
    link.battery === null ? MISSING : `${Math.round(link.battery)} %`,
  ];
}
