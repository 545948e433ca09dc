// A browser's microphone, in a real browser with a made-up one: heard, stopped, taken over, switched off and refused.
//
//   npm run build && npm run test:page
//
//   MIEN_CHROMIUM     the browser (/usr/bin/chromium)
//   MIEN_SCREENSHOTS  a folder that keeps what was seen
//   MIEN_PROGRAM      the program: then it hears the browser too, not only the mock session
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { GL, launch, openPage, PATIENCE, settled } from "./browser.mjs";
import { startMockSession } from "./mock_session.mjs";

const pictures = process.env.MIEN_SCREENSHOTS ?? "";
if (pictures) mkdirSync(pictures, { recursive: true });

/** It beeps once a second, and whoever asks for it gets it. */
const WITH_MICROPHONE = ["--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream"];
const use = (page) => page.getByRole("button", { name: "Use this browser's microphone" });
const stop = (page) => page.locator(".voice").getByRole("button", { name: "Stop" });

async function voiceOf(browser, url, troubles) {
  const page = await openPage(browser, url, troubles);
  // What the page gets of the browser, to see that it lets it go.
  await page.evaluate(() => {
    const devices = navigator.mediaDevices;
    const ask = devices?.getUserMedia.bind(devices);
    globalThis.tracks = [];
    if (ask) devices.getUserMedia = async (what) => {
      const stream = await ask(what);
      globalThis.tracks.push(...stream.getTracks());
      return stream;
    };
  });
  await page.getByRole("tab", { name: "Output" }).click();
  await page.locator(".voice").scrollIntoViewIfNeeded();
  return page;
}

const tracksOf = (page) => page.evaluate(() => globalThis.tracks.map((track) => track.readyState));

async function picture(page, name) {
  if (pictures) await page.locator(".voice").screenshot({ path: join(pictures, `${name}.png`), timeout: PATIENCE });
}

/** The level moves: it was low and high. */
async function levelMoves(page) {
  await page.evaluate(() => {
    globalThis.levels = [];
    globalThis.watching = setInterval(() => globalThis.levels.push(Number(document.querySelector(".voice .level").getAttribute("aria-valuenow"))), 50);
  });
  await settled(page, () => Math.max(...globalThis.levels) > Math.min(...globalThis.levels) + 10, "a level that moves");
  await page.evaluate(() => clearInterval(globalThis.watching));
}

const heardSeconds = (page) => page.locator(".voice-browser .quiet").innerText().then((text) => Number(/(\d+) s of sound/.exec(text)?.[1] ?? 0));
const secondsHeard = (page, least) => settled(page, (s) => Number(/(\d+) s of sound/.exec(document.querySelector(".voice-browser .quiet").textContent)?.[1] ?? 0) >= s, "sound that is counted", least);

