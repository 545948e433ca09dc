// A session for developing and testing the page without devices: serves the built page, a face and /ws, and behaves as
// docs/reference/page_protocol.md says, with made-up but believable data: a talking face, a lossy sensor, a frozen one, a lost one.
//
//   npm run mock [-- --port 8740] [-- --token SECRET] [-- --uncalibrated] [-- --eyewear] [-- --prompts] [-- --microphone]
//     [-- --headset] [-- --phone]
//
// --eyewear wears the glasses of rigs/eyewear.toml beside the ear's sensor; --prompts records, and asks for a few poses;
// --microphone hears that of a browser; --headset has the cameras of rigs/headset.toml; --phone, one
// that says how the face really is.
//
// The face is the built-in one where MIEN_PROGRAM names the program that makes it, else an egg.
import { createServer } from "node:http";
import { readFileSync } from "node:fs";
import { dirname, extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";
import { WebSocketServer } from "ws";
import { MockCameras } from "./mock_cameras.mjs";
import { MockDataset } from "./mock_dataset.mjs";
import { MockPrompts, POSES } from "./mock_prompts.mjs";
import { eyewearSensors, headsetSensors } from "./mock_rigs.mjs";
import { STEPS } from "./mock_steps.mjs";
import { MockVideo } from "./mock_video.mjs";
import { MockVoice } from "./mock_voice.mjs";
import { sessionFace } from "./session_face.mjs";
import { SHAPES } from "./sphere_head.mjs";

const here = dirname(fileURLToPath(import.meta.url));

const RIG = [
  ["frontalis_R", -0.0346, 0.0715, 0.0934], ["frontalis_L", 0.0346, 0.0715, 0.0934], ["orbicularis_R", -0.0509, 0.0235, 0.0869],
  ["orbicularis_L", 0.0509, 0.0235, 0.0869], ["zygomaticus_upper_R", -0.043, 0.007, 0.0965],
  ["zygomaticus_upper_L", 0.043, 0.007, 0.0965], ["zygomaticus_lower_R", -0.0343, -0.019, 0.0963],
  ["zygomaticus_lower_L", 0.0343, -0.019, 0.0963], ["buccinator_R", -0.0393, -0.0363, 0.0902],
  ["buccinator_L", 0.0393, -0.0363, 0.0902], ["mentalis", 0, -0.0684, 0.1087], ["mastoid_L", 0.06, -0.0076, -0.0164],
];

const IMUS = RIG.map(([name, ...position]) => ({
  name, kind: "imu", site: name.replace(/_[LR]$/, ""), side: /_([LR])$/.exec(name)?.[1] ?? "M",
  role: name === "mastoid_L" ? "head" : "face", position_m: position,
}));

const MICROPHONE = { name: "microphone", kind: "speech", site: "", side: "M", role: "face", position_m: null };

const PHONE = { name: "phone", kind: "weights", site: "", side: "M", role: "truth", position_m: null };

const TAKES = [
  { name: "reading_aloud.mien", seconds: 28.9, megabytes: 1.8, recorded: "2026-11-21T18:53:41Z", truth: true },
  { name: "range_of_motion.mien", seconds: 64.2, megabytes: 4.1, recorded: "2026-11-20T10:12:05Z", truth: true },
  { name: "tuesday_lunch.mien", seconds: 312.5, megabytes: 21.4, recorded: "2026-11-17T12:31:00Z", truth: false },
];

/** A person who talks, blinks, smiles at times and looks about; the same at every time. Weights by name. */
export function performanceAt(t) {
  const wave = (period, phase = 0) => 0.5 + 0.5 * Math.sin((2 * Math.PI * t) / period + phase);
  const bump = (period, width, phase = 0) => {
    const x = ((((t + phase) % period) + period) % period) / width;
    return x < 1 ? Math.sin(Math.PI * x) ** 2 : 0;
  };
  const speaking = Math.min(1, 1.6 * wave(7.3) ** 0.7);
  const syllable = speaking * (0.5 + 0.5 * Math.sin(2 * Math.PI * (3.9 * t + 0.6 * Math.sin(t * 1.7)))) * (0.45 + 0.55 * wave(1.13));
  const round = speaking * bump(2.3, 0.45) + 0.7 * speaking * bump(3.7, 0.4, 1.1);
  const smile = 0.12 + 0.6 * bump(9.1, 3.2, 2) + 0.15 * wave(11);
  const brows = 0.65 * bump(6.3, 1.3) + 0.08 * wave(5);
  const blink = Math.min(1, 1.25 * (bump(3.4, 0.24) + bump(8.9, 0.22, 3.1)));
  const frown = 0.35 * bump(13.7, 2.4, 5);
  const yaw = 0.28 * Math.sin(t * 0.9) * bump(5.2, 2.6) + 0.03 * Math.sin(t * 2.2);
  const pitch = -0.12 * bump(7.7, 2.1, 1);
  const look = { yaw, pitch };
  const w = {
    jawOpen: 0.04 + 0.55 * syllable, mouthClose: 0.05 + 0.1 * syllable * wave(0.7),
    mouthFunnel: 0.45 * round, mouthPucker: 0.55 * round, mouthSmile_L: smile * (1 - 0.6 * round), mouthSmile_R: 0.88 * smile * (1 - 0.6 * round),
    cheekSquint_L: 0.55 * smile, cheekSquint_R: 0.5 * smile, mouthDimple_L: 0.15 * smile, mouthDimple_R: 0.15 * smile,
    mouthLowerDown_L: 0.35 * syllable, mouthLowerDown_R: 0.33 * syllable, mouthUpperUp_L: 0.22 * syllable, mouthUpperUp_R: 0.2 * syllable,
    mouthStretch_L: 0.18 * syllable * wave(1.9), mouthStretch_R: 0.18 * syllable * wave(1.9), mouthPress_L: 0.2 * bump(2.9, 0.3), mouthPress_R: 0.2 * bump(2.9, 0.3),
    mouthRollLower: 0.18 * bump(2.9, 0.3), mouthShrugLower: 0.12 * wave(3.1) * speaking, jawForward: 0.04 * wave(4),
    browInnerUp_L: brows, browInnerUp_R: 0.95 * brows, browOuterUp_L: 0.7 * brows, browOuterUp_R: 0.6 * brows, browDown_L: frown, browDown_R: frown,
    eyeBlink_L: blink, eyeBlink_R: blink, eyeSquint_L: 0.3 * smile + 0.1 * frown, eyeSquint_R: 0.3 * smile + 0.1 * frown, eyeWide_L: 0.25 * brows, eyeWide_R: 0.25 * brows,
    eyeLookUp_L: Math.max(0, pitch) / 0.611, eyeLookUp_R: Math.max(0, pitch) / 0.611, eyeLookDown_L: Math.max(0, -pitch) / 0.611, eyeLookDown_R: Math.max(0, -pitch) / 0.611,
    eyeLookOut_L: Math.max(0, yaw) / 0.611, eyeLookIn_R: Math.max(0, yaw) / 0.611, eyeLookIn_L: Math.max(0, -yaw) / 0.611, eyeLookOut_R: Math.max(0, -yaw) / 0.611,
    noseSneer_L: 0.12 * smile, noseSneer_R: 0.1 * smile, mouthLeft: 0.1 * bump(5.9, 0.8), mouthRight: 0.08 * bump(6.7, 0.7),
  };
  const head = { yaw: 0.13 * Math.sin(t * 0.43) + 0.05 * Math.sin(t * 1.1), pitch: 0.05 * Math.sin(t * 0.71) + 0.035 * syllable * Math.sin(t * 3), roll: 0.04 * Math.sin(t * 0.37 + 1) };
  return { weights: SHAPES.map((name) => Math.min(1, Math.max(0, w[name] ?? 0))), look, head };
}

/** [w, x, y, z] of a yaw about +Y, then a pitch (positive: looking down) about +X, then a roll about +Z. */
function quaternion({ yaw, pitch, roll }) {
  const [cy, sy, cp, sp, cr, sr] = [Math.cos(yaw / 2), Math.sin(yaw / 2), Math.cos(pitch / 2), Math.sin(pitch / 2), Math.cos(roll / 2), Math.sin(roll / 2)];
  return [cy * cp * cr + sy * sp * sr, cy * sp * cr + sy * cp * sr, sy * cp * cr - cy * sp * sr, cy * cp * sr - sy * sp * cr];
}

/** Which shapes a sensor's loss is felt in. */
function feels(sensor, shape) {
  if (sensor === "mentalis") return /^mouth(ShrugLower|RollLower|LowerDown)/.test(shape);
  if (sensor.startsWith("buccinator_R")) return /^mouth(Dimple|Frown|Stretch|Press)_R/.test(shape);
  return false;
}

function seeded(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let x = Math.imul(state ^ (state >>> 15), state | 1);
    x ^= x + Math.imul(x ^ (x >>> 7), x | 61);
    return ((x ^ (x >>> 14)) >>> 0) / 4294967296;
  };
}

