/** The one WebSocket to the session: opens it, opens it again when it breaks, and matches replies to commands. */
import { readPicture } from "./picture_protocol";
import { OWN_ORDER, readMessage, type Command, type Message, type Reply } from "./protocol";

export type ConnectionState =
  | { kind: "connecting" }
  | { kind: "open" }
  /** Open, but nothing has been heard for a while. */
  | { kind: "stalled" }
  /** `refused`: the session is there and does not accept our token. */
  | { kind: "lost"; retryAtMs: number; attempts: number; refused: boolean };

export interface ConnectionListener {
  state(state: ConnectionState): void;
  /** Everything but replies, which go to those who asked. */
  message(message: Exclude<Message, Reply>): void;
}

/** The session speaks at least four times a second: this long without a word, ms, is a stall. */
const STALL_MS = 2500;
const REPLY_TIMEOUT_MS = 10_000;
const FIRST_RETRY_MS = 500;
const LONGEST_RETRY_MS = 5000;
/** A message longer than this is not read. */
const LONGEST_MESSAGE = 1 << 20;
/** Of sound so many bytes may wait to be sent, half a second: what comes later than that is of no use. */
const MOST_WAITING_SOUND = 50_000;
/** Of video, half a minute. */
const MOST_WAITING_VIDEO = 10_000_000;

/** An address of this page's host with the page's token passed on. */
export function withToken(path: string, location: { href: string; search: string }): URL {
  const url = new URL(path, location.href);
  const token = new URLSearchParams(location.search).get("token");
  if (token !== null) url.searchParams.set("token", token);
  return url;
}

interface Waiting {
  settle(reply: Reply): void;
  timer: number;
}

export class Connection {
  /** Messages that could not be read. */
  malformed = 0;

  private socket: WebSocket | null = null;
  /** Bytes of the newest chunk of video: sound may wait for it to be sent. */
  private newestVideo = 0;
  private order: Int16Array = OWN_ORDER;
  private nextId = 1;
  private attempts = 0;
  private heardAtMs = 0;
  private stalled = false;
  private retryTimer = 0;
  private readonly waiting = new Map<number, Waiting>();

  constructor(private readonly listener: ConnectionListener) {
    window.setInterval(() => this.watch(), 500);
    window.addEventListener("online", () => this.retryNow());
  }

  open(): void {
    window.clearTimeout(this.retryTimer);
    const url = withToken("/ws", window.location);
    url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
    this.listener.state({ kind: "connecting" });
    const socket = new WebSocket(url);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onopen = () => {
      this.attempts = 0;
      this.stalled = false;
      this.heardAtMs = performance.now();
      this.listener.state({ kind: "open" });
    };
    socket.onmessage = (event: MessageEvent<unknown>) => this.hear(event.data);
    socket.onclose = () => {
      if (this.socket === socket) this.lose();
    };
  }

  /** Tries at once instead of waiting. */
  retryNow(): void {
    if (this.socket === null) this.open();
  }

  /**
   * Sends a command. Resolves with the reply, whether it says yes or no; with a refusal of our own when there is no
   * connection or no answer comes. Never rejects.
   */
  send(command: Command): Promise<Reply> {
    const id = this.nextId++;
    const socket = this.socket;
    if (!socket || socket.readyState !== WebSocket.OPEN) {
      return Promise.resolve(refusal(id, "There is no connection to the session."));
    }
    socket.send(JSON.stringify({ id, ...command }));
    return new Promise((resolve) => {
      const timer = window.setTimeout(() => this.answer(refusal(id, "The session did not answer.")), REPLY_TIMEOUT_MS);
      this.waiting.set(id, { settle: resolve, timer });
    });
  }

  /** Sends a piece of sound, or lets it go where what was sent before still waits. */
  sendSound(message: ArrayBuffer): void {
    const socket = this.socket;
    if (socket?.bufferedAmount === 0) this.newestVideo = 0;
    if (socket?.readyState === WebSocket.OPEN && socket.bufferedAmount < MOST_WAITING_SOUND + this.newestVideo) socket.send(message);
  }

  /** Sends a chunk of video; false where too much waits already, or nobody is there. */
  sendVideo(message: ArrayBuffer): boolean {
    const socket = this.socket;
    if (socket?.readyState !== WebSocket.OPEN || socket.bufferedAmount > MOST_WAITING_VIDEO) return false;
    this.newestVideo = message.byteLength;
    socket.send(message);
    return true;
  }

  private hear(data: unknown): void {
    this.heardAtMs = performance.now();
    if (this.stalled) {
      this.stalled = false;
      this.listener.state({ kind: "open" });
    }
    const message = this.read(data);
    if (!message) {
      ++this.malformed;
      return;
    }
    if (message.type === "hello") this.order = message.order;
    if (message.type === "reply") this.answer(message);
    else this.listener.message(message);
  }

  private read(data: unknown): Message | null {
    if (data instanceof ArrayBuffer) return data.byteLength <= LONGEST_MESSAGE ? readPicture(data) : null;
    return typeof data === "string" && data.length <= LONGEST_MESSAGE ? readMessage(data, this.order) : null;
  }

  private answer(reply: Reply): void {
    const waiting = this.waiting.get(reply.id);
    if (!waiting) return;
    this.waiting.delete(reply.id);
    window.clearTimeout(waiting.timer);
    waiting.settle(reply);
  }

  private lose(): void {
    this.socket = null;
    for (const id of [...this.waiting.keys()]) this.answer(refusal(id, "The connection broke before the answer came."));
    const pause = Math.min(LONGEST_RETRY_MS, FIRST_RETRY_MS * 2 ** Math.min(this.attempts, 6));
    const attempts = ++this.attempts;
    const retryAtMs = performance.now() + pause;
    this.listener.state({ kind: "lost", retryAtMs, attempts, refused: false });
    this.retryTimer = window.setTimeout(() => this.open(), pause);
    void this.askWhetherRefused(retryAtMs, attempts);
  }

  /** A browser does not tell why a WebSocket was refused; an ordinary request does. */
  private async askWhetherRefused(retryAtMs: number, attempts: number): Promise<void> {
    try {
      const answer = await fetch(withToken("/face.glb", window.location), { method: "HEAD", cache: "no-store" });
      const refused = answer.status === 401 || answer.status === 403;
      if (refused && this.socket === null) this.listener.state({ kind: "lost", retryAtMs, attempts, refused });
    } catch {
      // Not reachable at all: that is what has been said already.
    }
  }

  private watch(): void {
    const open = this.socket?.readyState === WebSocket.OPEN;
    if (open && !this.stalled && performance.now() - this.heardAtMs > STALL_MS) {
      this.stalled = true;
      this.listener.state({ kind: "stalled" });
    }
  }
}

function refusal(id: number, error: string): Reply {
  return { type: "reply", id, ok: false, error, result: null };
}
