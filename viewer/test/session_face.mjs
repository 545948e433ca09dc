import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { sphereHead } from "./sphere_head.mjs";

/** The bytes of /face.glb. */
export function sessionFace(program = process.env.MIEN_PROGRAM) {
  if (!program) return sphereHead();
  const folder = mkdtempSync(join(tmpdir(), "mien_face_"));
  try {
    execFileSync(program, ["face", "export", "--textures", "none", "--out", join(folder, "face.glb")], { stdio: "ignore" });
    return readFileSync(join(folder, "face.glb"));
  } finally {
    rmSync(folder, { recursive: true });
  }
}