class MockSession {
  commands = [];
  frames = 0;
  /** While set, frames have this letter for all shapes: "h" or "n". */
  allProvenance = null;
  silent = false;
  /** By how much frames are held for late packets, ms. */
  holdMs = 0;
  /** How well rotations are known, degrees; above 5 re-centring is advised, which brings it to 2. */
  sigmaDeg = 2.1;
  /** While set, a calibration that has reached this step stays there, half way through. */
  holdAt = "";

  /** `microphone`: it hears one, that of a browser. */
  constructor({ quick = false, uncalibrated = false, eyewear = false, prompts = false, microphone = false, headset = false, phone = false, every = 1 } = {}) {
    /** Of so many frames and pictures one is sent: a browser on a busy machine falls behind sixty a second, ever further. */
    this.every = every;
    this.sensors = headset ? headsetSensors() : eyewear ? [...eyewearSensors(), ...IMUS.slice(-1)] : microphone ? [...IMUS, MICROPHONE] : IMUS;
    if (phone) this.sensors = [...this.sensors, PHONE];
    this.quick = quick;
    this.random = seeded(7);
    this.started = Date.now();
    this.clients = new Set();
    this.states = headset ? { mouth_R: "frozen" } : eyewear ? { cheek_L: "lossy", jaw_lower_R: "lost" } : { zygomaticus_lower_L: "lossy", buccinator_R: "frozen", mentalis: "lost", frontalis_R: "duplicate" };
    this.prompts = prompts ? new MockPrompts(POSES) : null;
    this.dataset = new MockDataset(this);
    this.video = new MockVideo(this);
    this.devices = Object.fromEntries(this.sensors.map(({ name }, i) => [name, `02:4D:49:45:4E:${(i + 1).toString(16).padStart(2, "0").toUpperCase()}`]));
    // Two send as one of them.
    this.heard = { frontalis_R: "udp://192.168.1.40:5005" };
    this.rivals = eyewear || headset ? {} : { frontalis_R: [{ source: "udp://192.168.1.66:5005", implausible: true }] };
    this.unbound = headset ? [{ device: "02:4D:49:48:53:7F/0", announces: "", protocol: "picture" }] : [
      { device: "02:4D:49:45:4E:1F/0", announces: "mentalis", protocol: "mien" },
      { device: "5C:CF:7F:0A:11:3E/0", announces: "", protocol: "slimevr" },
    ];
    this.calibration = { state: uncalibrated ? "watching" : "done", step: "", prompt: uncalibrated ? "Hold still, nod, and shake your head: I am watching for them." : "", run: null };
    this.versions = uncalibrated ? [] : [this.version(1, "self", -95, 0.7), this.version(2, "guided", -40, 0.2)];
    this.sinks = [
      { id: 1, address: "livelink://127.0.0.1:11111", on: true, sent: 0, failed: 0, receivers: null, note: "Unreal's Live Link Face" },
      { id: 2, address: "vmc://127.0.0.1:39539", on: false, sent: 0, failed: 0, receivers: null, note: "" },
      { id: 3, address: "ws://127.0.0.1:8741", on: true, sent: 0, failed: 0, receivers: 1, note: "" },
    ];
    this.recording = { on: false, path: "", since: 0, error: null };
    if (prompts) Object.assign(this.recording, { on: true, path: "me.mien" });
    this.takes = TAKES.map((take) => ({ ...take }));
    this.shaping = { smoothing: 0.25, blinks_per_min: 12, resting: false, lids_follow_eyes: true, resting_face: { rest: {}, full: {} }, gains: { jawOpen: 1.2 }, limits: {} };
    this.cameras = new MockCameras(headset ? this.sensors.length : 0, every, (sensor) => this.states[this.sensors[sensor].name] !== "lost");
    /** Of a headset: the lower face is heard, since no camera sees it. */
    this.mouthIsHeard = false;
    this.voice = new MockVoice(microphone);
    this.replay = null;
    this.tap = null;
    this.cover = { sensor: null, trouble: null };
    /** Of a headset: which part of its pictures is seen of each camera. */
    this.views = Object.fromEntries(this.sensors.filter(({ kind }) => kind === "camera").map(({ name, side }) => [name, { crop: [0.1, 0.18, 0.82, 0.82], turn_deg: 0, mirror: side === "R" }]));
    this.saved = 0;
    this.network = {
      open: ["udp://0.0.0.0:6969"], only: "", elsewhere: 0, sealed: false, refused: 0,
      interfaces: [
        { name: "wlan0", address: "192.168.1.7", loopback: false }, { name: "eth0", address: "10.0.0.12", loopback: false },
        { name: "lo", address: "127.0.0.1", loopback: true },
      ],
    };
    this.timer = setInterval(() => this.tick(), 1000 / 60);
    this.statusTimer = setInterval(() => this.say(this.status()), 250);
  }

