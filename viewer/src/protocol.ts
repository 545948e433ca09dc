/**
 * What the page and the session say to each other (docs/reference/page_protocol.md), typed, and read with care: whatever is missing
 * or is not what it should be becomes the harmless value of its kind, and nothing here throws. `readMessage` gives null
 * for what cannot be used at all.
 */
import { type CalibrationKind, type CalibrationStatus, readCalibration } from "./calibration_protocol";
import { type DatasetCommand, type DatasetStatus, readDataset } from "./dataset_protocol";
import { type LessonCommand, type PhoneLesson, readLesson } from "./lesson_protocol";
import { type Hearing, type MicrophoneOver, readHearing } from "./hearing_protocol";
import { type NetworkStatus, readNetwork } from "./network_protocol";
import { type CameraPicture, type PicturesStatus, readPictures } from "./picture_protocol";
import { type Crop, type PictureView, readView } from "./picture_view";
import { type PromptDeed, type PromptStatus, readPrompts } from "./prompt_protocol";
import { readVideo, type VideoOver, type VideoStatus } from "./video_protocol";
import { type Fields, fieldsOf, idOf, list, number, numberOrNull, share, text, texts } from "./reading";
import { SHAPE_COUNT, SHAPES } from "./shapes";

export interface RigSensor {
  name: string;
  kind: string;
  site: string;
  side: string;
  role: string;
  /** On the built-in face's neutral, frame H, metres; null where the rig does not say. */
  position: readonly [number, number, number] | null;
  /** Which way it looks at the skin, unit; null for a sensor that sits on it. */
  aim: readonly [number, number, number] | null;
}

export interface Hello {
  type: "hello";
  software: string;
  /** For each shape of ours, its place in what the session sends, or -1. */
  order: Int16Array;
  rigName: string;
  sensors: RigSensor[];
  face: string;
  model: string;
  mode: "live" | "replay";
  listening: string[];
}

export interface Frame {
  type: "frame";
  index: number;
  /** Seconds of the reference's clock. */
  time: number;
  weights: Float32Array;
  confidence: Float32Array;
  /** `SHAPE_COUNT` letters. */
  provenance: string;
  tongueOut: number;
  /** w, x, y, z; unit. */
  head: readonly [number, number, number, number];
  headConfidence: number;
  headProvenance: string;
  /** Yaw and pitch of the left, then of the right eye; radians, yaw to the performer's left, pitch up. */
  eyes: readonly [number, number, number, number];
  eyesConfidence: number;
  eyesProvenance: string;
  truth: Float32Array | null;
}

/** Somebody who sends as a sensor's device, and is not heard as it. */
export interface Rival {
  /** An address, as the session's log names it. */
  source: string;
  ageMs: number | null;
  /** It does not behave as a sensor does. */
  implausible: boolean;
}

export interface Link {
  sensor: string;
  device: string;
  /** Where the readings come from that are heard; empty while none came. */
  source: string;
  rivals: Rival[];
  state: string;
  ageMs: number | null;
  rateHz: number | null;
  lost: number;
  late: number;
  doubled: number;
  reordered: number;
  malformed: number;
  /** Share of packets over the last seconds, 0 to 1. */
  loss: number | null;
  offsetMs: number | null;
  driftPpm: number | null;
  uncertaintyMs: number | null;
  battery: number | null;
  headingSigmaDeg: number | null;
  /** How well its rotation is known, degrees; null where it is not there, or nothing drifts. */
  rotationSigmaDeg: number | null;
  /** It is too uncertain: frames are answered without it. */
  leftOut: boolean;
  /** How much it gets of what it is there for, 0 to 1; null for kinds that have no such number. */
  level: number | null;
  estimated: boolean;
  /** Of a camera: which part of its pictures the network sees. */
  view: PictureView | null;
}

export interface UnboundDevice {
  device: string;
  announces: string;
  ageMs: number | null;
  protocol: string;
}

