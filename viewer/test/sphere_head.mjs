// A head of our own for tests: an egg with 53 named morph targets and two eyes, as .glb with the session's names or with
// ARKit's, or as a VRM 1.0 with Perfect Sync expressions. Not pretty; everything is where a real file has it.

export const SHAPES = [
  "browDown_L", "browDown_R", "browInnerUp_L", "browInnerUp_R", "browOuterUp_L", "browOuterUp_R", "cheekPuff_L",
  "cheekPuff_R", "cheekSquint_L", "cheekSquint_R", "eyeBlink_L", "eyeBlink_R", "eyeLookDown_L", "eyeLookDown_R",
  "eyeLookIn_L", "eyeLookIn_R", "eyeLookOut_L", "eyeLookOut_R", "eyeLookUp_L", "eyeLookUp_R", "eyeSquint_L",
  "eyeSquint_R", "eyeWide_L", "eyeWide_R", "jawForward", "jawLeft", "jawOpen", "jawRight", "mouthClose",
  "mouthDimple_L", "mouthDimple_R", "mouthFrown_L", "mouthFrown_R", "mouthFunnel", "mouthLeft", "mouthLowerDown_L",
  "mouthLowerDown_R", "mouthPress_L", "mouthPress_R", "mouthPucker", "mouthRight", "mouthRollLower", "mouthRollUpper",
  "mouthShrugLower", "mouthShrugUpper", "mouthSmile_L", "mouthSmile_R", "mouthStretch_L", "mouthStretch_R",
  "mouthUpperUp_L", "mouthUpperUp_R", "noseSneer_L", "noseSneer_R",
];

/** Where a shape pulls (m) and whither (m). */
function pull(name) {
  const side = name.endsWith("_L") ? 1 : name.endsWith("_R") ? -1 : 0;
  const at = (x, y, radius, dx, dy, dz) => ({ x: x * (side || 1), y, radius, d: [dx * (side || 1), dy, dz] });
  const stem = name.replace(/_[LR]$/, "");
  const table = {
    jawOpen: at(0, -0.08, 0.06, 0, -0.03, -0.008), jawLeft: at(0, -0.08, 0.06, 0.012, 0, 0),
    jawRight: at(0, -0.08, 0.06, -0.012, 0, 0), jawForward: at(0, -0.08, 0.06, 0, 0, 0.012),
    browDown: at(0.035, 0.055, 0.025, -0.003, -0.008, 0), browInnerUp: at(0.015, 0.06, 0.022, 0, 0.01, 0),
    browOuterUp: at(0.05, 0.055, 0.022, 0, 0.01, 0), cheekPuff: at(0.05, -0.03, 0.03, 0.01, 0, 0.006),
    cheekSquint: at(0.045, 0.005, 0.022, 0, 0.008, 0.003), eyeBlink: at(0.032, 0.042, 0.012, 0, -0.012, 0.004),
    noseSneer: at(0.012, 0.0, 0.015, 0, 0.008, 0.003),
  };
  if (table[stem]) return table[stem];
  if (stem.startsWith("eye")) return at(0.032, 0.035, 0.016, 0, 0.004, 0.002);
  const smile = stem === "mouthSmile" || stem === "mouthDimple" || stem === "mouthStretch";
  if (side) return at(0.024, -0.04, 0.02, smile ? 0.009 : 0.002, stem === "mouthFrown" ? -0.008 : smile ? 0.008 : 0.004, 0);
  return at(0, -0.042, 0.025, stem === "mouthLeft" ? 0.012 : stem === "mouthRight" ? -0.012 : 0, 0, 0.006);
}

const spellings = {
  ict: (name) => name,
  arkit: (name) => name.replace(/_L$/, "Left").replace(/_R$/, "Right"),
  pascal: (name) => spellings.arkit(name)[0].toUpperCase() + spellings.arkit(name).slice(1),
};

/**
 * @param {{names?: "ict" | "arkit" | "pascal", vrm?: boolean, scale?: number, without?: string[], pictures?: boolean}} how
 *   `pictures`: of its skin, which lie beside it
 * @returns {Buffer} the bytes of a .glb
 */
