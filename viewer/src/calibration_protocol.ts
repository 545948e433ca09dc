/** What the session says of calibrations: a part of protocol.ts. */
import { type Fields, fieldsOf, idOf, list, number, numberOrNull, share, text } from "./reading";
import { SHAPES } from "./shapes";

export interface Score {
  name: string;
  value: number | null;
  unit: string;
  pass: boolean;
  sentence: string;
}

export interface CalibrationVersion {
  id: string | number;
  time: number | null;
  inForce: boolean;
  origin: string;
  scores: Score[];
}

export interface Look {
  leftDeg: number;
  upDeg: number;
}

export interface CalibrationStatus {
  state: "none" | "watching" | "running" | "done" | "failed";
  step: string;
  prompt: string;
  /** In our order; null when no face is to be shown. */
  target: Float32Array | null;
  /** Where to look, degrees to the performer's left and upwards; null while that is no matter. */
  look: Look | null;
  /** Of the present step, 0 to 1. */
  progress: number;
  remainingS: number | null;
  /** Which step this is, from 1, and of how many; 0 where the session does not say. */
  stepNumber: number;
  steps: number;
  /** Since the calibration in force was made, and since the re-centring after it, s; null without one. */
  ageS: number | null;
  recentredS: number | null;
  /** How well the sensors' rotations are known, degrees; null where nothing drifts. */
  sigmaDeg: number | null;
  /** Re-centring would gain. */
  advisesRecentring: boolean;
  versions: CalibrationVersion[];
}

/**
 * wearer: neutral, nod and shake, expressions, then a minute of others, from which skin sensors learn the wearer; gaze:
 * neutral, then points to look at, from which a headset's cameras learn where the wearer looks.
 */
export type CalibrationKind = "short" | "full" | "wearer" | "gaze";

function readVersion(one: Fields): CalibrationVersion {
  return {
    id: idOf(one["id"]),
    time: numberOrNull(one["time"]),
    inForce: one["in_force"] === true,
    origin: text(one["origin"]),
    scores: list(one["scores"], (score) => ({
      name: text(score["name"]),
      value: numberOrNull(score["value"]),
      unit: text(score["unit"]),
      pass: score["pass"] === true,
      sentence: text(score["sentence"]),
    })),
  };
}

/** A face to show, in our order. */
export function readTarget(value: unknown): Float32Array | null {
  if (typeof value !== "object" || value === null || Array.isArray(value)) return null;
  const target = fieldsOf(value);
  return Float32Array.from(SHAPES, (name) => share(target[name]));
}

/** No eye is asked to turn farther. */
const MOST_LOOK_DEG = 45;

function readLook(value: unknown): Look | null {
  if (typeof value !== "object" || value === null || Array.isArray(value)) return null;
  const fields = fieldsOf(value);
  const degrees = (one: unknown) => Math.max(-MOST_LOOK_DEG, Math.min(MOST_LOOK_DEG, number(one)));
  return { leftDeg: degrees(fields["yaw_deg"]), upDeg: degrees(fields["pitch_deg"]) };
}

export function readCalibration(fields: Fields): CalibrationStatus {
  const state = fields["state"];
  return {
    state: state === "watching" || state === "running" || state === "done" || state === "failed" ? state : "none",
    step: text(fields["step"]),
    prompt: text(fields["prompt"]),
    target: readTarget(fields["target"]),
    look: readLook(fields["look"]),
    progress: share(fields["progress"]),
    remainingS: numberOrNull(fields["remaining_s"]),
    stepNumber: Math.max(0, Math.round(number(fields["step_number"]))),
    steps: Math.min(64, Math.max(0, Math.round(number(fields["steps"])))),
    ageS: numberOrNull(fields["age_s"]),
    recentredS: numberOrNull(fields["recentred_s"]),
    sigmaDeg: numberOrNull(fields["sigma_deg"]),
    advisesRecentring: fields["advises_recentring"] === true,
    versions: list(fields["versions"], readVersion),
  };
}