  close() {
    clearInterval(this.timer);
    clearInterval(this.statusTimer);
    this.cameras.close();
    for (const client of this.clients) client.terminate();
  }

  now() {
    return (Date.now() - this.started) / 1000;
  }

  version(id, origin, time, roughness) {
    const residual = 1.1 + 3 * roughness;
    return {
      id, origin, time: Math.round(10 * (this.now() + time)) / 10, in_force: id === 2,
      scores: [
        { name: "stillness", value: 0.4 + roughness, unit: "deg/s", pass: true, sentence: "The face was still while neutral was held." },
        { name: "nod", value: 21 - 6 * roughness, unit: "deg", pass: true, sentence: "The nod was wide enough to find the vertical." },
        { name: "shake", value: 26 - 12 * roughness, unit: "deg", pass: roughness < 0.6, sentence: roughness < 0.6 ? "The shake agrees with the nod within 2 degrees." : "The shake was small: shake wider, to about 25 degrees." },
        { name: "heading", value: residual, unit: "deg", pass: residual < 3, sentence: residual < 3 ? "All sensors agree on the heading." : "Headings differ between sensors: calibrate again, more slowly." },
      ],
    };
  }

  say(message) {
    const text = JSON.stringify(message);
    if (this.silent) return;
    for (const client of this.clients) if (client.readyState === 1 && client.bufferedAmount < 100_000) client.send(text);
  }

