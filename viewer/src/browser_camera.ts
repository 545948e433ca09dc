/** This browser's camera, recorded on its way to the session, which writes it beside the take. */
import type { Session } from "./session";
import { Signal } from "./signal";
import { type Container, videoMessage } from "./video_protocol";

export type CameraState =
  | { kind: "off" }
  /** The session is asked, then the browser asks its user. */
  | { kind: "asking" }
  | { kind: "on" }
  /** What stands against it, and what to do. */
  | { kind: "refused"; why: string };

const SIZE = { width: { ideal: 640 }, height: { ideal: 480 }, frameRate: { ideal: 30 } };
const BITS_PER_SECOND = 2_500_000;
/** What a browser that is closed may lose, ms. */
const CHUNK_MS = 1000;
/** How long a recorder may take to hand over its last chunk, ms. */
const LAST_CHUNK_MS = 1500;
/** WebM first, which every reader knows; VP8 costs least. */
const TYPES: readonly (readonly [Container, string])[] = [
  ["webm", "video/webm;codecs=vp8"], ["webm", "video/webm;codecs=vp9"], ["webm", "video/webm"], ["mp4", "video/mp4;codecs=avc1.42E01E"], ["mp4", "video/mp4"],
];

const ON = "The recording goes on without video.";

/** Whether a browser can record a camera at all: an insecure page has none. */
export function canFilm(): boolean {
  return typeof MediaRecorder !== "undefined" && typeof (navigator.mediaDevices as MediaDevices | undefined)?.getUserMedia === "function" && typeOf() !== null;
}

/** The first that this browser records. */
function typeOf(): readonly [Container, string] | null {
  return TYPES.find(([, type]) => MediaRecorder.isTypeSupported(type)) ?? null;
}

/** Why a browser gives no camera, and what to do: of the error that it threw. */
export function cameraRefusal(error: { name: string; message: string }): string {
  switch (error.name) {
    case "NotAllowedError":
      return `The browser refused its camera. Allow it for this page, by the sign beside the address, and press again. ${ON}`;
    case "NotFoundError":
      return `The browser finds no camera. Plug one in and press again. ${ON}`;
    case "NotReadableError":
      return `The camera cannot be opened: another program may hold it. End that program and press again. ${ON}`;
    default:
      return `The camera cannot be recorded: ${error.message || error.name}. Press again, or load the page anew. ${ON}`;
  }
}

/** One MediaRecorder from its beginning on: one file of the session's. */
class Film {
  private sequence = 0;
  private zeroMs = performance.now();
  private sent: Promise<void> = Promise.resolve();
  private readonly recorder: MediaRecorder;
  private readonly ended: Promise<void>;

  /** `send`: false where it cannot be sent, and nothing behind it can. */
  constructor(stream: MediaStream, [container, mimeType]: readonly [Container, string], send: (message: ArrayBuffer) => boolean, failed: (why: string) => void) {
    this.recorder = new MediaRecorder(stream, { mimeType, videoBitsPerSecond: BITS_PER_SECOND });
    this.recorder.onstart = () => (this.zeroMs = performance.now());
    this.recorder.ondataavailable = ({ data }: BlobEvent) => {
      if (data.size === 0) return;
      const ageMs = performance.now() - this.zeroMs;
      const sequence = this.sequence++;
      // One after the other, whichever is read first.
      this.sent = this.sent.then(async () => {
        if (!send(videoMessage(container, sequence, ageMs, await data.arrayBuffer()))) failed("");
      });
    };
    this.recorder.onerror = () => failed("the browser's recorder failed");
    this.ended = new Promise((resolve) => (this.recorder.onstop = () => resolve()));
    this.recorder.start(CHUNK_MS);
  }

  /** Resolves when its last chunk is sent, or does not come. */
  async finish(): Promise<void> {
    if (this.recorder.state !== "inactive") this.recorder.stop();
    await Promise.race([this.ended, new Promise((late) => window.setTimeout(late, LAST_CHUNK_MS))]);
    await this.sent;
  }

