// The video beside a mock session's recording: of one browser, in files as docs/reference/page_protocol.md has them.

const HEAD_BYTES = 16;
const CONTAINERS = { 1: "webm", 2: "mp4" };
const BEGINNINGS = { webm: (data) => data.toString("latin1", 0, 4) === "\x1a\x45\xdf\xa3", mp4: (data) => data.toString("latin1", 4, 8) === "ftyp" };

/** Null: the session would refuse it. */
function readChunk(message) {
  if (message.length <= HEAD_BYTES || message.toString("latin1", 0, 5) !== "MVID\x01" || message.readUInt16LE(6) !== 0) return null;
  const container = CONTAINERS[message[5]];
  const chunk = { container, sequence: message.readUInt32LE(8), ageMs: message.readUInt32LE(12), data: message.subarray(HEAD_BYTES) };
  return container && (chunk.sequence > 0 || BEGINNINGS[container](chunk.data)) ? chunk : null;
}

export class MockVideo {
  agreed = false;
  /** Each {name, chunks, ages, bytes, over}, of all recordings. */
  files = [];
  client = null;
  refused = 0;
  trouble = null;
  take_ = "";
  count = 0;

  constructor(session) {
    this.session = session;
  }

  status() {
    if (!this.agreed && this.files.length === 0 && this.refused === 0) return null;
    const open = this.open();
    return { agreed: this.agreed, on: open !== null, file: this.files.at(-1)?.name ?? "", files: this.count, megabytes: this.files.reduce((sum, one) => sum + one.bytes, 0) / 1e6, trouble: this.trouble, refused: this.refused };
  }

  open() {
    const last = this.files.at(-1);
    return last && !last.over ? last : null;
  }

  allow(take) {
    Object.assign(this, { agreed: true, take_: take, count: 0, trouble: null });
  }

  /** The recording is over: what comes until the page says that it stopped is the last. */
  finish() {
    this.agreed = false;
    this.client?.send(JSON.stringify({ type: "video", on: false, why: "", again: false }));
  }

  ask(client, on) {
    if (!on) {
      if (this.client === client) this.release();
      return;
    }
    if (!this.agreed) throw new Error("video: no dataset is recorded whose performer agreed to video: it is agreed to with the consent, before the recording begins");
    if (this.client && this.client !== client) throw new Error("video: another browser's camera is recorded: stop it there, or close that page, and try again");
    Object.assign(this, { client, trouble: null });
  }

  /** What would end it: a full disk, a missing chunk. */
  fail(why, again = false) {
    this.client?.send(JSON.stringify({ type: "video", on: false, why, again }));
    const { client } = this;
    this.release();
    this.trouble = why;
    if (again) this.client = client;
  }

  release() {
    const open = this.open();
    if (open) open.over = true;
    this.client = null;
  }

  take(client, message) {
    const chunk = client === this.client ? readChunk(message) : null;
    let open = this.open();
    if (chunk?.sequence === 0) {
      if (open) open.over = true;
      this.count += 1;
      open = { name: `${this.take_.replace(/\.mien$/, "")}${this.count > 1 ? `_${this.count}` : ""}.${chunk.container}`, chunks: 0, ages: [], bytes: 0, data: [], over: false };
      this.files.push(open);
      this.trouble = null;
    }
    if (!chunk || !open || chunk.sequence !== open.chunks) {
      ++this.refused;
      return;
    }
    open.chunks += 1;
    open.ages.push(chunk.ageMs);
    open.bytes += chunk.data.length;
    open.data.push(Buffer.from(chunk.data));
  }

  leave(client) {
    if (this.client === client) this.release();
  }
}