  hello() {
    return {
      type: "hello", software: "mien 0.1.0 (mock)", shapes: SHAPES,
      rig: {
        name: "default",
        sensors: this.sensors,
      },
      face: "/face.glb", model: "default live", mode: this.replay ? "replay" : "live", listening: ["udp://127.0.0.1:5005", "udp://0.0.0.0:6969"],
    };
  }

  tick() {
    if (this.replay && !this.replay.paused) {
      this.replay.time += 1 / 60;
      if (this.replay.time >= this.replay.duration) this.replay = { ...this.replay, time: this.replay.duration, paused: true };
    }
    this.advanceCalibration();
    this.prompts?.advance((this.quick ? 6 : 1) / 60);
    this.dataset.follow();
    ++this.frames;
    for (const sink of this.sinks) if (sink.on) ++sink.sent;
    if (this.frames % this.every === 0) this.say(this.frame());
  }

  frame() {
    const t = this.replay ? this.replay.time : this.now();
    const { weights: truth, look, head } = performanceAt(t);
    const calibrated = this.versions.length > 0 || this.replay;
    const still = this.calibration.state === "running" && this.calibration.step !== "anchor";
    const provenance = SHAPES.map((name) => {
      if (this.allProvenance) return this.allProvenance;
      if (!calibrated) return "n";
      if (this.cameras.status) return /^eyeLook/.test(name) ? "p" : this.mouthIsHeard && !/^(brow|eye)/.test(name) ? "a" : "m";
      if (RIG.some(([sensor]) => ["lost", "frozen"].includes(this.states[sensor]) && feels(sensor, name))) return "h";
      if (/^eyeLook/.test(name)) return "p";
      if (/^(mouthFunnel|mouthPucker|mouthShrugUpper)/.test(name)) return "a";
      if (/^mouth.*_L/.test(name) && t % 3 < 0.4) return "i";
      return "m";
    });
    const lagged = performanceAt(t - 0.06).weights;
    const weights = lagged.map((value, k) => {
      if (provenance[k] === "n") return 0;
      if (still) return 0.02 * value;
      if (provenance[k] === "h") return 0.08;
      return Math.min(1, Math.max(0, 0.92 * value + 0.02 * Math.sin(40 * t + k)));
    });
    const confidence = provenance.map((letter, k) => ({ m: 0.94, i: 0.8, p: 0.55, a: 0.6, h: 0.2, n: 0 })[letter] - 0.05 * Math.abs(Math.sin(t + k)) * (letter === "n" ? 0 : 1));
    // What a camera sees that is lost or frozen is little known.
    if (this.cameras.status)
      SHAPES.forEach((name, k) => {
        const half = /^(brow|eye)/.test(name) ? "eye" : "mouth";
        if (["L", "R"].some((side) => name.endsWith(`_${side}`) && ["lost", "frozen"].includes(this.states[`${half}_${side}`]))) confidence[k] = 0.2;
      });
    const nod = this.calibration.run && this.calibration.step === "nod" ? 0.3 * Math.sin(this.calibration.stepSeconds * 2.6) : 0;
    const shake = this.calibration.run && this.calibration.step === "shake" ? 0.4 * Math.sin(this.calibration.stepSeconds * 2.6) : 0;
    const round = (value) => Math.round(value * 1e4) / 1e4;
    const nothing = this.allProvenance === "n" || !calibrated;
    return {
      type: "frame", index: this.frames, time: round(t), weights: weights.map(round), confidence: confidence.map(round), provenance: provenance.join(""),
      tongue_out: 0, head: quaternion(nothing ? { yaw: 0, pitch: 0, roll: 0 } : still ? { yaw: shake, pitch: nod, roll: 0 } : head).map(round),
      head_confidence: nothing ? 0 : 0.97, head_provenance: nothing ? "n" : "m",
      eyes: nothing || still ? [0, 0, 0, 0] : [look.yaw, look.pitch, look.yaw, look.pitch].map(round), eyes_confidence: 0.4, eyes_provenance: nothing ? "n" : "p",
      ...(this.replay?.has_truth ? { truth: truth.map(round) } : {}),
    };
  }

