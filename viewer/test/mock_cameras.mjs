// A headset's cameras for the mock session: what they see is drawn, rings instead of a face, and is sent to whoever asked for it.

const SIDE = 96;
/** Pictures a second. */
const RATE = 10;
/**
 * Who is so much behind, bytes, is sent none, as the session has it: frames and states come first, and are sent to whoever is
 * less behind than twice as much.
 */
const MOST_WAITING = 50_000;

/** The message of a camera's picture. */
export function pictureMessage(sensor, width, height, levelAt) {
  const message = Buffer.alloc(12 + width * height);
  message.write("MPIC", 0, "latin1");
  message.writeUInt8(1, 4);
  message.writeUInt16LE(sensor, 6);
  message.writeUInt16LE(width, 8);
  message.writeUInt16LE(height, 10);
  for (let y = 0; y < height; ++y) for (let x = 0; x < width; ++x) message[12 + y * width + x] = levelAt(x, y);
  return message;
}

export class MockCameras {
  watchers = new Set();
  sent = 0;

  /** `cameras`: how many there are; 0: it is no headset. Of `every` pictures one is sent. `isSeen`: whether a camera's pictures come now. */
  constructor(cameras, every, isSeen) {
    this.cameras = cameras;
    this.isSeen = isSeen;
    if (cameras > 0) this.timer = setInterval(() => this.send(), (1000 * every) / RATE);
  }

  close() {
    clearInterval(this.timer);
  }

  get status() {
    return this.cameras > 0 ? { cameras: this.cameras, watchers: this.watchers.size } : null;
  }

  show(client, on) {
    if (this.cameras === 0) throw new Error("this session has no camera");
    if (on) this.watchers.add(client);
    else this.watchers.delete(client);
  }

  leave(client) {
    this.watchers.delete(client);
  }

  send() {
    if (this.watchers.size === 0) return;
    ++this.sent;
    for (let sensor = 0; sensor < this.cameras; ++sensor) {
      if (!this.isSeen(sensor)) continue;
      const middle = SIDE * (0.5 + 0.1 * Math.sin(this.sent / 5 + sensor));
      const picture = pictureMessage(sensor, SIDE, SIDE, (x, y) => 128 + 100 * Math.cos(Math.hypot(x - middle, y - SIDE / 2) / (2 + sensor)));
      for (const client of this.watchers) if (client.bufferedAmount < MOST_WAITING) client.send(picture);
    }
  }
}