test("a browser's microphone is heard, stopped, taken over and switched off", { timeout: 6 * PATIENCE }, async (t) => {
  const troubles = [];
  const mock = await startMockSession({ quick: true, microphone: true });
  const browser = await launch(...GL, ...WITH_MICROPHONE);
  t.after(async () => {
    await browser.close();
    await mock.close();
  });
  const { hearing } = mock.session.voice;
  const page = await voiceOf(browser, mock.url, troubles);
  await settled(page, () => /No browser is heard yet/.test(document.querySelector(".voice").textContent), "a word on the browser");
  await picture(page, "voice_off");
  await use(page).click();
  await secondsHeard(page, 3);
  await levelMoves(page);
  await settled(page, () => Number(document.querySelector(".voice .level").getAttribute("aria-valuenow")) > 30, "a beep");
  await picture(page, "voice_on");
  assert.equal(hearing.browser.heard, true);
  assert.equal(hearing.browser.refused, 0);
  assert.ok(hearing.blocks >= 150, `${hearing.blocks} blocks`);
  assert.deepEqual(await tracksOf(page), ["live"]);

  await stop(page).click();
  await use(page).waitFor();
  assert.deepEqual(await tracksOf(page), ["ended"], "the browser's sign goes off");
  await settled(page, () => /No browser is heard yet/.test(document.querySelector(".voice").textContent), "nobody is heard");
  const blocks = hearing.blocks;
  await page.waitForTimeout(600);
  assert.equal(hearing.blocks, blocks, "nothing is sent any more");

  // Another browser takes its place, and it is told.
  await use(page).click();
  await stop(page).waitFor();
  const other = await voiceOf(browser, mock.url, troubles);
  await settled(other, () => /Another browser is heard/.test(document.querySelector(".voice").textContent), "the other one is known");
  await use(other).click();
  await stop(other).waitFor();
  await settled(page, () => /Another browser's microphone is heard instead/.test(document.querySelector(".voice").textContent), "the first is told");
  assert.deepEqual(await tracksOf(page), ["ended", "ended"]);
  await secondsHeard(other, 1 + Math.ceil(blocks / 50));
  await picture(page, "voice_taken");

  // The switch lets it go, wherever it was pressed.
  await page.getByRole("switch", { name: "Hear the voice" }).click();
  await use(other).waitFor();
  assert.deepEqual(await tracksOf(other), ["ended"]);
  await settled(other, () => [...document.querySelectorAll(".voice .button")].every((button) => button.disabled), "no button while it is off");
  assert.match(await other.locator(".voice").innerText(), /Sound is off/);
  await picture(other, "voice_switched_off");

  // What stands against hearing is said beside the switch.
  Object.assign(hearing, { on: true, trouble: "default: there is no such microphone; it is tried again each second", browser: null });
  await page.locator(".voice-trouble", { hasText: "there is no such microphone" }).waitFor();
  assert.equal(await use(page).isVisible(), false, "a session that hears no browser");
  await picture(page, "voice_trouble");
  Object.assign(hearing, { on: false, trouble: null, shut: true });
  await page.locator(".voice", { hasText: "every microphone shut (--no-audio)" }).waitFor();
  assert.equal(await page.getByRole("switch", { name: "Hear the voice" }).isVisible(), false);
  await picture(page, "voice_shut");
  assert.deepEqual(troubles, []);
});

test("a microphone that the browser refuses says what to do", { timeout: 4 * PATIENCE }, async (t) => {
  const troubles = [];
  const mock = await startMockSession({ quick: true, microphone: true });
  const browser = await launch(...GL, "--use-fake-device-for-media-stream", "--deny-permission-prompts");
  t.after(async () => {
    await browser.close();
    await mock.close();
  });
  const page = await voiceOf(browser, mock.url, troubles);
  await use(page).click();
  await page.locator(".voice .bad", { hasText: "Allow it for this page" }).waitFor();
  await picture(page, "voice_denied");
  assert.equal(mock.session.voice.hearing.browser.heard, false);
  assert.ok(!mock.session.commands.some(({ command }) => command === "microphone"), "the session is not even asked");

  // An insecure page has no microphone to ask for.
  await page.evaluate(() => Object.defineProperty(navigator, "mediaDevices", { configurable: true, value: undefined }));
  await use(page).click();
  await page.locator(".voice .bad", { hasText: "over HTTPS" }).waitFor();
  await picture(page, "voice_insecure");
  assert.deepEqual(troubles, []);
});

const program = process.env.MIEN_PROGRAM;
test("the program hears a browser", { timeout: 4 * PATIENCE, skip: !program && "MIEN_PROGRAM is not set" }, async (t) => {
  const troubles = [];
  const folder = mkdtempSync(join(tmpdir(), "mien_voice_"));
  const take = join(folder, "heard.mien");
  const run = (...more) => {
    const child = spawn(program, more, { stdio: ["ignore", "pipe", "pipe"] });
    const said = { out: "", err: "" };
    child.stdout.on("data", (bytes) => (said.out += bytes));
    child.stderr.on("data", (bytes) => (said.err += bytes));
    return { child, said, ended: new Promise((resolve) => child.once("close", resolve)) };
  };
  const session = run("live", "--listen", "udp://127.0.0.1:0", "--audio", "page", "--page", "127.0.0.1:0", "--record", take, "--json");
  const browser = await launch(...GL, ...WITH_MICROPHONE);
  t.after(async () => {
    await browser.close();
    session.child.kill("SIGINT");
    await session.ended;
    rmSync(folder, { recursive: true });
  });
  const deadline = Date.now() + PATIENCE;
  while (!/http:\S+/.test(session.said.err) && Date.now() < deadline) await new Promise((resolve) => setTimeout(resolve, 50));
  const page = await voiceOf(browser, /http:\S+/.exec(session.said.err)[0], troubles);
  await use(page).click();
  await secondsHeard(page, 4);
  await levelMoves(page);
  await picture(page, "voice_program");
  assert.doesNotMatch(await page.locator(".voice").innerText(), /refused/);
  const seconds = await heardSeconds(page);
  await stop(page).click();
  await use(page).waitFor();
  await page.getByRole("switch", { name: "Hear the voice" }).click();
  await page.locator(".voice", { hasText: "Sound is off" }).waitFor();
  session.child.kill("SIGINT");
  assert.equal(await session.ended, 0, session.said.err);
  const live = JSON.parse(session.said.out);
  assert.ok(live.datagrams >= 50 * (seconds - 1), `${live.datagrams} blocks`);
  assert.equal(live.malformed, 0);
  const replay = run("live", "--replay", take, "--json");
  await replay.ended;
  assert.equal(JSON.parse(replay.said.out).hash, live.hash, "a replay hears the same");
  assert.deepEqual(troubles, []);
});