export function sphereHead({ names = "ict", vrm = false, scale = 1, without = [], pictures = false } = {}) {
  const json = {
    asset: { version: "2.0", generator: "mien page tests" },
    buffers: [], bufferViews: [], accessors: [], meshes: [], nodes: [], materials: [], scenes: [{ nodes: [] }], scene: 0,
  };
  const chunks = [];
  let length = 0;
  const store = (array, target) => {
    const bytes = Buffer.from(array.buffer, array.byteOffset, array.byteLength);
    json.bufferViews.push({ buffer: 0, byteOffset: length, byteLength: bytes.length, ...(target ? { target } : {}) });
    const padded = Buffer.concat([bytes, Buffer.alloc((4 - (bytes.length % 4)) % 4)]);
    chunks.push(padded);
    length += padded.length;
    return json.bufferViews.length - 1;
  };
  const vectors = (array) => {
    const min = [Infinity, Infinity, Infinity], max = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < array.length; ++i) {
      min[i % 3] = Math.min(min[i % 3], array[i]);
      max[i % 3] = Math.max(max[i % 3], array[i]);
    }
    json.accessors.push({ bufferView: store(array, 34962), componentType: 5126, count: array.length / 3, type: "VEC3", min, max });
    return json.accessors.length - 1;
  };
  const indices = (array) => {
    json.accessors.push({ bufferView: store(array, 34963), componentType: 5125, count: array.length, type: "SCALAR" });
    return json.accessors.length - 1;
  };

  const egg = ball(64, 48, [0.075, 0.12, 0.095], [0, 0, 0]);
  const shapes = SHAPES.filter((name) => !without.includes(name));
  const targets = shapes.map((name) => {
    const { x, y, radius, d } = pull(name);
    const out = new Float32Array(egg.positions.length);
    for (let i = 0; i < out.length; i += 3) {
      if (egg.positions[i + 2] < 0) continue;
      const r = Math.hypot(egg.positions[i] - x, egg.positions[i + 1] - y) / radius;
      const share = Math.exp(-r * r) * scale;
      for (let k = 0; k < 3; ++k) out[i + k] = d[k] * share;
    }
    return out;
  });
  const eye = ball(24, 16, [0.012, 0.012, 0.012], [0, 0, 0]);
  const scaled = (positions) => positions.map((value) => value * scale);
  json.materials.push(
    { name: "skin", pbrMetallicRoughness: { baseColorFactor: [0.72, 0.52, 0.42, 1], metallicFactor: 0, roughnessFactor: 0.5 } },
    { name: "sclera", pbrMetallicRoughness: { baseColorFactor: [0.9, 0.9, 0.88, 1], metallicFactor: 0, roughnessFactor: 0.1 } },
    { name: "iris", pbrMetallicRoughness: { baseColorFactor: [0.1, 0.2, 0.25, 1], metallicFactor: 0, roughnessFactor: 0.1 } },
  );
  const attributes = { POSITION: vectors(scaled(egg.positions)), NORMAL: vectors(egg.normals) };
  if (pictures) {
    const uv = new Float32Array((egg.positions.length / 3) * 2).fill(0.5);
    json.accessors.push({ bufferView: store(uv, 34962), componentType: 5126, count: uv.length / 2, type: "VEC2" });
    attributes.TEXCOORD_0 = json.accessors.length - 1;
    json.materials[0].extras = { albedo: "face_albedo.jpg", roughness: "face_roughness.jpg", normal: "face_normal.jpg" };
  }
  const spelt = shapes.map(spellings[names]);
  json.meshes.push({
    name: "face",
    extras: { targetNames: vrm ? shapes.map((_, i) => `target${i}`) : spelt },
    primitives: [{
      attributes, indices: indices(egg.triangles), material: 0, targets: targets.map((target) => ({ POSITION: vectors(target) })),
    }],
  });
  const eyeIndices = [indices(eye.triangles.filter((_, i) => !eye.iris[Math.floor(i / 3)])), indices(eye.triangles.filter((_, i) => eye.iris[Math.floor(i / 3)]))];
  const eyeAttributes = { POSITION: vectors(scaled(eye.positions)), NORMAL: vectors(eye.normals) };
  json.meshes.push({
    name: "eye",
    primitives: [1, 2].map((material) => ({ attributes: eyeAttributes, indices: eyeIndices[material - 1], material })),
  });
  json.nodes.push({ name: "face", mesh: 0 });
  for (const [name, side] of [["eye_L", 1], ["eye_R", -1]]) {
    json.nodes.push({ name, mesh: 1, translation: [0.032 * side * scale, 0.036 * scale, 0.075 * scale] });
  }
  json.nodes.push({ name: "root", children: [0, 1, 2] });
  json.scenes[0].nodes = [3];
  if (vrm) addVrm(json, spelt);

  json.buffers.push({ byteLength: length });
  const text = Buffer.from(JSON.stringify(json));
  const head = Buffer.concat([text, Buffer.alloc((4 - (text.length % 4)) % 4, 0x20)]);
  const part = (type, bytes) => {
    const start = Buffer.alloc(8);
    start.writeUInt32LE(bytes.length, 0);
    start.writeUInt32LE(type, 4);
    return Buffer.concat([start, bytes]);
  };
  const body = Buffer.concat([part(0x4e4f534a, head), part(0x004e4942, Buffer.concat(chunks))]);
  const header = Buffer.alloc(12);
  header.writeUInt32LE(0x46546c67, 0);
  header.writeUInt32LE(2, 4);
  header.writeUInt32LE(12 + body.length, 8);
  return Buffer.concat([header, body]);
}