  status() {
    const t = this.now();
    const links = this.sensors.map(({ name: sensor, kind }, i) => {
      const state = !this.devices[sensor] ? "unbound" : (this.states[sensor] ?? "good");
      const rate = { good: 240, lossy: 208, frozen: 240, lost: 0, unbound: 0 }[state] ?? 200;
      const heard = state !== "unbound";
      return {
        sensor, device: this.devices[sensor] ?? "", source: heard ? (this.heard[sensor] ?? `udp://192.168.1.${20 + i}:5005`) : "",
        rivals: (this.rivals[sensor] ?? []).map((one) => ({ ...one, age_ms: 2 + 3 * this.random() })), state, age_ms: state === "lost" ? 1000 * t + 4200 : state === "unbound" ? null : 1 + 3 * this.random(),
        rate_hz: heard ? rate + (rate ? 0.6 * (this.random() - 0.5) : 0) : null, lost: state === "lossy" ? Math.floor(31 * t) : i, late: Math.floor(this.random() * 2), doubled: 0,
        reordered: 0, malformed: 0, loss: !heard ? null : state === "lost" ? 1 : state === "lossy" ? 0.12 + 0.02 * this.random() : 0.003 * this.random(),
        offset_ms: heard ? 3187.4 * (i + 1) + 0.2 * this.random() : null, drift_ppm: heard ? 18 * Math.sin(3 * i) : null, uncertainty_ms: heard ? 0.3 + 0.2 * this.random() : null,
        battery: heard && kind === "imu" ? 92 - ((7 * i) % 60) : null, heading_sigma_deg: heard && kind === "imu" ? 1.4 + 0.3 * (i % 4) : null,
        rotation_sigma_deg: heard && kind === "imu" ? 1.6 + 0.3 * (i % 4) : null, left_out: false,
        view: this.views[sensor] ?? null,
        level: kind === "speech" ? this.voice.level : kind === "eyewear" && heard ? 0.15 + 0.5 * (0.5 + 0.5 * Math.sin(1.3 * t + i)) : null, estimated: false,
      };
    });
    const run = this.calibration.run;
    const step = run ? run.steps[run.at] : null;
    return {
      type: "status", time: Math.round(1000 * t) / 1000, frames: this.frames, missed: 0,
      latency_ms: { p50: 7.4 + 0.5 * this.random(), p99: 11.8 + 2.5 * this.random(), max: 17.2 + this.random() }, hold_ms: this.holdMs,
      links, unbound: this.unbound.map((one) => ({ ...one, age_ms: 3 + 5 * this.random() })),
      calibration: {
        state: this.calibration.state, step: this.calibration.step, prompt: this.calibration.prompt, target: step?.target ?? null, look: step?.look ?? null,
        progress: run ? Math.min(1, this.calibration.stepSeconds / step.seconds) : 0, remaining_s: run ? Math.max(0, step.seconds - this.calibration.stepSeconds) : 0,
        step_number: run ? run.at + 1 : 0, steps: run ? run.steps.length : 0, versions: this.versions,
        ...this.certainty(t),
      },
      prompts: this.prompts?.status() ?? null, dataset: this.dataset.state, video: this.video.status(),
      sinks: this.sinks.map((sink) => ({ ...sink, rate_hz: sink.on ? 60 : 0 })),
      recording: { on: this.recording.on, path: this.recording.path, seconds: this.recording.on ? t - this.recording.since : 0, megabytes: this.recording.on ? 0.07 * (t - this.recording.since) : 0, error: this.recording.error },
      log: { megabytes: 0.33 * t, limit_megabytes: 4000, payload_megabytes: 0, payload_limit_megabytes: 2000, hours_left: (4000 - 0.33 * t) / 0.33 / 3600, error: null },
      shaping: this.shaping, hearing: this.voice.hearing, replay: this.replay, pictures: this.cameras.status, tap: this.tap ? { sensor: this.tap } : null,
      cover: this.cover.sensor || this.cover.trouble ? this.cover : null,
      network: this.network,
    };
  }

