// The whole recording from the page, in a real browser against the program and a virtual performer with a virtual phone:
// consent, a script, a take, a video beside it, and a training on it.
//
//   npm run build && MIEN_PROGRAM=../build/release/app/mien npm run test:recording
//
//   MIEN_PROGRAM      the program, with its page and its trainer (../build/release/app/mien)
//   MIEN_CHROMIUM, MIEN_SCREENSHOTS: as dataset.test.mjs has them
import assert from "node:assert/strict";
import { execFile, spawn } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { promisify } from "node:util";
import { GL, launch, openPage, PATIENCE, settled } from "./browser.mjs";

const run = promisify(execFile);
const root = fileURLToPath(new URL("../../", import.meta.url));
const program = process.env.MIEN_PROGRAM ?? join(root, "build/release/app/mien");
const pictures = process.env.MIEN_SCREENSHOTS ?? "";
if (pictures) mkdirSync(pictures, { recursive: true });
/** Not those that a session or another test would take. */
const PORTS = { sensors: 15105, phone: 15106, page: 15107 };

/** Chromium draws what a camera would see. */
const WITH_CAMERA = ["--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream"];

let browser, folder;
const children = [];
const troubles = [];

before(async () => {
  assert.ok(existsSync(program), `There is no program at ${program}; MIEN_PROGRAM says where it is.`);
  folder = mkdtempSync(join(tmpdir(), "mien_recording_"));
  browser = await launch(...GL, ...WITH_CAMERA);
});
after(async () => {
  await browser?.close();
  for (const child of children) child.kill("SIGKILL");
  if (folder) rmSync(folder, { recursive: true, force: true });
});

/** Starts it; `said` has all that it prints. */
function start(...args) {
  const child = spawn(program, args, { stdio: ["ignore", "pipe", "pipe"] });
  child.said = "";
  for (const stream of [child.stdout, child.stderr]) stream.on("data", (bytes) => (child.said += bytes));
  children.push(child);
  return child;
}

const picture = async (page, name) => {
  if (pictures) await page.screenshot({ path: join(pictures, `recording_${name}.png`), timeout: PATIENCE });
};
const button = (page, name) => page.locator(".recorder").getByRole("button", { name });
const step = (page, name) => settled(page, (wanted) => document.querySelector(".recorder[open]")?.dataset.step === wanted, name, name);

/** Enough to see that it trains, and not to learn anything. */
const RECIPE = `
seed = 1
[network]
architecture = "causal"
layers = 1
d_model = 32
window = 120
dropout = 0
[takes]
share = 1
[optimiser]
batch = 4
warm_up_steps = 1
[validation]
windows = 8
every_steps = 3
[budget]
steps = 3
`;

test("what is recorded from the page alone is a dataset that trains", { timeout: 15 * PATIENCE }, async () => {
  const session = start("live", "--rig", join(root, "rigs/imu_microphone.toml"), "--listen", `udp://127.0.0.1:${PORTS.sensors}`, "--listen", `livelink://127.0.0.1:${PORTS.phone}`, "--phone", "truth", "--audio", "network", "--page", `127.0.0.1:${PORTS.page}`, "--takes", folder);
  const url = `http://127.0.0.1:${PORTS.page}/`;
  for (let tries = 0; !session.said.includes("Ctrl-C") && tries < 300; ++tries) await new Promise((soon) => setTimeout(soon, 100));
  start("perform", "--rig", join(root, "rigs/imu_microphone.toml"), "--script", "reading", "--seconds", "600", "--seed", "31", "--to", `udp://127.0.0.1:${PORTS.sensors}`, "--phone", `127.0.0.1:${PORTS.phone}`);
  const page = await openPage(browser, url, troubles, { viewport: { width: 1280, height: 800 }, colorScheme: "dark" });
  await settled(page, () => document.querySelectorAll(".links tbody tr").length === 14, `a status: ${session.said}`);
  // Until it has calibrated itself by the performer's neutral, nod and shake.
  await new Promise((soon) => setTimeout(soon, 16_000));

  await page.getByRole("tab", { name: "Takes" }).click();
  await page.getByRole("button", { name: "Record a dataset…" }).click();
  await step(page, "what");
  await page.getByLabel("Name of the new dataset").fill("faces");
  await page.getByLabel("Name or code of the performer").fill("Vera 31");
  await page.getByText("To try it, English").click();
  await picture(page, "what");
  await button(page, "Continue").click();
  await step(page, "consent");
  await page.getByLabel("Recorded by").fill("the project's tests");
  await page.getByLabel("What for").fill("to see that a recording trains");
  await page.getByLabel(/the sound of my voice/).check();
  await page.getByLabel(/my face on video/).check();
  await page.getByLabel(/I have read this/).check();
  await picture(page, "consent");
  await button(page, "Begin").click();

  for (let block = 0; block < 3; ++block) {
    await step(page, "check");
    if (block === 0) await picture(page, "check");
    await page.keyboard.press("Enter");
    await step(page, "lines");
    // Each text for so long as it is read; poses run by themselves.
    for (;;) {
      await settled(page, () => document.querySelector(".recorder")?.dataset.step !== "lines" || document.querySelector(".tele")?.dataset.state === "running", "a line");
      if ((await page.locator(".recorder").getAttribute("data-step")) !== "lines") break;
      const own = await button(page, "Next").isEnabled();
      const line = await page.locator(".tele").innerText();
      if (block === 0 && own) await picture(page, "line");
      await new Promise((soon) => setTimeout(soon, 3200));
      if (own) await page.keyboard.press("Enter");
      await settled(page, (was) => document.querySelector(".recorder")?.dataset.step !== "lines" || document.querySelector(".tele")?.innerText !== was, "the next one", line);
    }
    if (block === 2) break;
  }
  // Poor lines are asked for again; once is enough here.
  if ((await page.locator(".recorder").getAttribute("data-step")) !== "summary") await page.getByRole("button", { name: /^End/ }).click();
  await page.waitForTimeout(1500);
  await picture(page, "end");
  await page.close();
  await new Promise((ended) => {
    session.on("exit", ended);
    session.kill("SIGINT");
  });

  const takes = readdirSync(join(folder, "faces")).filter((name) => name.endsWith(".mien"));
  assert.ok(takes.length === 1 && takes[0].startsWith("Vera_31_"), `${takes}: ${session.said}`);
  const { stdout } = await run(program, ["dataset", join(folder, "faces"), "--json"]);
  const dataset = JSON.parse(stdout);
  if (pictures) writeFileSync(join(pictures, "recording_dataset.json"), stdout);
  assert.equal(dataset.takes.length, 1, stdout);
  const [video] = dataset.takes[0].videos;
  assert.equal(video?.file, takes[0].replace(/mien$/, "webm"), stdout);
  assert.ok(video.bytes > 100_000, stdout);
  const recipe = join(folder, "recipe.toml");
  writeFileSync(recipe, RECIPE);
  const model = join(folder, "mine.safetensors");
  const trained = await run(program, ["train", recipe, "--takes", join(folder, "faces"), "--out", model, "--threads", "1"]);
  assert.ok(existsSync(model), trained.stderr);
  assert.deepEqual(troubles, []);
});
