// In the browser's thread of sound: hands the page what its microphone gives, 20 ms at a time, as {count, samples}: samples
// of 16 bits, and how many there were before them since the sound began. A gap shows in the count.
class Microphone extends AudioWorkletProcessor {
  piece = new Int16Array(Math.round(sampleRate / 50));
  filled = 0;
  begun = -1;
  count = 0;

  process([input]) {
    const sound = input?.[0];
    if (!sound) {
      this.filled = 0;
      return true;
    }
    if (this.begun < 0) this.begun = currentFrame;
    for (let i = 0; i < sound.length; ++i) {
      if (this.filled === 0) this.count = currentFrame + i - this.begun;
      this.piece[this.filled++] = Math.max(-32768, Math.min(32767, Math.round(32768 * sound[i])));
      if (this.filled < this.piece.length) continue;
      this.port.postMessage({ count: this.count, samples: this.piece.slice() });
      this.filled = 0;
    }
    return true;
  }
}
registerProcessor("microphone", Microphone);