export interface SinkStatus {
  id: string | number;
  address: string;
  on: boolean;
  sent: number;
  failed: number;
  rateHz: number | null;
  receivers: number | null;
  note: string;
}

export interface Shaping {
  smoothing: number;
  /** The face at rest is learnt while it is worn. */
  resting: boolean;
  /** Blinks a minute of lids that no sensor observes, 0 to 60; 0: none. */
  blinks_per_min: number;
  /** All rules between shapes are obeyed, not only those that always hold. */
  constraints: boolean;
  lids_follow_eyes: boolean;
  /** What is taken for each shape's rest now, where that is not 0. */
  rests: Map<string, number>;
  gains: Map<string, number>;
  limits: Map<string, readonly [number, number]>;
}

export interface ReplayStatus {
  take: string;
  time: number;
  duration: number;
  paused: boolean;
  hasTruth: boolean;
}

export interface Status {
  type: "status";
  time: number | null;
  frames: number;
  missed: number;
  latency: { p50: number; p99: number; max: number } | null;
  /** By how much frames are held for packets that come late, beside that latency; 0 while they are in time. */
  holdMs: number;
  links: Link[];
  unbound: UnboundDevice[];
  calibration: CalibrationStatus;
  prompts: PromptStatus | null;
  /** The dataset's recording that runs, or that ran last. */
  dataset: DatasetStatus | null;
  /** The video beside it; null where none was agreed to. */
  video: VideoStatus | null;
  /** What comes of learning from a phone. */
  phoneLesson: PhoneLesson | null;
  sinks: SinkStatus[];
  /** Null of a session that does not say. */
  network: NetworkStatus | null;
  /** `endsS`: when the session ends by itself, and the recording with it. */
  recording: { on: boolean; path: string; seconds: number; endsS: number | null; megabytes: number; error: string };
  /** What is kept of the session until its end. `error`: why it can be recorded no more, or "". */
  log: { megabytes: number; limitMegabytes: number; hoursLeft: number | null; error: string };
  shaping: Shaping;
  /** Null where there is no microphone. */
  hearing: Hearing | null;
  /** Null where no camera is asked for its pictures. */
  pictures: PicturesStatus | null;
  replay: ReplayStatus | null;
  /** The sensor that waits for a tap. */
  tap: string | null;
  /** The camera whose lens is to be covered, and why the last wait for one ended without it, or "". */
  cover: { sensor: string | null; trouble: string };
}

export interface Reply {
  type: "reply";
  id: number;
  ok: boolean;
  error: string;
  result: Fields | null;
}

export interface SessionEvent {
  type: "event";
  kind: string;
  text: string;
}

export interface Take {
  name: string;
  seconds: number | null;
  /** Why it cannot be read; empty when it can, or was not looked at yet. */
  error: string;
  megabytes: number | null;
  recorded: string;
}

/** Sent unasked when lengths of takes that the list left open have been read. */
export interface Takes {
  type: "takes";
  takes: Take[];
}

export type Message = Hello | Frame | Status | Reply | SessionEvent | Takes | MicrophoneOver | VideoOver | CameraPicture;

/** What is to be another of a camera's view; the rest stays. */
export interface ViewChange {
  crop?: Crop;
  turn_deg?: number;
  mirror?: boolean;
}

/** What the page may ask for; `id` is added by the connection. */
export type Command =
  | { command: "calibrate"; kind: CalibrationKind }
  | { command: "cancel_calibration" }
  | { command: "use_calibration"; version: string | number }
  | { command: "recentre" }
  | { command: "prompts"; do: PromptDeed }
  | DatasetCommand
  | LessonCommand
  | { command: "record"; on: boolean; name: string }
  | { command: "sink"; add: string }
  | { command: "sink"; sink: string | number; on: boolean }
  | { command: "sink"; sink: string | number; remove: true }
  | { command: "bind"; sensor: string; device: string }
  | { command: "hear"; sensor: string; source: string }
  | { command: "tap"; sensor: string }
  | { command: "cover"; sensor: string }
  | ({ command: "view"; sensor: string } & ViewChange)
  | { command: "save_rig" }
  | { command: "shape"; smoothing?: number; blinks_per_min?: number; merge?: { audio: boolean }; resting?: boolean; constraints?: boolean; lids_follow_eyes?: boolean; gains?: Record<string, number>; limits?: Record<string, [number, number]> }
  | { command: "listen"; only: string }
  | { command: "pair" }
  | { command: "microphone"; on: boolean }
  | { command: "video"; on: boolean }
  | { command: "pictures"; on: boolean }
  | { command: "takes" }
  | { command: "replay"; take: string; dataset?: string }
  | { command: "replay"; paused: boolean }
  | { command: "replay"; seek: number }
  | { command: "replay"; stop: true };

