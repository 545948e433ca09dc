/** The light: a large soft key from the performer's right and above, a weak fill, a rim from behind, and a room to mirror. */
import {
  AmbientLight, BackSide, BoxGeometry, Color, DirectionalLight, Mesh, MeshBasicMaterial, PMREMGenerator, Scene, VSMShadowMap,
  type WebGLRenderer,
} from "three";

/** Adds the lights to `scene`, makes the renderer ready for them, and gives the light that casts the shadows. */
export function furnishStudio(renderer: WebGLRenderer, scene: Scene): DirectionalLight {
  renderer.shadowMap.enabled = true;
  renderer.shadowMap.type = VSMShadowMap;

  const key = new DirectionalLight(0xfff1e2, 2.5);
  key.position.set(-0.55, 0.62, 0.95);
  key.castShadow = true;
  key.shadow.mapSize.set(512, 512);
  key.shadow.camera.left = key.shadow.camera.bottom = -0.24;
  key.shadow.camera.right = key.shadow.camera.top = 0.24;
  key.shadow.camera.near = 0.6;
  key.shadow.camera.far = 1.9;
  key.shadow.radius = 5;
  key.shadow.blurSamples = 12;
  key.shadow.bias = -0.0006;
  key.shadow.normalBias = 0.002;

  const fill = new DirectionalLight(0xcfe0ff, 0.55);
  fill.position.set(0.9, 0.1, 0.7);
  const rim = new DirectionalLight(0xffffff, 1.4);
  rim.position.set(0.75, 0.55, -0.9);
  const kicker = new DirectionalLight(0xbfd4ff, 0.4);
  kicker.position.set(-0.9, 0.2, -0.7);
  scene.add(key, fill, rim, kicker, new AmbientLight(0xffffff, 0.12));

  const generator = new PMREMGenerator(renderer);
  const room = mirroredRoom();
  scene.environment = generator.fromScene(room, 0.03).texture;
  scene.environmentIntensity = 0.62;
  generator.dispose();
  room.traverse((node) => {
    const mesh = node as Mesh<BoxGeometry, MeshBasicMaterial>;
    if (!mesh.isMesh) return;
    mesh.geometry.dispose();
    mesh.material.dispose();
  });
  return key;
}

/** A dim room with soft boxes: what eyes and lips mirror. */
function mirroredRoom(): Scene {
  const room = new Scene();
  const walls = new Mesh(new BoxGeometry(10, 8, 10), new MeshBasicMaterial({ color: 0x30302f, side: BackSide }));
  room.add(walls);
  const box = (x: number, y: number, z: number, width: number, height: number, depth: number, brightness: number) => {
    const light = new Mesh(
      new BoxGeometry(width, height, depth),
      new MeshBasicMaterial({ color: new Color(brightness, brightness * 0.98, brightness * 0.95) }),
    );
    light.position.set(x, y, z);
    room.add(light);
  };
  box(-3.2, 2.2, 3.4, 1.8, 2.4, 0.1, 9);
  box(3.8, 0.8, 2.6, 0.1, 2.6, 1.8, 3);
  box(0, 3.9, 0.5, 4, 0.1, 3, 3.2);
  box(2.6, 1.6, -4.4, 1.6, 3, 0.1, 5);
  box(0, -3.9, 2, 6, 0.1, 4, 0.35);
  return room;
}
