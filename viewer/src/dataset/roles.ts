/** Which of a session's devices are phones that say how the face really is, and which are the sensors beside them. */
import { MICROPHONE } from "../panels/voice";
import type { Hello, Link, Status } from "../protocol";

const TRUTH = "truth";

function linksOf(hello: Hello | null, status: Status | null, wanted: (role: string, kind: string) => boolean): Link[] {
  const sensors = new Map((hello?.sensors ?? []).map((one) => [one.name, one]));
  return (status?.links ?? []).filter((link) => {
    const sensor = sensors.get(link.sensor);
    return wanted(sensor?.role ?? "", sensor?.kind ?? "");
  });
}

export function phonesOf(hello: Hello | null, status: Status | null): Link[] {
  return linksOf(hello, status, (role) => role === TRUTH);
}

/** All but phones and microphones. */
export function sensorsOf(hello: Hello | null, status: Status | null): Link[] {
  return linksOf(hello, status, (role, kind) => role !== TRUTH && kind !== MICROPHONE);
}
