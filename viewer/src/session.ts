/** What the page knows of the session, and what it may ask of it: the connection with its messages laid out as signals. */
import { Connection, type ConnectionState } from "./connection";
import type { MicrophoneOver } from "./hearing_protocol";
import { History } from "./history";
import type { CameraPicture } from "./picture_protocol";
import { Playout } from "./playout";
import type { VideoOver } from "./video_protocol";
import { readTakes, type Command, type Frame, type Hello, type Message, type Reply, type SessionEvent, type Status, type Take } from "./protocol";
import { Signal } from "./signal";

/** What of a session's news stays to be read again. */
const KEPT_EVENTS = 50;
/** Four a second for two minutes. */
const KEPT_LATENCIES = 480;

export class Session {
  readonly connection = new Signal<ConnectionState>({ kind: "connecting" });
  readonly hello = new Signal<Hello | null>(null);
  readonly status = new Signal<Status | null>(null);
  /** The newest frame, up to 60 a second. */
  readonly frame = new Signal<Frame | null>(null);
  /** Newest last. */
  readonly events = new Signal<readonly (SessionEvent & { atMs: number })[]>([]);
  readonly latencies = new Signal<readonly { p50: number; p99: number }[]>([]);
  readonly takes = new Signal<readonly Take[]>([]);
  /** That this browser's microphone is heard no more, and why. */
  readonly microphoneOver = new Signal<MicrophoneOver | null>(null);
  /** That this browser's camera is recorded no more, or anew. */
  readonly videoOver = new Signal<VideoOver | null>(null);
  /** The newest of any camera, where this page asked for pictures. */
  readonly picture = new Signal<CameraPicture | null>(null);
  readonly history = new History();
  readonly playout = new Playout();

  private readonly link = new Connection({
    state: (state) => this.connection.set(state),
    message: (message) => this.hear(message),
  });

  open(): void {
    this.link.open();
  }

  retryNow(): void {
    this.link.retryNow();
  }

  /** Messages of the session that could not be read. */
  get malformed(): number {
    return this.link.malformed;
  }

  /** Whether what is shown is what is: not so while the connection is away. */
  get connected(): boolean {
    return this.connection.value.kind === "open";
  }

  /** Never rejects: a refusal is a reply that is not ok. */
  send(command: Command): Promise<Reply> {
    return this.link.send(command);
  }

  /** A piece of sound; lost where the connection is behind or away. */
  sendSound(message: ArrayBuffer): void {
    this.link.sendSound(message);
  }

  /** A chunk of video; false where the connection is far behind or away: nothing behind it can be used then. */
  sendVideo(message: ArrayBuffer): boolean {
    return this.link.sendVideo(message);
  }

  async refreshTakes(): Promise<void> {
    const reply = await this.send({ command: "takes" });
    if (reply.ok) this.takes.set(readTakes(reply.result));
  }

  private hear(message: Exclude<Message, Reply>): void {
    switch (message.type) {
      case "hello":
        this.history.clear();
        this.playout.clear();
        this.hello.set(message);
        void this.refreshTakes();
        break;
      case "frame":
        this.history.add(message);
        this.playout.add(message, performance.now());
        this.frame.set(message);
        break;
      case "status":
        if (message.latency) {
          this.latencies.set([...this.latencies.value.slice(1 - KEPT_LATENCIES), message.latency]);
        }
        this.status.set(message);
        break;
      case "event":
        this.events.set([...this.events.value.slice(1 - KEPT_EVENTS), { ...message, atMs: performance.now() }]);
        // However a recording ended, the list has its take as it was before.
        if (message.kind === "recorded" || message.kind === "recording_failed") void this.refreshTakes();
        break;
      case "takes":
        this.takes.set(message.takes);
        break;
      case "picture":
        this.picture.set(message);
        break;
      case "microphone":
        this.microphoneOver.set(message);
        break;
      case "video":
        this.videoOver.set(message);
        break;
    }
  }
}
