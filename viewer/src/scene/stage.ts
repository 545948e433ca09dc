/**
 * The window onto the heads: one, or two beside each other, seen by one camera. Draws only when asked, at the display's own
 * rate, and stops when nothing moves.
 */
import {
  PerspectiveCamera, Scene, SRGBColorSpace, Vector3, WebGLRenderer, type DirectionalLight, type Object3D,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { Pace } from "./pace";
import { drawsInSoftware } from "./software";
import { furnishStudio, lightRoom } from "./studio";

/** What the camera looks at: the middle of the face, m, frame H. */
const CENTRE = new Vector3(0, 0.006, 0.02);
/** Height of the picture at the face, m. */
const FRAMED_HEIGHT = 0.36;
/** Width that must fit, m. */
const FRAMED_WIDTH = 0.25;
const FIELD_OF_VIEW_DEG = 22;
/** From a little to the side and above: a face seen dead on looks flat. */
const FIRST_VIEW = new Vector3(0.1, 0.045, 1).normalize();

/** Between two heads, CSS pixels. */
const GAP_PX = 110;

export type Place = "first" | "second";

export interface Rect {
  left: number;
  top: number;
  width: number;
  height: number;
}

export class Stage {
  readonly camera = new PerspectiveCamera(FIELD_OF_VIEW_DEG, 1, 0.1, 10);
  readonly canvas: HTMLCanvasElement;
  /** Called before each drawing with the time, ms; answers whether another is wanted. */
  onDraw: (nowMs: number) => boolean = () => false;
  /** Called after each drawing, when matrices are those of the picture. */
  onDrawn: () => void = () => {};

  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly controls: OrbitControls;
  /** Poses the second head for a small picture beside it; null: there is none. */
  private inset: (() => void) | null = null;
  private readonly heads: Record<Place, Object3D | null> = { first: null, second: null };
  private width = 1;
  private height = 1;
  /** CSS pixels of the canvas that something else covers: the face keeps to the middle of the rest. */
  private covered = { top: 0, right: 0, bottom: 0, left: 0 };
  private scheduled = 0;  // Number of the drawing that is waited for; 0: none.
  private asked = 0;
  private fitted = 0;
  private readonly pace: Pace;
  private readonly key: DirectionalLight;

  /** Called when the graphics card has forgotten the page; the picture comes back with it. */
  onLost: () => void = () => {};
  /** Called when pictures have become coarser, or plain. */
  onQuality: () => void = () => {};

  /**
   * Throws where there is no WebGL 2. `asked`: "low" begins, and stays, with the coarsest pictures; "high" begins with the
   * finest even where there is no graphics card.
   */
  constructor(
    private readonly host: HTMLElement,
    private readonly calm: () => boolean,
    asked: string | null,
  ) {
    const from = asked === "low" ? "coarsest" : asked !== "high" && drawsInSoftware() ? "plain" : "finest";
    this.pace = new Pace(from);
    this.renderer = new WebGLRenderer({ antialias: from === "finest", alpha: true, powerPreference: "high-performance" });
    this.canvas = this.renderer.domElement;
    this.canvas.className = "stage-canvas";
    this.renderer.outputColorSpace = SRGBColorSpace;
    this.renderer.setClearAlpha(0);
    this.renderer.autoClear = false;
    host.append(this.canvas);
    this.key = furnishStudio(this.renderer, this.scene);
    if (!this.plain) this.lightRoom();

    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enablePan = false;
    this.controls.enableDamping = !this.calm();
    this.controls.dampingFactor = 0.08;
    this.controls.rotateSpeed = 0.7;
    this.controls.minAzimuthAngle = -1.75;
    this.controls.maxAzimuthAngle = 1.75;
    this.controls.minPolarAngle = 0.95;
    this.controls.maxPolarAngle = 1.95;
    this.controls.target.copy(CENTRE);
    this.controls.addEventListener("change", () => this.wake());
    this.canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      this.onLost();
    });
    // All that files and this page gave the card comes back by itself; what the card drew for itself does not.
    this.canvas.addEventListener("webglcontextrestored", () => {
      if (this.scene.environment) lightRoom(this.renderer, this.scene);
      this.wake();
    });
    this.size();
    this.resetView();
    new ResizeObserver(() => {
      this.size();
      this.draw(performance.now());
    }).observe(host);
  }

  /** Puts a head in its place; what was there is given back, to be disposed of. */
  put(place: Place, head: Object3D | null): Object3D | null {
    const before = this.heads[place];
    if (before === head) return null;
    if (before) this.scene.remove(before);
    this.heads[place] = head;
    if (head) this.scene.add(head);
    this.fit();
    this.wake();
    return before;
  }

  /** A small picture of the second head beside it, posed by `pose` just before it is drawn; null takes it away. */
  setInset(pose: (() => void) | null): void {
    if ((this.inset === null) !== (pose === null)) this.wake();
    this.inset = pose;
  }

  /** Keeps these margins of the canvas free of the face, CSS pixels. */
  cover(margins: { top: number; right: number; bottom: number; left: number }): void {
    const same = (Object.keys(margins) as (keyof typeof margins)[]).every((side) => margins[side] === this.covered[side]);
    if (same) return;
    this.covered = margins;
    this.fit();
    this.wake();
  }

  /** The camera back to where it began. */
  resetView(): void {
    this.camera.position.copy(CENTRE).addScaledVector(FIRST_VIEW, this.fitted || 1);
    this.controls.update();
    this.wake();
  }

  /** Turns the camera about the face, radians; for the keyboard. */
  orbit(azimuth: number, polar: number): void {
    const offset = this.camera.position.clone().sub(CENTRE);
    const radius = offset.length();
    const around = Math.atan2(offset.x, offset.z) + azimuth;
    const down = Math.acos(offset.y / radius) + polar;
    const limitedAround = Math.min(this.controls.maxAzimuthAngle, Math.max(this.controls.minAzimuthAngle, around));
    const limitedDown = Math.min(this.controls.maxPolarAngle, Math.max(this.controls.minPolarAngle, down));
    offset.set(
      Math.sin(limitedDown) * Math.sin(limitedAround),
      Math.cos(limitedDown),
      Math.sin(limitedDown) * Math.cos(limitedAround),
    );
    this.camera.position.copy(CENTRE).addScaledVector(offset, radius);
    this.controls.update();
    this.wake();
  }

  /** Sees to it that a picture is drawn at the display's next refresh. */
  wake(): void {
    if (this.scheduled !== 0) return;
    this.scheduled = ++this.asked;
    const turn = this.scheduled;
    const next = () =>
      requestAnimationFrame((now) => {
        if (this.scheduled === turn) this.draw(now);
      });
    const rest = this.pace.rest;
    if (rest > 0) window.setTimeout(next, rest);
    else next();
  }

  /** Where a head is drawn, CSS pixels within the canvas. */
  rectOf(place: Place): Rect {
    const { top, right, bottom, left } = this.covered;
    const free = { left, top, width: Math.max(1, this.width - left - right), height: Math.max(1, this.height - top - bottom) };
    if (!this.heads.second) return free;
    // Beside each other where there is width for it, else above each other.
    if (free.width > free.height * 0.85) {
      // Room between them for what is said of both.
      const gap = Math.min(GAP_PX, free.width * 0.12);
      const half = (free.width - gap) / 2;
      return { ...free, left: free.left + (place === "first" ? half + gap : 0), width: half };
    }
    const half = free.height / 2;
    return { ...free, top: free.top + (place === "first" ? half : 0), height: half };
  }

  /** Where the small picture is drawn: a lower corner of the second head's, away from the first. */
  insetRect(): Rect {
    const rect = this.rectOf("second");
    const width = Math.round(Math.max(64, Math.min(rect.width * 0.3, rect.height * 0.24)));
    const height = Math.round(width * 1.2);
    return { left: rect.left + 14, top: rect.top + rect.height - height - 30, width, height };
  }

  /** Where a point of the world lies in the picture of a head, CSS pixels of the canvas; z is below 1 before the camera. */
  project(place: Place, point: Vector3): Vector3 {
    this.lens(this.rectOf(place));
    point.project(this.camera);
    point.x = ((point.x + 1) / 2) * this.width;
    point.y = ((1 - point.y) / 2) * this.height;
    return point;
  }

  /** Finds the room's light for heads that are not plain: without a graphics card that takes seconds. */
  lightRoom(): void {
    if (!this.scene.environment) lightRoom(this.renderer, this.scene);
  }

  /** Whether heads are to be lit a vertex at a time. */
  get plain(): boolean {
    return this.pace.quality.plain;
  }

  /** What the graphics card was given, for tests that watch for leaks. */
  memory(): { geometries: number; textures: number } {
    return { ...this.renderer.info.memory };
  }

  private size(): void {
    const { clientWidth, clientHeight } = this.host;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.width = clientWidth;
    this.height = clientHeight;
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1) * this.pace.quality.sharpness);
    this.key.castShadow = this.pace.quality.shadows;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.fit();
  }

  /** Distance at which the face fits its rectangle; a view that somebody chose keeps its direction and its zoom. */
  private fit(): void {
    const rect = this.rectOf("first");
    const tangent = Math.tan((FIELD_OF_VIEW_DEG * Math.PI) / 360);
    const byHeight = FRAMED_HEIGHT / 2 / tangent;
    const byWidth = FRAMED_WIDTH / 2 / (tangent * (rect.width / rect.height));
    const distance = Math.max(byHeight, byWidth);
    const zoom = this.fitted > 0 ? this.camera.position.distanceTo(CENTRE) / this.fitted : 1;
    const direction = this.camera.position.clone().sub(CENTRE);
    if (direction.lengthSq() < 1e-9) direction.copy(FIRST_VIEW);
    this.camera.position.copy(CENTRE).addScaledVector(direction.normalize(), distance * zoom);
    this.fitted = distance;
    this.controls.minDistance = distance * 0.35;
    this.controls.maxDistance = distance * 1.35;
    this.controls.update();
  }

  /** The whole canvas is one picture whose middle is shifted onto the rectangle, so that nothing is cut at its edges. */
  private lens(rect: Rect): void {
    const camera = this.camera;
    const scale = this.height / rect.height;
    camera.fov = FIELD_OF_VIEW_DEG;
    camera.aspect = this.width / this.height;
    const x = rect.left + rect.width / 2 - this.width / 2;
    const y = rect.top + rect.height / 2 - this.height / 2;
    // One rectangle of the height `rect.height` shows FIELD_OF_VIEW_DEG; the canvas around it shows more.
    const tangent = Math.tan((FIELD_OF_VIEW_DEG * Math.PI) / 360) * scale;
    camera.fov = (Math.atan(tangent) * 360) / Math.PI;
    camera.setViewOffset(this.width, this.height, -x, -y, this.width, this.height);
    camera.updateMatrixWorld();
  }

  private drawInset(head: Object3D, pose: () => void): void {
    if (this.heads.first) this.heads.first.visible = false;
    head.visible = true;
    pose();
    const rect = this.insetRect();
    this.lens(rect);
    this.renderer.setScissorTest(true);
    this.renderer.setScissor(rect.left, this.height - rect.top - rect.height, rect.width, rect.height);
    this.renderer.clear();
    this.renderer.render(this.scene, this.camera);
  }

  private draw(nowMs: number): void {
    this.scheduled = 0;
    // Before the picture: a canvas that has changed its size is empty.
    if (this.pace.drew(nowMs)) {
      this.size();
      this.onQuality();
    }
    const more = this.onDraw(nowMs);
    const damping = this.controls.update();
    const renderer = this.renderer;
    renderer.setScissorTest(false);
    renderer.setViewport(0, 0, this.width, this.height);
    renderer.clear();
    for (const place of ["second", "first"] as const) {
      const head = this.heads[place];
      if (!head) continue;
      for (const other of ["first", "second"] as const) {
        const one = this.heads[other];
        if (one) one.visible = other === place;
      }
      const rect = this.rectOf(place);
      this.lens(rect);
      if (this.heads.second) {
        renderer.setScissorTest(true);
        const sideways = rect.width < this.width - this.covered.left - this.covered.right - 1;
        const full = { left: 0, top: 0, width: this.width, height: this.height };
        const clip = sideways ? { ...full, left: place === "second" ? 0 : rect.left, width: place === "second" ? rect.left + rect.width : this.width - rect.left }
          : { ...full, top: place === "second" ? 0 : rect.top, height: place === "second" ? rect.top + rect.height : this.height - rect.top };
        renderer.setScissor(clip.left, this.height - clip.top - clip.height, clip.width, clip.height);
      }
      renderer.render(this.scene, this.camera);
    }
    if (this.inset && this.heads.second) this.drawInset(this.heads.second, this.inset);
    this.onDrawn();
    if (more || damping) this.wake();
  }
}