  certainty(t) {
    const inForce = this.versions.findIndex((one) => one.in_force);
    const until = this.versions.slice(0, inForce + 1).reverse();
    const made = until.find((one) => one.origin !== "recentre"), recentred = until[0]?.origin === "recentre" ? until[0] : undefined;
    return {
      age_s: made ? t - made.time : null, recentred_s: recentred ? t - recentred.time : null, sigma_deg: this.sigmaDeg,
      advises_recentring: this.sigmaDeg > 5, drift_faults: 0,
    };
  }

  advanceCalibration() {
    const run = this.calibration.run;
    if (!run) return;
    if (this.holdAt !== "" && this.calibration.step === this.holdAt && this.calibration.stepSeconds > run.steps[run.at].seconds / 2) return;
    this.calibration.stepSeconds += (this.quick ? 6 : 1) / 60;
    if (this.calibration.stepSeconds < run.steps[run.at].seconds) return;
    if (++run.at < run.steps.length) {
      this.enterStep();
      return;
    }
    for (const version of this.versions) version.in_force = false;
    const id = this.versions.length + 1;
    this.versions.push({ ...this.version(id, "guided", 0, 0.1), in_force: true });
    this.calibration = { state: "done", step: "", prompt: "", run: null };
    this.event("calibrated", "Calibrated.");
  }

  enterStep() {
    const { steps, at } = this.calibration.run;
    Object.assign(this.calibration, { state: "running", step: steps[at].step, prompt: steps[at].prompt, stepSeconds: 0 });
  }

  event(kind, text) {
    this.say({ type: "event", kind, text });
  }