// ---- Reading ------------------------------------------------------------------------------------------------------

/** Our order is the session's own until its `hello` says otherwise. */
export const OWN_ORDER = Int16Array.from(SHAPES, (_, index) => index);

function orderOf(value: unknown): Int16Array {
  if (!Array.isArray(value)) return OWN_ORDER;
  return Int16Array.from(SHAPES, (name) => value.indexOf(name));
}

function perShape(value: unknown, order: Int16Array): Float32Array | null {
  if (!Array.isArray(value)) return null;
  const numbers = new Float32Array(SHAPE_COUNT);
  for (let i = 0; i < SHAPE_COUNT; ++i) numbers[i] = share(value[order[i] ?? -1]);
  return numbers;
}

function lettersOf(value: unknown, order: Int16Array): string {
  const sent = typeof value === "string" ? value : "";
  let letters = "";
  for (let i = 0; i < SHAPE_COUNT; ++i) letters += sent.charAt(order[i] ?? -1) || "n";
  return letters;
}

function unitQuaternion(value: unknown): readonly [number, number, number, number] {
  if (!Array.isArray(value)) return [1, 0, 0, 0];
  const [w, x, y, z] = [number(value[0]), number(value[1]), number(value[2]), number(value[3])];
  const size = Math.hypot(w, x, y, z);
  return size > 1e-6 ? [w / size, x / size, y / size, z / size] : [1, 0, 0, 0];
}

/** No eye turns further than this, rad. */
const WIDEST_LOOK = 1;

function eyesOf(value: unknown): readonly [number, number, number, number] {
  const angle = (i: number) =>
    Array.isArray(value) ? Math.min(WIDEST_LOOK, Math.max(-WIDEST_LOOK, number(value[i]))) : 0;
  return [angle(0), angle(1), angle(2), angle(3)];
}

function positionOf(value: unknown): readonly [number, number, number] | null {
  if (!Array.isArray(value) || value.length !== 3) return null;
  const [x, y, z] = value.map(numberOrNull);
  return x == null || y == null || z == null ? null : [x, y, z];
}

function directionOf(value: unknown): readonly [number, number, number] | null {
  const direction = positionOf(value);
  const length = direction ? Math.hypot(...direction) : 0;
  if (!direction || length < 0.5) return null;
  return [direction[0] / length, direction[1] / length, direction[2] / length];
}

function readHello(fields: Fields): Hello {
  const rig = fieldsOf(fields["rig"]);
  return {
    type: "hello",
    software: text(fields["software"]),
    order: orderOf(fields["shapes"]),
    rigName: text(rig["name"]),
    sensors: list(rig["sensors"], (one) => ({
      name: text(one["name"]),
      kind: text(one["kind"]),
      site: text(one["site"]),
      side: text(one["side"]),
      role: text(one["role"]),
      position: positionOf(one["position_m"]),
      aim: directionOf(one["aim"]),
    })).filter((one) => one.name !== ""),
    face: text(fields["face"], "/face.glb"),
    model: text(fields["model"]),
    mode: fields["mode"] === "replay" ? "replay" : "live",
    listening: texts(fields["listening"]),
  };
}

