/** Which step of a recording is shown: of one that runs the session alone says it, so that any page shows the same. */
import { isLine } from "../prompt_protocol";
import type { Status } from "../protocol";

/** what and consent come before a recording, check and lines alternate while it runs, summary comes after. */
export type Step = "what" | "consent" | "check" | "lines" | "summary";

/**
 * `asked`: the step before a recording that somebody opened here; `dismissed`: the end of that take was put away. Null:
 * nothing is to be shown.
 */
export function stepOf(status: Pick<Status, "prompts" | "dataset"> | null, asked: "what" | "consent" | null, dismissed: string | null): Step | null {
  const dataset = status?.dataset ?? null;
  // Prompts go a moment later than the recording that they are of.
  const over = dataset?.over === true || (dataset !== null && dataset.error !== "");
  if (isLine(status?.prompts) && !over) return status?.prompts?.state === "block" ? "check" : "lines";
  if (dataset && !over) return "check";
  if (asked) return asked;
  return dataset && dismissed !== dataset.take ? "summary" : null;
}

/** Whether something is being recorded in this step. */
export function isRunning(step: Step | null): boolean {
  return step === "check" || step === "lines";
}