  /** Obeys one command; gives the reply's `result`, or throws with the reply's `error`. */
  obey(command, client) {
    switch (command.command) {
      case "calibrate":
        if (this.replay) throw new Error("A replay cannot be calibrated.");
        this.calibration.run = { steps: [...STEPS.short, ...({ full: STEPS.full, gaze: STEPS.gaze }[command.kind] ?? [])], at: 0 };
        this.enterStep();
        return null;
      case "cancel_calibration":
        this.calibration = { state: this.versions.length ? "done" : "watching", step: "", prompt: "", run: null };
        return null;
      case "use_calibration":
        if (!this.versions.some((one) => one.id === command.version)) throw new Error("There is no such version.");
        for (const version of this.versions) version.in_force = version.id === command.version;
        return null;
      case "recentre":
        this.sigmaDeg = 2;
        for (const version of this.versions) version.in_force = false;
        this.versions.push({ ...this.version(this.versions.length + 1, "recentre", 0, 0.15), in_force: true });
        return null;
      case "prompts":
        if (!this.prompts) throw new Error("No pose is being asked for.");
        this.prompts.obey(command.do);
        return null;
      case "dataset":
        return this.dataset.obey(command);
      case "record":
        if (command.on) {
          this.recording = { on: true, path: `takes/${command.name || "take_2026-11-21_2044"}.mien`, since: this.now(), error: null };
        } else if (this.recording.on) {
          const seconds = this.now() - this.recording.since;
          this.takes.unshift({ name: this.recording.path.split("/").pop(), seconds, megabytes: 0.07 * seconds, recorded: "2026-11-21T20:44:46Z", truth: false });
          this.event("recorded", `Take written: ${this.recording.path}`);
          this.recording = { on: false, path: this.recording.path, since: 0, error: null };
        }
        return null;
      case "sink": {
        if (command.add !== undefined) {
          if (!/^(livelink|vmc|vrchat|ifacialmocap|ws):\/\/[^/]+:\d+$|^csv:.+/.test(command.add)) throw new Error(`${command.add} is no address of a sink.`);
          this.sinks.push({ id: 1 + Math.max(0, ...this.sinks.map((one) => one.id)), address: command.add, on: true, sent: 0, failed: 0, receivers: null, note: "" });
          return null;
        }
        const sink = this.sinks.find((one) => one.id === command.sink);
        if (!sink) throw new Error("There is no such sink.");
        if (command.remove) this.sinks = this.sinks.filter((one) => one !== sink);
        else sink.on = command.on === true;
        return null;
      }
      case "bind":
        this.bind(command.sensor, command.device);
        return null;
      case "hear": {
        const rival = this.rivals[command.sensor]?.find((one) => one.source === command.source);
        if (!rival) throw new Error(`nobody sends as ${command.sensor} from ${command.source}`);
        rival.source = this.heard[command.sensor];
        this.heard[command.sensor] = command.source;
        return null;
      }
      case "tap":
        this.tap = command.sensor || null;
        if (this.tap && this.unbound.length > 0) {
          const sensor = this.tap;
          setTimeout(() => this.tap === sensor && this.bind(sensor, this.unbound[0]?.device ?? this.devices[sensor]), this.quick ? 700 : 4000).unref();
        }
        return null;
      case "cover":
        this.cover = { sensor: command.sensor || null, trouble: null };
        if (this.cover.sensor && this.unbound.length > 0) {
          const { sensor } = this.cover;
          setTimeout(() => this.cover.sensor === sensor && this.bind(sensor, this.unbound[0]?.device ?? this.devices[sensor]), this.quick ? 700 : 4000).unref();
        }
        return null;
      case "view": {
        const view = this.views[command.sensor];
        if (!view) throw new Error(`the rig has no sensor "${command.sensor}"`);
        const { crop = view.crop, turn_deg = view.turn_deg, mirror = view.mirror } = command;
        const [left, top, width, height] = crop;
        if (left < 0 || top < 0 || width < 0.05 || height < 0.05 || left + width > 1 || top + height > 1) throw new Error("'crop' leaves the picture, or too little of it");
        this.views[command.sensor] = { crop, turn_deg, mirror };
        return null;
      }
      case "save_rig":
        ++this.saved;
        return { rig: "rigs/headset.toml" };
      case "shape":
        for (const key of ["smoothing", "blinks_per_min", "constraints", "lids_follow_eyes"]) if (command[key] !== undefined) this.shaping[key] = command[key];
        if (command.merge?.audio !== undefined) this.voice.switch(command.merge.audio);
        if (command.resting !== undefined) {
          this.shaping.resting = command.resting;
          this.shaping.resting_face.rest = command.resting ? { eyeBlink_L: 0.3, eyeBlink_R: 0.28, browInnerUp_L: 0.22, browInnerUp_R: 0.25, mouthSmile_L: 0.12 } : {};
        }
        Object.assign(this.shaping.gains, command.gains);
        Object.assign(this.shaping.limits, command.limits);
        return null;
      case "pictures":
        this.cameras.show(client, command.on);
        return null;
      case "microphone":
        this.voice.ask(client, command.on === true);
        return null;
      case "video":
        this.video.ask(client, command.on === true);
        return null;
      case "listen":
        if (command.only !== "" && !this.network.interfaces.some((one) => [one.name, one.address].includes(command.only))) {
          throw new Error(`${command.only}: no interface and no address of this machine`);
        }
        this.network.only = command.only;
        return null;
      case "pair":
        return {
          file: "/home/you/.config/mien/pairing.key", in_force: false, command: "mien live --key /home/you/.config/mien/pairing.key",
          firmware: `static const uint8_t kMienKey[33] = {1, ${Array.from({ length: 32 }, (_, i) => `0x${(7 * i + 3).toString(16).padStart(2, "0")}`).join(", ")}};`,
        };
      case "takes":
        return { takes: [...this.growing(), ...this.takes].map(({ truth: _, ...take }) => take) };
      case "replay":
        if (command.take !== undefined) {
          const takes = command.dataset ? this.dataset.takes.filter((one) => one.dataset === command.dataset) : this.takes;
          const take = takes.find((one) => one.name === command.take);
          if (!take) throw new Error(`There is no take ${command.take}.`);
          this.replay = { take: take.name, time: 0, duration: take.seconds, paused: false, has_truth: take.truth };
        } else if (!this.replay) {
          throw new Error("Nothing is being replayed.");
        } else if (command.stop) {
          this.replay = null;
        } else if (command.paused !== undefined) {
          if (!command.paused && this.replay.time >= this.replay.duration) this.replay.time = 0;
          this.replay.paused = command.paused;
        } else {
          this.replay.time = Math.min(this.replay.duration, Math.max(0, command.seek));
        }
        return null;
      default:
        throw new Error(`There is no command ${command.command}.`);
    }
  }

  /** The take that is being recorded, as it is now: the session lists it too. */
  growing() {
    if (!this.recording.on) return [];
    const seconds = this.now() - this.recording.since;
    return [{ name: this.recording.path.split("/").pop(), seconds, error: null, megabytes: 0.07 * seconds, recorded: "2026-11-21T20:44:46Z" }];
  }

