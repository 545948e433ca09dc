/** What the camera sees, before a block, where the performer agreed to video. */
import type { BrowserCamera } from "../browser_camera";
import { h, setAttribute, setHidden, setText } from "../dom";
import type { Status } from "../protocol";
import type { VideoStatus } from "../video_protocol";

/** How it stands with the video of a recording that its performer agreed to. `here`: this browser's camera. */
export function videoWords(video: VideoStatus, here: { kind: string; why?: string }): { words: string; severity: string } {
  if (here.kind === "asking") return { words: "The browser asks whether its camera may be used.", severity: "warn" };
  if (here.kind === "refused") return { words: here.why ?? "", severity: "bad" };
  if (video.trouble !== "") return { words: `${video.trouble.charAt(0).toLocaleUpperCase()}${video.trouble.slice(1)}.`, severity: "bad" };
  if (video.on) return { words: `${here.kind === "on" ? "Your face is recorded" : "Another browser's camera is recorded"}: ${video.file || "the file is made"}, ${video.megabytes.toFixed(1)} MB.`, severity: "good" };
  return { words: here.kind === "on" ? "The camera is on." : "No camera is recorded.", severity: here.kind === "on" ? "good" : "warn" };
}

export class VideoCheck {
  readonly element: HTMLElement;
  private readonly preview = h("video", { class: "check-preview", autoplay: true, playsinline: true, muted: true, "aria-label": "What the camera sees", hidden: true });
  private readonly words = h("p");
  private readonly use: HTMLButtonElement;

  /** `wanted`: told what the performer wants of this browser's camera. */
  constructor(
    private readonly camera: BrowserCamera,
    wanted: (on: boolean) => void,
  ) {
    this.preview.muted = true;
    this.use = h("button", { type: "button", class: "button", onclick: () => wanted(!this.running) });
    this.element = h("section", { class: "check-part", hidden: true }, h("h3", { text: "Camera" }), this.preview, this.words, this.use);
    camera.stream.listen((stream) => {
      this.preview.srcObject = stream;
      setHidden(this.preview, stream === null);
    });
  }

  update({ video }: Status): void {
    setHidden(this.element, !video?.agreed);
    if (!video?.agreed) return;
    const { words, severity } = videoWords(video, this.camera.state.value);
    setText(this.words, words);
    setAttribute(this.element, "data-severity", severity);
    setText(this.use, this.running ? "Stop this browser's camera" : "Use this browser's camera");
  }

  private get running(): boolean {
    const { kind } = this.camera.state.value;
    return kind === "on" || kind === "asking";
  }
}