/** The bones that VRM 1.0 demands, the shapes as custom expressions, and terms of use that say nothing. */
function addVrm(json, expressions) {
  const bones = ["hips", "spine", "head", "leftUpperArm", "leftLowerArm", "leftHand", "rightUpperArm", "rightLowerArm", "rightHand",
    "leftUpperLeg", "leftLowerLeg", "leftFoot", "rightUpperLeg", "rightLowerLeg", "rightFoot"];
  const first = json.nodes.length;
  const humanBones = {};
  bones.forEach((bone, i) => {
    json.nodes.push({ name: `bone_${bone}`, translation: [0, bone === "hips" ? -0.6 : 0.2, 0] });
    humanBones[bone] = { node: first + i };
  });
  json.nodes[first].children = [first + 1];
  json.nodes[first + 1].children = [first + 2, first + 3, first + 6, first + 9, first + 12];
  json.nodes[first + 1].translation = [0, 0.35, 0];
  json.nodes[first + 2].translation = [0, 0.25, 0];
  json.nodes[first + 2].children = [3];
  for (const chain of [3, 6, 9, 12]) {
    json.nodes[first + chain].children = [first + chain + 1];
    json.nodes[first + chain + 1].children = [first + chain + 2];
  }
  json.scenes[0].nodes = [first];
  json.extensionsUsed = ["VRMC_vrm"];
  json.extensions = {
    VRMC_vrm: {
      specVersion: "1.0",
      meta: { name: "Egg", version: "1", authors: ["Mien"], licenseUrl: "https://vrm.dev/licenses/1.0/" },
      humanoid: { humanBones },
      expressions: {
        preset: {},
        custom: Object.fromEntries(expressions.map((name, index) => [name, { morphTargetBinds: [{ node: 0, index, weight: 1 }] }])),
      },
    },
  };
}

function ball(around, down, radii, centre) {
  const positions = [], normals = [], triangles = [], iris = [];
  for (let j = 0; j <= down; ++j) {
    for (let i = 0; i <= around; ++i) {
      const polar = (Math.PI * j) / down, azimuth = (2 * Math.PI * i) / around;
      const n = [Math.sin(polar) * Math.sin(azimuth), Math.cos(polar), Math.sin(polar) * Math.cos(azimuth)];
      n.forEach((value, k) => positions.push(value * radii[k] + centre[k]));
      const slope = n.map((value, k) => value / radii[k]);
      const size = Math.hypot(...slope);
      normals.push(...slope.map((value) => value / size));
    }
  }
  for (let j = 0; j < down; ++j) {
    for (let i = 0; i < around; ++i) {
      const a = j * (around + 1) + i, b = a + around + 1;
      const front = positions[3 * a + 2] > 0.8 * radii[2];
      triangles.push(a, b, a + 1, a + 1, b, b + 1);
      iris.push(front, front);
    }
  }
  return { positions: Float32Array.from(positions), normals: Float32Array.from(normals), triangles: Uint32Array.from(triangles), iris };
}