  bind(sensor, device) {
    if (!(sensor in this.devices)) throw new Error(`There is no sensor ${sensor}.`);
    this.devices[sensor] = device;
    this.unbound = this.unbound.filter((one) => one.device !== device);
    delete this.states[sensor];
    if (this.tap === sensor) this.tap = null;
    if (this.cover.sensor === sensor) this.cover = { sensor: null, trouble: null };
    this.event("bound", `${device} sits on ${sensor}.`);
  }

  join(client) {
    this.clients.add(client);
    client.on("close", () => {
      this.clients.delete(client);
      this.voice.leave(client);
      this.video.leave(client);
      this.cameras.leave(client);
    });
    client.on("message", (data, isBinary) => {
      if (isBinary) return data.toString("latin1", 0, 4) === "MVID" ? this.video.take(client, data) : this.voice.take(client, data);
      let id = -1;
      try {
        const command = JSON.parse(String(data));
        id = command.id;
        this.commands.push(command);
        const result = this.obey(command, client);
        client.send(JSON.stringify({ type: "reply", id, ok: true, error: "", result }));
        this.say(this.status());
      } catch (error) {
        client.send(JSON.stringify({ type: "reply", id, ok: false, error: error.message, result: null }));
      }
    });
    client.send(JSON.stringify(this.hello()));
    client.send(JSON.stringify(this.status()));
  }
}

const TYPES = { ".html": "text/html; charset=utf-8", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml" };

/**
 * Starts a mock session. `port` 0: any. `token`: what /ws, /face.glb and `pictures` (by their paths) then demand.
 * Gives {url, session, close()}.
 */
export async function startMockSession({
  port = 0, token = "", face = sessionFace(), pictures = {}, dist = join(here, "../dist"), ...options
} = {}) {
  const session = new MockSession(options);
  const allowed = (url) => token === "" || url.searchParams.get("token") === token;
  const server = createServer((request, response) => {
    const url = new URL(request.url, "http://localhost");
    if (url.pathname === "/face.glb") {
      if (!allowed(url)) return response.writeHead(403).end();
      return response.writeHead(200, { "Content-Type": "model/gltf-binary", "Content-Length": face.length }).end(request.method === "HEAD" ? undefined : face);
    }
    if (pictures[url.pathname]) {
      if (!allowed(url)) return response.writeHead(403).end();
      return response.writeHead(200, { "Content-Type": "image/jpeg" }).end(pictures[url.pathname]);
    }
    const file = normalize(join(dist, url.pathname === "/" ? "index.html" : url.pathname));
    try {
      if (!file.startsWith(normalize(dist))) throw new Error("outside");
      const bytes = readFileSync(file);
      // As strict as the program itself: nothing from elsewhere, no script in the page.
      response.writeHead(200, {
        "Content-Type": TYPES[extname(file)] ?? "application/octet-stream",
        "Content-Security-Policy": "default-src 'self'; img-src 'self' blob: data:; connect-src 'self' blob: data: ws: wss:",
      }).end(bytes);
    } catch {
      response.writeHead(404).end("There is no such thing here. Was the page built (npm run build)?");
    }
  });
  const sockets = new WebSocketServer({ noServer: true, maxPayload: 1 << 24 });
  server.on("upgrade", (request, socket, head) => {
    const url = new URL(request.url, "http://localhost");
    if (url.pathname !== "/ws" || !allowed(url)) return socket.end("HTTP/1.1 403 Forbidden\r\n\r\n");
    sockets.handleUpgrade(request, socket, head, (client) => session.join(client));
  });
  await new Promise((resolve, reject) => server.once("error", reject).listen(port, "127.0.0.1", resolve));
  return {
    url: `http://127.0.0.1:${server.address().port}/${token ? `?token=${token}` : ""}`,
    port: server.address().port,
    session,
    close() {
      session.close();
      server.closeAllConnections?.();
      return new Promise((resolve) => server.close(resolve));
    },
  };
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const option = (name, otherwise) => {
    const at = process.argv.indexOf(`--${name}`);
    return at < 0 ? otherwise : process.argv[at + 1];
  };
  const { url } = await startMockSession({
    port: Number(option("port", 8740)), token: option("token", ""), uncalibrated: process.argv.includes("--uncalibrated"),
    eyewear: process.argv.includes("--eyewear"), prompts: process.argv.includes("--prompts"), microphone: process.argv.includes("--microphone"),
    headset: process.argv.includes("--headset"), phone: process.argv.includes("--phone"),
  });
  console.log(`A mock session: ${url}\nIts page with changes shown at once: npm run dev`);
}