function readFrame(fields: Fields, order: Int16Array): Frame | null {
  const weights = perShape(fields["weights"], order);
  if (!weights) return null;
  return {
    type: "frame",
    index: number(fields["index"]),
    time: number(fields["time"]),
    weights,
    confidence: perShape(fields["confidence"], order) ?? new Float32Array(SHAPE_COUNT),
    provenance: lettersOf(fields["provenance"], order),
    tongueOut: share(fields["tongue_out"]),
    head: unitQuaternion(fields["head"]),
    headConfidence: share(fields["head_confidence"]),
    headProvenance: text(fields["head_provenance"], "n"),
    eyes: eyesOf(fields["eyes"]),
    eyesConfidence: share(fields["eyes_confidence"]),
    eyesProvenance: text(fields["eyes_provenance"], "n"),
    truth: perShape(fields["truth"], order),
  };
}

function readLink(one: Fields): Link {
  return {
    sensor: text(one["sensor"]),
    device: text(one["device"]),
    source: text(one["source"]),
    rivals: list(one["rivals"], (rival) => ({
      source: text(rival["source"]),
      ageMs: numberOrNull(rival["age_ms"]),
      implausible: rival["implausible"] === true,
    })).filter((rival) => rival.source !== ""),
    state: text(one["state"]),
    ageMs: numberOrNull(one["age_ms"]),
    rateHz: numberOrNull(one["rate_hz"]),
    lost: number(one["lost"]),
    late: number(one["late"]),
    doubled: number(one["doubled"]),
    reordered: number(one["reordered"]),
    malformed: number(one["malformed"]),
    loss: numberOrNull(one["loss"]),
    offsetMs: numberOrNull(one["offset_ms"]),
    driftPpm: numberOrNull(one["drift_ppm"]),
    uncertaintyMs: numberOrNull(one["uncertainty_ms"]),
    battery: numberOrNull(one["battery"]),
    headingSigmaDeg: numberOrNull(one["heading_sigma_deg"]),
    rotationSigmaDeg: numberOrNull(one["rotation_sigma_deg"]),
    leftOut: one["left_out"] === true,
    level: numberOrNull(one["level"]) === null ? null : share(one["level"]),
    estimated: one["estimated"] === true,
    view: readView(one["view"]),
  };
}

function readShaping(fields: Fields): Shaping {
  const gains = new Map<string, number>();
  const limits = new Map<string, readonly [number, number]>();
  const sentGains = fieldsOf(fields["gains"]);
  const sentLimits = fieldsOf(fields["limits"]);
  for (const name of [...SHAPES, "tongueOut"]) {
    const gain = numberOrNull(sentGains[name]);
    if (gain !== null) gains.set(name, gain);
    const limit = sentLimits[name];
    if (Array.isArray(limit)) limits.set(name, [number(limit[0], 0), number(limit[1], 1)]);
  }
  const rests = new Map<string, number>();
  const sentRests = fieldsOf(fieldsOf(fields["resting_face"])["rest"]);
  for (const name of SHAPES) {
    const rest = share(sentRests[name]);
    if (rest > 0) rests.set(name, rest);
  }
  return {
    smoothing: share(fields["smoothing"]),
    resting: fields["resting"] === true,
    blinks_per_min: Math.min(60, Math.max(0, number(fields["blinks_per_min"], 0))),
    constraints: fields["constraints"] === true,
    lids_follow_eyes: fields["lids_follow_eyes"] !== false,
    rests,
    gains,
    limits,
  };
}

function readReplay(value: unknown): ReplayStatus | null {
  if (typeof value !== "object" || value === null) return null;
  const fields = fieldsOf(value);
  return {
    take: text(fields["take"]),
    time: Math.max(0, number(fields["time"])),
    duration: Math.max(0, number(fields["duration"])),
    paused: fields["paused"] === true,
    hasTruth: fields["has_truth"] === true,
  };
}