  /** What it has not sent is not sent any more. */
  discard(): void {
    this.recorder.ondataavailable = null;
    this.recorder.onerror = null;
    if (this.recorder.state !== "inactive") this.recorder.stop();
  }
}

export class BrowserCamera {
  readonly state = new Signal<CameraState>({ kind: "off" });
  /** What it sees, to be shown. */
  readonly stream = new Signal<MediaStream | null>(null);
  private film: Film | null = null;
  /** How often it was begun or let go so far: what was begun before is not gone on with. */
  private presses = 0;

  constructor(private readonly session: Session) {
    session.videoOver.listen((over) => {
      if (over) void this.hear(over.why, over.again);
    });
    // When it is back whoever wants video asks for it again, and another file begins.
    session.connection.listen((connection) => {
      if (connection.kind === "lost" && this.state.value.kind !== "off") this.close({ kind: "off" });
    });
  }

  /** Asks the session to record it, and the browser for it. Never rejects. */
  async start(): Promise<void> {
    this.close({ kind: "asking" });
    const press = this.presses;
    try {
      const type = canFilm() ? typeOf() : null;
      if (!type) return this.close({ kind: "refused", why: `This browser records no camera: it gives one only to pages of its own machine (127.0.0.1) or over HTTPS. ${ON}` });
      const reply = await this.session.send({ command: "video", on: true });
      if (press !== this.presses) return;
      if (!reply.ok) return this.close({ kind: "refused", why: reply.error });
      // Sound goes its own way, and only where it was agreed to.
      const stream = await navigator.mediaDevices.getUserMedia({ video: SIZE, audio: false });
      if (press !== this.presses) return stopTracks(stream);
      this.stream.set(stream);
      for (const track of stream.getTracks()) {
        track.onended = () => {
          if (this.stream.value === stream) this.stop({ kind: "refused", why: `The camera was unplugged, or the browser took it back. Plug it in and press again. ${ON}` });
        };
      }
      this.begin(stream, type);
      this.state.set({ kind: "on" });
    } catch (error) {
      if (press !== this.presses) return;
      const thrown = error instanceof Error || error instanceof DOMException ? error : new Error(String(error));
      this.stop({ kind: "refused", why: cameraRefusal(thrown) });
    }
  }

  /** Lets the camera go at once, and tells the session. */
  stop(state: CameraState = { kind: "off" }): void {
    const asked = this.state.value.kind === "on" || this.state.value.kind === "asking";
    this.close(state);
    if (asked) void this.session.send({ command: "video", on: false });
  }

  toggle(): void {
    const { kind } = this.state.value;
    if (kind === "on") void this.finish();
    else if (kind === "asking") this.stop();
    else void this.start();
  }

  /** Sends what was recorded up to now, and lets the camera go. */
  async finish(): Promise<void> {
    const press = this.presses;
    await this.film?.finish();
    if (press === this.presses) this.stop();
  }

  private begin(stream: MediaStream, type: readonly [Container, string]): void {
    this.film?.discard();
    const film: Film = new Film(
      stream, type,
      (message) => this.film !== film || this.session.sendVideo(message),
      (why) => {
        if (this.film !== film) return;
        this.stop({ kind: "refused", why: why === "" ? `The connection is too slow for video. ${ON} Press to try again.` : `The video ended: ${why}. Press to try again. ${ON}` });
      },
    );
    this.film = film;
  }

  private async hear(why: string, again: boolean): Promise<void> {
    const stream = this.stream.value;
    const type = again ? typeOf() : null;
    if (again && stream && type) this.begin(stream, type);
    else if (why === "") await this.finish();
    else this.close({ kind: "refused", why });
  }

  /** The browser's sign that it films goes off, and a start that is on its way ends. */
  private close(state: CameraState): void {
    ++this.presses;
    this.film?.discard();
    this.film = null;
    if (this.stream.value) stopTracks(this.stream.value);
    this.stream.set(null);
    this.state.set(state);
  }
}

function stopTracks(stream: MediaStream): void {
  for (const track of stream.getTracks()) track.stop();
}
