// What a mock session hears: the switch, and the sound of one browser.

const HEAD_BYTES = 20;

/** As docs/reference/page_protocol.md has it; null: the session would refuse it. */
function readPiece(data) {
  const samples = (data.length - HEAD_BYTES) / 2;
  if (!Number.isInteger(samples) || samples < 1 || data.toString("latin1", 0, 8) !== "MSND\x01\0\0\0") return null;
  const rate = data.readUInt32LE(8);
  if (rate < 8000 || rate > 192_000 || samples > rate / 10) return null;
  let square = 0;
  for (let i = HEAD_BYTES; i < data.length; i += 2) square += (data.readInt16LE(i) / 32768) ** 2;
  return { rate, count: Number(data.readBigUInt64LE(12)), samples, rms: Math.sqrt(square / samples) };
}

export class MockVoice {
  /** As `status` has it. */
  hearing = { on: true, speaks: true, share: 0.37, later_ms: 35, shut: false, blocks: 0, trouble: null, browser: null };
  /** Of the newest piece, 0 to 1: 0 at -60 dB. */
  level = 0;
  client = null;
  /** Of this client's sound so far. */
  samples = 0;
  /** Blocks of whoever was heard before. */
  before = 0;

  /** `browser`: one may be heard. */
  constructor(browser) {
    if (browser) this.hearing.browser = { heard: false, refused: 0 };
  }

  switch(on) {
    Object.assign(this.hearing, { on, speaks: false });
    if (!on) this.release("");
  }

  /** The command `microphone`. */
  ask(client, on) {
    if (!this.hearing.browser) throw new Error("microphone: the session hears no browser's microphone; start it with --audio page");
    if (on && !this.hearing.on) throw new Error("microphone: the voice is switched off; switch it on first");
    if (!on && this.client !== client) return;
    if (this.client !== client) this.release("Another browser's microphone is heard instead.");
    this.begin(on ? client : null);
    this.hearing.browser.heard = on;
  }

  release(why) {
    this.client?.send(JSON.stringify({ type: "microphone", on: false, why }));
    this.begin(null);
    if (this.hearing.browser) this.hearing.browser.heard = false;
  }

  begin(client) {
    Object.assign(this, { client, samples: 0, level: 0, before: this.hearing.blocks });
  }

  take(client, data) {
    if (!this.hearing.browser) return;
    const piece = client === this.client ? readPiece(data) : null;
    if (!piece || piece.count < this.samples) {
      ++this.hearing.browser.refused;
      return;
    }
    this.samples = piece.count + piece.samples;
    this.level = Math.min(1, Math.max(0, 1 + Math.log10(piece.rms + 1e-9) / 3));
    this.hearing.blocks = this.before + Math.floor((50 * this.samples) / piece.rate);
  }

  leave(client) {
    if (this.client === client) this.release("");
  }
}