function readStatus(fields: Fields): Status {
  const latency = fieldsOf(fields["latency_ms"]);
  const recording = fieldsOf(fields["recording"]);
  const log = fieldsOf(fields["log"]);
  const p50 = numberOrNull(latency["p50"]);
  return {
    type: "status",
    time: numberOrNull(fields["time"]),
    frames: number(fields["frames"]),
    missed: number(fields["missed"]),
    latency: p50 === null ? null : { p50, p99: number(latency["p99"], p50), max: number(latency["max"], p50) },
    holdMs: Math.max(0, number(fields["hold_ms"])),
    links: list(fields["links"], readLink).filter((one) => one.sensor !== ""),
    unbound: list(fields["unbound"], (one) => ({
      device: text(one["device"]),
      announces: text(one["announces"]),
      ageMs: numberOrNull(one["age_ms"]),
      protocol: text(one["protocol"]),
    })).filter((one) => one.device !== ""),
    calibration: readCalibration(fieldsOf(fields["calibration"])),
    prompts: readPrompts(fields["prompts"]),
    dataset: readDataset(fields["dataset"]),
    video: readVideo(fields["video"]),
    phoneLesson: readLesson(fields["phone_lesson"]),
    sinks: list(fields["sinks"], (one) => ({
      id: idOf(one["id"]),
      address: text(one["address"]),
      on: one["on"] === true,
      sent: number(one["sent"]),
      failed: number(one["failed"]),
      rateHz: numberOrNull(one["rate_hz"]),
      receivers: numberOrNull(one["receivers"]),
      note: text(one["note"]),
    })),
    network: readNetwork(fields["network"]),
    recording: {
      on: recording["on"] === true,
      path: text(recording["path"]),
      seconds: number(recording["seconds"]),
      endsS: numberOrNull(recording["ends_s"]),
      megabytes: number(recording["megabytes"]),
      error: text(recording["error"]),
    },
    log: {
      megabytes: number(log["megabytes"]),
      limitMegabytes: number(log["limit_megabytes"]),
      hoursLeft: numberOrNull(log["hours_left"]),
      error: text(log["error"]),
    },
    shaping: readShaping(fieldsOf(fields["shaping"])),
    hearing: readHearing(fields["hearing"]),
    pictures: readPictures(fields["pictures"]),
    replay: readReplay(fields["replay"]),
    tap: text(fieldsOf(fields["tap"])["sensor"]) || null,
    cover: { sensor: text(fieldsOf(fields["cover"])["sensor"]) || null, trouble: text(fieldsOf(fields["cover"])["trouble"]) },
  };
}

/** Reads one text of the session. `order` is that of the `hello`. Null: not for us. */
export function readMessage(message: string, order: Int16Array): Message | null {
  let parsed: unknown;
  try {
    parsed = JSON.parse(message);
  } catch {
    return null;
  }
  const fields = fieldsOf(parsed);
  switch (fields["type"]) {
    case "hello":
      return readHello(fields);
    case "frame":
      return readFrame(fields, order);
    case "status":
      return readStatus(fields);
    case "reply": {
      const result = fields["result"];
      return {
        type: "reply",
        id: number(fields["id"], -1),
        ok: fields["ok"] === true,
        error: text(fields["error"]),
        result: typeof result === "object" && result !== null ? fieldsOf(result) : null,
      };
    }
    case "event":
      return { type: "event", kind: text(fields["kind"]), text: text(fields["text"]) };
    case "takes":
      return { type: "takes", takes: readTakes(fields) };
    case "microphone":
      return { type: "microphone", why: text(fields["why"]) };
    case "video":
      return { type: "video", why: text(fields["why"]), again: fields["again"] === true };
    default:
      return null;
  }
}

/** The answer to the command `takes`. */
export function readTakes(result: Fields | null): Take[] {
  return list(fieldsOf(result)["takes"], (one) => ({
    name: text(one["name"]),
    seconds: numberOrNull(one["seconds"]),
    error: text(one["error"]),
    megabytes: numberOrNull(one["megabytes"]),
    recorded: text(one["recorded"]),
  })).filter((one) => one.name !== "");
}
