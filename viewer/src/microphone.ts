/** This browser's microphone, on its way to the session. */
import { soundMessage } from "./hearing_protocol";
import type { Session } from "./session";
import { Signal } from "./signal";

export type MicrophoneState =
  | { kind: "off" }
  /** The browser asks its user. */
  | { kind: "asking" }
  | { kind: "on" }
  /** What stands against it, and what to do. */
  | { kind: "refused"; why: string };

const AGAIN = "press again, or load the page anew";
const HOST = "start the session with --audio default: it then hears the microphone of its own machine";

/** Why a browser gives no microphone, and what to do: of the error that it threw; null: to an insecure page it has none. */
export function refusalWords(error: { name: string; message: string } | null): string {
  switch (error?.name) {
    case undefined:
      return `A browser gives its microphone only to pages of its own machine (127.0.0.1) or over HTTPS. Open this page there, or ${HOST}.`;
    case "NotAllowedError":
      return `The browser refused its microphone. Allow it for this page, by the sign beside the address, and press again; or ${HOST}.`;
    case "NotFoundError":
      return `The browser finds no microphone. Plug one in and press again; or ${HOST}.`;
    case "NotReadableError":
      return `The microphone cannot be opened: another program may hold it, or the system may not let the browser hear it. End that program, or allow it in the system's settings, and ${AGAIN}; or ${HOST}.`;
    default:
      return `The microphone cannot be used: ${error?.message || error?.name}. To try once more, ${AGAIN}; or ${HOST}.`;
  }
}

/** What is open while the microphone is on. */
interface Opened {
  stream: MediaStream;
  context: AudioContext | null;
}

export class BrowserMicrophone {
  readonly state = new Signal<MicrophoneState>({ kind: "off" });
  private opened: Opened | null = null;
  /** How often it was begun or let go so far: what was begun before is not gone on with. */
  private presses = 0;

  constructor(private readonly session: Session) {
    session.microphoneOver.listen((over) => {
      if (over && this.state.value.kind === "on") this.close(over.why === "" ? { kind: "off" } : { kind: "refused", why: over.why });
    });
    session.connection.listen((connection) => {
      if (connection.kind === "lost" && this.opened) this.close({ kind: "refused", why: `The connection to the session broke. When it is back, ${AGAIN}.` });
    });
  }

  /** Asks the browser for its microphone and the session to hear it. Never rejects. */
  async start(): Promise<void> {
    this.close({ kind: "asking" });
    const press = this.presses;
    try {
      // An insecure page has none, whatever the types say.
      const devices = navigator.mediaDevices as MediaDevices | undefined;
      if (!devices) return this.close({ kind: "refused", why: refusalWords(null) });
      // As it is: what a browser takes for noise, the session judges by itself.
      const stream = await devices.getUserMedia({ audio: { channelCount: 1, echoCancellation: false, noiseSuppression: false, autoGainControl: false } });
      if (press !== this.presses) return stopTracks(stream);
      const opened: Opened = { stream, context: null };
      this.opened = opened;
      opened.context = new AudioContext();
      await opened.context.audioWorklet.addModule(new URL("microphone_worklet.js", window.location.href));
      if (press !== this.presses) return;
      const reply = await this.session.send({ command: "microphone", on: true });
      if (press !== this.presses) return;
      if (!reply.ok) return this.close({ kind: "refused", why: reply.error });
      this.listen(stream, opened.context);
      this.state.set({ kind: "on" });
    } catch (error) {
      if (press !== this.presses) return;
      const thrown = error instanceof Error || error instanceof DOMException ? error : new Error(String(error));
      this.stop({ kind: "refused", why: refusalWords(thrown) });
    }
  }

  toggle(): void {
    const { kind } = this.state.value;
    if (kind === "on" || kind === "asking") this.stop();
    else void this.start();
  }

  /** Lets the microphone go, and tells the session. */
  stop(state: MicrophoneState = { kind: "off" }): void {
    const heard = this.opened !== null;
    this.close(state);
    if (heard) void this.session.send({ command: "microphone", on: false });
  }

  private listen(stream: MediaStream, context: AudioContext): void {
    const source = context.createMediaStreamSource(stream);
    const microphone = new AudioWorkletNode(context, "microphone", { numberOfInputs: 1, numberOfOutputs: 1, channelCount: 1, channelCountMode: "explicit" });
    microphone.port.onmessage = ({ data }: MessageEvent<{ count: number; samples: Int16Array }>) => {
      if (this.opened?.context === context) this.session.sendSound(soundMessage(context.sampleRate, data.count, data.samples));
    };
    // It gives out silence: what leads nowhere is not run by every browser.
    source.connect(microphone).connect(context.destination);
    void context.resume();
    for (const track of stream.getTracks()) {
      track.onended = () => {
        if (this.opened?.stream === stream) this.stop({ kind: "refused", why: `The microphone was unplugged, or the browser took it back. Plug it in and ${AGAIN}.` });
      };
    }
  }

  /** The browser's sign that it is heard goes off, and a start that is on its way ends. */
  private close(state: MicrophoneState): void {
    ++this.presses;
    const opened = this.opened;
    this.opened = null;
    if (opened) {
      stopTracks(opened.stream);
      void opened.context?.close();
    }
    this.state.set(state);
  }
}

function stopTracks(stream: MediaStream): void {
  for (const track of stream.getTracks()) track.stop();
}
